#include "api/names.hpp"

#include <algorithm>
#include <cctype>

#include "api/picture_names.hpp"
#include "api/text_names.hpp"

namespace vacuform {

namespace {

constexpr std::size_t head_size = 84;  // of a binary STL file: 80 bytes of anything, then the count

class AsItIs : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override { out += in; }
};

// 80 bytes of free text, and then none.
class BinaryStl : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    const std::size_t free = std::min<std::size_t>(80 - at_, in.size());
    out.append(free, ' ');
    out += in.substr(free);
    at_ += free;
  }

 private:
  std::size_t at_ = 0;
};

bool has_control(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 9; });
}

// Files that are taken for scans by mistake; what refuses them says what they are.
bool foreign(std::string_view head) {
  return head.starts_with("PK\x03\x04") || head.starts_with("\x1f\x8b") || head.starts_with("glTF") ||
         head.starts_with("Kaydara FBX");
}

std::unique_ptr<NameFilter::Format> format_of(std::string_view head, const std::string& extension) {
  if (head.starts_with("\x89PNG\r\n\x1a\n")) return png_names();
  if (head.starts_with("\xff\xd8\xff")) return jpeg_names();
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return text_names(TextKind::ply);
  const bool stl = extension == "stl" || extension.empty();
  // The count of a file of at most 1 GiB has a zero or a one in its highest byte, and no text has that.
  if (head.size() == head_size && has_control(head.substr(80)) && !foreign(head) && (stl || head.starts_with("solid")))
    return std::make_unique<BinaryStl>();
  if (has_control(head)) return std::make_unique<AsItIs>();
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  const std::string_view text = first == std::string_view::npos ? "" : head.substr(first);
  if (text.starts_with("solid")) return text_names(TextKind::stl);
  const std::size_t off = text.find("OFF");
  if (extension == "off" || off <= 4) return text_names(TextKind::off);
  constexpr std::string_view begins_obj = "#vfogusmlp";
  if ((extension == "obj" || extension.empty()) && !text.empty() &&
      begins_obj.find(text[0]) != std::string_view::npos)
    return text_names(TextKind::obj);
  return std::make_unique<AsItIs>();
}

}  // namespace

NameFilter::NameFilter(std::string extension) : extension_(std::move(extension)) {}
NameFilter::NameFilter(NameFilter&&) noexcept = default;
NameFilter::~NameFilter() = default;

std::string NameFilter::pass(std::string_view bytes) {
  std::string out;
  if (!format_) {
    const std::size_t wanted = std::min(head_size - head_.size(), bytes.size());
    head_ += bytes.substr(0, wanted);
    bytes.remove_prefix(wanted);
    if (head_.size() < head_size) return out;
    format_ = format_of(head_, extension_);
    format_->take(head_, out);
  }
  format_->take(bytes, out);
  return out;
}

std::string NameFilter::finish() {
  std::string out;
  if (!format_) {
    format_ = format_of(head_, extension_);
    format_->take(head_, out);
  }
  format_->end(out);
  return out;
}

void blank_names(std::vector<std::uint8_t>& bytes, const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string extension = dot == std::string::npos ? "" : file_name.substr(dot + 1);
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  NameFilter filter(std::move(extension));
  constexpr std::size_t step = 64 << 10;
  std::size_t done = 0;
  const auto keep = [&](const std::string& ready) {
    std::copy(ready.begin(), ready.end(), bytes.begin() + static_cast<std::ptrdiff_t>(done));
    done += ready.size();  // never beyond what was taken
  };
  for (std::size_t at = 0; at < bytes.size(); at += step)
    keep(filter.pass({reinterpret_cast<const char*>(bytes.data()) + at, std::min(step, bytes.size() - at)}));
  keep(filter.finish());
}

}  // namespace vacuform
