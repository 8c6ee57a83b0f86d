#include "worker/agent/job_group.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace vacuform {

namespace {

namespace fs = std::filesystem;

constexpr const char* prefix = "job-";

// The kernel takes a value in one write and answers with an error.
bool put(const fs::path& file, const std::string& value) {
  const Descriptor open(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  return open && ::write(open.number(), value.data(), value.size()) == static_cast<ssize_t>(value.size());
}

std::vector<std::string> words_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istream_iterator<std::string>(in), {}};
}

// Kills what is in a group and removes it: a killed process leaves it within milliseconds.
void remove_group(const fs::path& folder) {
  put(folder / "cgroup.kill", "1");
  for (int i = 0; i < 100 && ::rmdir(folder.c_str()) != 0 && errno == EBUSY; ++i) ::poll(nullptr, 0, 10);
}

// Where cgroup v2 is mounted, and the group of this process in it; empty without.
fs::path own_group() {
  std::ifstream mounts("/proc/self/mounts"), groups("/proc/self/cgroup");
  fs::path mount;
  for (std::string device, where, type, rest;
       mounts >> device >> where >> type && std::getline(mounts, rest);)
    if (type == "cgroup2") mount = where;
  for (std::string line; std::getline(groups, line);)
    if (line.starts_with("0::/")) return mount.empty() ? fs::path() : mount / line.substr(4);
  return {};
}

}  // namespace

JobGroup::~JobGroup() {
  if (processes_) remove_group(folder_);
}

bool JobGroup::ran_out_of_memory() const {
  const auto words = words_of(folder_ / "memory.events");
  const auto found = std::find(words.begin(), words.end(), "oom_kill");
  return found != words.end() && found + 1 != words.end() && found[1] != "0";
}

std::optional<JobGroups> JobGroups::delegated() {
  const fs::path own = own_group();
  char value = 0;
  if (own.empty() || ::getxattr(own.c_str(), "user.delegate", &value, 1) != 1 || value != '1') return {};
  auto groups = in(own);
  return groups ? std::optional(std::move(*groups)) : std::nullopt;
}

Result<JobGroups> JobGroups::in(const fs::path& folder) {
  const fs::path leaf = folder / "worker";
  if ((::mkdir(leaf.c_str(), 0755) != 0 && errno != EEXIST) || !put(leaf / "cgroup.procs", "0"))
    return fail(Code::unreadable, "the worker cannot move to a control group of its own", leaf.string(),
                "delegate the group to the worker's user");
  JobGroups groups;
  groups.folder_ = folder;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable))
    if (entry.path().filename().string().starts_with(prefix)) remove_group(entry.path());
  const auto offered = words_of(folder / "cgroup.controllers");
  for (const char* controller : {"memory", "pids"})
    if (std::find(offered.begin(), offered.end(), controller) != offered.end() &&
        put(folder / "cgroup.subtree_control", "+" + std::string(controller)))
      groups.controllers_.emplace_back(controller);
  return groups;
}

Result<JobGroup> JobGroups::make(std::uint64_t memory_bytes, std::uint64_t tasks) const {
  std::string name = (folder_ / prefix).string() + "XXXXXX";
  const Error none{Code::internal, "no control group could be made for the job", "", "try again later"};
  if (::mkdtemp(name.data()) == nullptr) return tl::make_unexpected(none);
  const fs::path group = name;
  JobGroup made(group, Descriptor(::open((group / "cgroup.procs").c_str(), O_WRONLY | O_CLOEXEC)));
  bool limited = made.processes() >= 0;
  for (const std::string& controller : controllers_) {
    if (controller == "pids") limited = limited && put(group / "pids.max", std::to_string(tasks));
    if (controller == "memory" && memory_bytes > 0) {
      limited = limited && put(group / "memory.max", std::to_string(memory_bytes)) &&
                put(group / "memory.oom.group", "1");
      put(group / "memory.swap.max", "0");  // absent where the kernel counts no swap
    }
  }
  if (limited) return made;
  remove_group(group);
  return tl::make_unexpected(none);
}

}  // namespace vacuform
