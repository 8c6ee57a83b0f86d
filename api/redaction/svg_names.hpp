// Names in SVG: what is no part of the drawing becomes blanks. That are comments, processing instructions, all text outside of
// <text> and <style> (so <title>, <desc>, <metadata> and what drawing programs keep for themselves), attributes of other
// namespaces than SVG's (sodipodi:docname, inkscape:label...), data-* and aria-* attributes, and references to other files.
// Pictures within, as base 64, go through a filter of their own. Ids, classes and visible text stay.
#pragma once

#include <memory>

#include "api/redaction/names.hpp"

namespace vacuform {

std::unique_ptr<NameFilter::Format> svg_names();

}  // namespace vacuform
