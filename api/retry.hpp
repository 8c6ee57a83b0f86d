// What the end of a failed attempt says of the next one.
#pragma once

namespace vacuform {

enum class Retry {
  never,        // the same input would be refused again
  after_fault,  // of the worker or its machine
  after_crash,  // the pipeline crashed, perhaps by this input
};

}  // namespace vacuform
