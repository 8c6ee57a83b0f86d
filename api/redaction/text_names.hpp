// Names in scans and tables that are text, line by line: what follows a comment sign, a "solid", an "o" or a "comment"
// becomes blanks, and so do whole lines of a table that begin with a comment sign. Lines keep their ends and their number.
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

enum class TextKind { stl, obj, ply, off, csv };
std::unique_ptr<NameFilter::Format> text_names(TextKind kind);

}  // namespace vacuform
