#include "worker/forming/process.hpp"

namespace vacuform {

Result<void> form_projection(const Process&, SheetState&, const Context&) {
  return fail(Code::bad_settings, "this model of the sheet is not there yet", "forming.model",
              "use membrane");
}

}  // namespace vacuform
