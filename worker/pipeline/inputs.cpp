#include "worker/pipeline/inputs.hpp"

#include <fstream>

namespace vacuform {

bool has_input(const Inputs& inputs, std::string_view name) {
  if (name == "scan") return !inputs.scan.bytes.empty();
  if (name == "pattern") return inputs.pattern && !inputs.pattern->bytes.empty();
  if (name == "temperature") return inputs.temperature.has_value();
  return name == "weights" ? inputs.weights.has_value() : inputs.icc.has_value();
}

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t limit) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    return fail(Code::unreadable, "there is no such file", path.string(), "check the name");
  const std::uint64_t size =
      std::filesystem::is_regular_file(status) ? std::filesystem::file_size(path, error) : 0;
  if (!std::filesystem::is_regular_file(status) || error)
    return fail(Code::unreadable, "not a readable file", path.string(), "give a regular file");
  if (size > limit)
    return fail(Code::too_large, "the file has " + std::to_string(size) + " bytes", path.string(),
                "give one of at most " + std::to_string(limit) + " bytes");
  std::vector<std::uint8_t> bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return fail(Code::unreadable, "the file cannot be read", path.string(), "check its permissions");
  return bytes;
}

}  // namespace vacuform
