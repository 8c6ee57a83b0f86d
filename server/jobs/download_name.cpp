#include "server/jobs/download_name.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/utf8.hpp"

namespace vacuform {

namespace {

constexpr std::size_t longest_part = 160;  // bytes of a reference in a name: file systems take 255 in all

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
         c == '-';
}

// Without the dots and dashes at the ends, which hide a file or look like an option.
std::string_view without_ends(std::string_view text) {
  constexpr std::string_view ends = ".-_ ";
  const std::size_t first = text.find_first_not_of(ends);
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(ends) + 1 - first);
}

std::string whole_part(const std::string& reference) {
  std::u32string points = code_points(reference).value_or(std::u32string());
  for (char32_t& c : points)
    if (c < ' ' || std::u32string_view(U"/\\:*?\"<>|%").find(c) != std::u32string_view::npos) c = '-';
  while (utf8(points).size() > longest_part) points.pop_back();
  return std::string(without_ends(utf8(points)));
}

// One dash for each run of other characters.
std::string plain_part(const std::string& whole) {
  std::string out;
  for (const char c : whole)
    if (is_plain(c) && c != '-')
      out += c;
    else if (!out.ends_with('-'))
      out += '-';
  return std::string(without_ends(out));
}

// What follows the reference.
std::string tail_of(const Job& job, std::string_view artifact) {
  std::string tail("-");
  if (artifact.starts_with("print.")) {
    const auto settings = nlohmann::json::parse(job.settings, nullptr, false);
    const auto face = nlohmann::json::json_pointer("/pattern/inked_face");
    tail += settings.is_object() && settings.value(face, std::string()) == "inner" ? "inner-" : "outer-";
  }
  return tail.append(artifact);
}

std::string id_part(const Job& job) {
  return job.id.substr(job.id.size() - std::min<std::size_t>(8, job.id.size()));
}

std::string or_id(std::string part, const Job& job) { return part.empty() ? id_part(job) : part; }

}  // namespace

std::string download_name(const Job& job, std::string_view artifact) {
  return or_id(whole_part(job.reference), job) + tail_of(job, artifact);
}

std::string content_disposition(std::string_view how, const Job& job, std::string_view artifact) {
  const std::string whole = download_name(job, artifact),
                    plain = or_id(plain_part(whole_part(job.reference)), job) + tail_of(job, artifact);
  std::string value = std::string(how) + "; filename=\"" + plain + "\"";
  if (whole == plain) return value;
  value += "; filename*=UTF-8''";
  for (const char c : whole) {
    const auto byte = static_cast<unsigned char>(c);
    if (is_plain(c))
      value += c;
    else
      value.append({'%', "0123456789ABCDEF"[byte >> 4], "0123456789ABCDEF"[byte & 15]});
  }
  return value;
}

}  // namespace vacuform
