#include "worker/printing/pdf_writer.hpp"

#include <zlib.h>

#include <new>

#include "api/base/decimal.hpp"

namespace vacuform {

std::string pdf_number(double value, int places) {
  std::string out = decimal(value, places);
  if (out.find('.') == std::string::npos) return out;
  out.erase(out.find_last_not_of('0') + 1);
  if (out.ends_with('.')) out.pop_back();
  return out;
}

// The second line tells programs that the file is not text.
PdfWriter::PdfWriter() { text("%PDF-1.5\n%\xe2\xe3\xcf\xd3\n"); }

void PdfWriter::text(const std::string& s) { bytes_.insert(bytes_.end(), s.begin(), s.end()); }

int PdfWriter::reserve() {
  offsets_.push_back(0);
  return static_cast<int>(offsets_.size());
}

void PdfWriter::object(int number, const std::string& body) {
  offsets_[number - 1] = bytes_.size();
  text(std::to_string(number) + " 0 obj\n" + body + "\nendobj\n");
}

int PdfWriter::object(const std::string& body) {
  const int number = reserve();
  object(number, body);
  return number;
}

int PdfWriter::stream(const std::string& dictionary, std::span<const std::uint8_t> bytes) {
  const int number = reserve();
  offsets_.back() = bytes_.size();
  text(std::to_string(number) + " 0 obj\n<< " + dictionary + " /Length " + std::to_string(bytes.size()) +
       " >>\nstream\n");
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  text("\nendstream\nendobj\n");
  return number;
}

int PdfWriter::deflated_stream(const std::string& dictionary, const std::string& content) {
  uLongf size = compressBound(content.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, reinterpret_cast<const Bytef*>(content.data()), content.size(), 6) !=
      Z_OK)
    throw std::bad_alloc();
  packed.resize(size);
  return stream(dictionary + " /Filter /FlateDecode", packed);
}

std::vector<std::uint8_t> PdfWriter::finish(int catalogue) {
  const std::size_t table = bytes_.size();
  const std::string count = std::to_string(offsets_.size() + 1);
  text(std::string("xref\n0 ") + count + "\n0000000000 65535 f \n");
  for (const std::size_t offset : offsets_) {
    const std::string digits = std::to_string(offset);
    text(std::string(10 - digits.size(), '0') + digits + " 00000 n \n");
  }
  text(std::string("trailer\n<< /Size ") + count + " /Root " + std::to_string(catalogue) +
       " 0 R >>\nstartxref\n" + std::to_string(table) + "\n%%EOF\n");
  return std::move(bytes_);
}

}  // namespace vacuform
