// A PDF, written object by object: deflated streams, no dates, no identifiers, the same bytes for the same
// input. Internal to worker/printing. After ISO 32000-1.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vacuform {

// A number as PDF writes it, without needless zeros.
std::string pdf_number(double value, int places = 4);

class PdfWriter {
 public:
  PdfWriter();

  int reserve();  // the number of an object that is written later; objects are referred to as "<number> 0 R"
  void object(int number, const std::string& body);
  int object(const std::string& body);
  // `dictionary` holds the entries besides Length. `bytes` are written as they are.
  int stream(const std::string& dictionary, std::span<const std::uint8_t> bytes);
  // The same, but compressed here.
  int deflated_stream(const std::string& dictionary, const std::string& text);

  std::vector<std::uint8_t> finish(int catalogue);  // once, after every object

 private:
  void text(const std::string& s);
  std::vector<std::uint8_t> bytes_;
  std::vector<std::size_t> offsets_;  // of object number i + 1
};

}  // namespace vacuform
