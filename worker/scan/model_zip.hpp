// The files of a model that came as a zip: an OBJ with its MTL, or a PLY, and images. Internal to worker/scan.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "worker/scan/scan_file.hpp"

namespace vacuform {

struct ModelFiles {
  bool ply = false;  // else the model is an OBJ
  std::vector<std::uint8_t> model, library;
  std::map<std::string, std::vector<std::uint8_t>, std::less<>>
      images;  // by the names that the other files use for them
};

// Reads an archive whose names were removed (api/redaction/redaction.hpp): model.obj or model.ply, model.mtl, texture-1
// and so on. Without colours only the model is unpacked. Errors: corrupt_file (damaged, or another entry), too_large,
// unsupported_format (encrypted), cancelled.
Result<ModelFiles> read_model_zip(Bytes bytes, const std::string& where, const ScanProgress& progress,
                                  ScanParts parts);

}  // namespace vacuform
