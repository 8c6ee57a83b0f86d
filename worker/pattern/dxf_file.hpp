// A DXF in ASCII as its parts (Autodesk, DXF Reference, R12 to 2018): units, layers, blocks and entities, without their
// geometry. Internal to worker/pattern. Own code, because libdxfrw reads files by their names only and not bytes, and reports
// no error but "failed".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/error.hpp"

namespace vacuform {

// A group code and its value, which points into the text.
struct DxfGroup {
  int code = 0;
  std::string_view value;
};

struct DxfEntity {
  std::string_view type;
  std::vector<DxfGroup> groups;
  std::vector<DxfEntity> vertices;  // of a POLYLINE

  std::string_view text(int code) const;  // of the first group of that code; empty if there is none
  std::optional<double> number(int code) const;
  double number_or(int code, double otherwise) const { return number(code).value_or(otherwise); }
  std::vector<double> numbers(int code) const;
};

struct DxfLayer {
  bool drawn = true;           // neither off nor frozen
  std::optional<double> line;  // line weight, mm; nothing: the program's default
};

struct DxfBlock {
  double x = 0, y = 0;  // its base point
  std::vector<DxfEntity> entities;
};

struct DxfFile {
  int units = 0;  // $INSUNITS
  std::map<std::string_view, DxfLayer> layers;
  std::map<std::string_view, DxfBlock> blocks;
  std::vector<DxfEntity> entities;  // of the model
  std::size_t on_paper = 0;         // entities of layouts, which are left out
};

bool begins_dxf(std::string_view text);

// Keeps pointers into `text`. Errors: corrupt_file with the line, too_large (2 million groups).
Result<DxfFile> read_dxf_file(std::string_view text, const std::string& file_name);

// A number; nothing for anything else.
std::optional<double> dxf_number(std::string_view value);

}  // namespace vacuform
