#include "api/redaction/names.hpp"

#include <algorithm>
#include <cctype>

#include "api/base/text.hpp"
#include "api/redaction/glb_names.hpp"
#include "api/redaction/picture_names.hpp"
#include "api/redaction/svg_names.hpp"
#include "api/redaction/text_names.hpp"
#include "api/redaction/zip_names.hpp"

namespace vacuform {

namespace {

constexpr std::size_t head_size = 84;  // of a binary STL file: 80 bytes of anything, then the count

class AsItIs : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override { out += in; }
};

// 80 bytes of free text, the number of triangles, 50 bytes for each, and nothing that anybody reads.
class BinaryStl : public NameFilter::Format {
 public:
  void take(std::string_view in, std::string& out) override {
    for (; at_ < head_size && !in.empty(); ++at_, in.remove_prefix(1)) {
      out += at_ < 80 ? ' ' : in[0];
      if (at_ >= 80) left_ |= std::uint64_t{static_cast<unsigned char>(in[0])} << (8 * (at_ - 80));
      if (at_ + 1 == head_size) left_ *= 50;
    }
    const auto kept = static_cast<std::size_t>(std::min<std::uint64_t>(left_, in.size()));
    if (at_ == head_size) left_ -= kept;
    out += in.substr(0, kept);
    out.append(in.size() - kept, '\0');
  }
  void fields(FilterState& state) override { state(at_, left_); }

 private:
  std::size_t at_ = 0;      // within the head
  std::uint64_t left_ = 0;  // bytes of triangles
};

bool has_control(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 9; });
}

// Files that are taken for scans by mistake; what refuses them says what they are.
bool foreign(std::string_view head) {
  return head.starts_with("PK\x03\x04") || head.starts_with("\x1f\x8b") || head.starts_with("Kaydara FBX");
}

}  // namespace

NameFilter::Kind NameFilter::kind_of(std::string_view head, const std::string& extension) {
  if (head.starts_with("\x89PNG\r\n\x1a\n")) return Kind::png;
  if (head.starts_with("\xff\xd8\xff")) return Kind::jpeg;
  if (head.starts_with("glTF")) return Kind::glb;
  if (head.starts_with("PK\x03\x04") && extension == "zip") return Kind::zip;
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return Kind::ply;
  const bool stl = extension == "stl" || extension.empty();
  // The count of a file of at most 1 GiB has a zero or a one in its highest byte, and no text has that.
  if (head.size() == head_size && has_control(head.substr(80)) && !foreign(head) &&
      (stl || head.starts_with("solid")))
    return Kind::binary_stl;
  if (has_control(head)) return Kind::as_it_is;
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);  // a mark of UTF-8
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  const std::string_view text = first == std::string_view::npos ? "" : head.substr(first);
  if (text.starts_with('<')) return Kind::svg;
  if (text.starts_with("solid")) return Kind::text_stl;
  if (extension == "csv" || extension == "txt") return Kind::csv;
  const std::size_t off = text.find("OFF");
  if (extension == "off" || off <= 4) return Kind::off;
  if (text.starts_with("v ") || text.starts_with("mtllib ")) return Kind::obj;
  constexpr std::string_view begins_obj = "#vfogusmlp";
  if ((extension == "obj" || extension.empty()) && !text.empty() &&
      begins_obj.find(text[0]) != std::string_view::npos)
    return Kind::obj;
  return Kind::as_it_is;
}

std::unique_ptr<NameFilter::Format> NameFilter::format_of(Kind kind) {
  switch (kind) {
    case Kind::binary_stl:
      return std::make_unique<BinaryStl>();
    case Kind::text_stl:
      return text_names(TextKind::stl);
    case Kind::obj:
      return text_names(TextKind::obj);
    case Kind::ply:
      return text_names(TextKind::ply);
    case Kind::off:
      return text_names(TextKind::off);
    case Kind::csv:
      return text_names(TextKind::csv);
    case Kind::glb:
      return glb_names();
    case Kind::png:
      return png_names();
    case Kind::jpeg:
      return jpeg_names();
    case Kind::svg:
      return svg_names();
    case Kind::zip:
      return zip_names();
    case Kind::unknown:
    case Kind::as_it_is:
      break;
  }
  return std::make_unique<AsItIs>();
}

NameFilter::NameFilter(std::string extension) : extension_(std::move(extension)) {}
NameFilter::NameFilter(NameFilter&&) noexcept = default;
NameFilter::~NameFilter() = default;

void NameFilter::begin(std::string& out) {
  kind_ = kind_of(head_, extension_);
  format_ = format_of(kind_);
  format_->take(head_, out);
  head_.clear();
}

std::string NameFilter::pass(std::string_view bytes) {
  std::string out;
  if (!format_) {
    const std::size_t wanted = std::min(head_size - head_.size(), bytes.size());
    head_ += bytes.substr(0, wanted);
    bytes.remove_prefix(wanted);
    if (head_.size() < head_size) return out;
    begin(out);
  }
  format_->take(bytes, out);
  return out;
}

std::string NameFilter::finish() {
  std::string out;
  if (!format_) begin(out);
  format_->end(out);
  return out;
}

Result<void> NameFilter::check() const {
  auto problem = format_ ? format_->problem() : std::nullopt;
  if (problem) return tl::make_unexpected(*std::move(problem));
  return {};
}

std::string NameFilter::state() const {
  FilterState state;
  Kind kind = kind_;
  std::string head = head_;
  state(kind, head);
  if (format_) format_->fields(state);
  return state.text();
}

bool NameFilter::go_on(std::string_view text) {
  FilterState state(text);
  state(kind_, head_);
  if (!state.good() || kind_ < Kind::unknown || kind_ > Kind::svg) return false;
  format_ = kind_ == Kind::unknown ? nullptr : format_of(kind_);
  if (format_) format_->fields(state);
  return state.ended();
}

Result<void> blank_names(std::vector<std::uint8_t>& bytes, const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  NameFilter filter(dot == std::string::npos ? "" : lower(file_name.substr(dot + 1)));
  constexpr std::size_t step = 64 << 10;
  std::size_t done = 0;
  std::vector<std::uint8_t> beyond;  // of a file that grows, once it is longer than what was taken
  const auto keep = [&](const std::string& ready, std::size_t taken) {
    const std::size_t in_place = beyond.empty() ? std::min(ready.size(), taken - done) : 0;
    std::copy_n(ready.begin(), in_place, bytes.begin() + static_cast<std::ptrdiff_t>(done));
    done += in_place;
    beyond.insert(beyond.end(), ready.begin() + static_cast<std::ptrdiff_t>(in_place), ready.end());
  };
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    const std::size_t n = std::min(step, bytes.size() - at);
    keep(filter.pass({reinterpret_cast<const char*>(bytes.data()) + at, n}), at + n);
    VACUFORM_CHECK(filter.check());
  }
  keep(filter.finish(), bytes.size());
  VACUFORM_CHECK(filter.check());
  bytes.resize(done);
  bytes.insert(bytes.end(), beyond.begin(), beyond.end());
  return {};
}

}  // namespace vacuform
