#include "worker/agent/job_log.hpp"

#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/base/json_text.hpp"

namespace vacuform {

namespace {

constexpr std::size_t most_lines = 200, most_codes = 50, longest_code = 40;
constexpr int most_serious = 1000;  // that the server takes
constexpr std::uint64_t largest_report = 4 << 20;

bool is_code(const std::string& text) {
  return !text.empty() && text.size() <= longest_code &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
}

}  // namespace

void JobLog::say(std::string line) {
  const std::lock_guard hold(mutex_);
  if (lines_.size() < most_lines) lines_.push_back(std::move(line));
}

Result<void> JobLog::send(WorkerClient& client, const Lease& lease, const Going& going) {
  const std::lock_guard one_at_a_time(sending_);
  std::vector<std::string> lines;
  {
    const std::lock_guard hold(mutex_);
    lines.assign(lines_.begin() + static_cast<std::ptrdiff_t>(sent_), lines_.end());
  }
  if (lines.empty()) return {};
  VACUFORM_CHECK(client.log(lease, sent_, lines, going));
  const std::lock_guard hold(mutex_);
  sent_ += lines.size();
  return {};
}

ReportedWarnings reported_warnings(const JobFile& report) {
  if (report.bytes > largest_report) return {};
  std::string text(report.bytes, '\0');
  const ssize_t size = ::pread(report.descriptor.number(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  if (!within(text, {})) return {};
  const auto object = nlohmann::json::parse(text, nullptr, false);
  ReportedWarnings found;
  if (!object.is_object() || !object.contains("warnings") || !object["warnings"].is_array()) return found;
  found.serious = 0;
  for (const auto& warning : object["warnings"]) {
    if (!warning.is_object()) continue;
    if (warning.value("severity", nlohmann::json()) == "serious" && *found.serious < most_serious)
      ++*found.serious;
    if (!warning.contains("code") || !warning["code"].is_string()) continue;
    if (const auto code = warning["code"].get<std::string>();
        is_code(code) && found.codes.size() < most_codes)
      found.codes.push_back(code);
  }
  return found;
}

}  // namespace vacuform
