// What keeps a job's child from everything but its job: no network, no file but its own folder's and the system's
// libraries and fonts, no system call that a pipeline has no use for. A scan that takes over a parser finds itself with
// the scan alone.
//
// Three measures, each of use without the others: namespaces of its own for users, network and IPC; Landlock for files
// (and TCP and signals where the kernel knows them); a seccomp filter, which refuses sockets, ptrace, mounts, keys, BPF,
// signals to other processes, and every program but the one that was asked for. Kernels and containers may lack some:
// then the others are used, and the worker says so.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/error.hpp"

struct sock_filter;

namespace vacuform {

// The measures to take; by default none.
struct Sandbox {
  bool namespaces = false;
  int landlock = 0;  // the ABI to use; 0: none
  bool seccomp = false;

  // Everything that this kernel lets this process do, found out by trying it in a process that ends at once.
  static Sandbox of_this_machine();
  // "namespaces", "landlock" and "seccomp", those that are taken and those that are not.
  std::vector<std::string> measures(bool taken) const;
};

// A sandbox for one child, made before the fork, for nothing may be allocated after it.
class Confinement {
 public:
  // `program` is the address of the text that execve() will get: the filter knows the one allowed program by it, which
  // is gone with the old memory once it runs. `home` and, where it is not empty, `kept` are the folders for it. Errors:
  // internal.
  static Result<Confinement> prepare(const Sandbox& sandbox, const char* program,
                                     const std::filesystem::path& home,
                                     const std::filesystem::path& kept = {});
  Confinement(Confinement&& other) noexcept;
  Confinement(const Confinement&) = delete;
  Confinement& operator=(const Confinement&) = delete;
  ~Confinement();

  // In the child, by system calls alone, in this order; false when a measure cannot be taken.
  bool leave_namespaces() const;  // first of all
  bool leave_files() const;       // once the descriptors stand, without new privileges
  bool leave_calls() const;       // right before execve()

 private:
  Confinement();
  Sandbox sandbox_;
  int ruleset_ = -1;
  std::vector<sock_filter> filter_;
};

}  // namespace vacuform
