// Restricts the process of a job to its job: no network, only files in its own folder and the libraries and fonts of
// the system, no other process, and only system calls that a pipeline needs. A scan that exploits a parser then reaches
// nothing else.
//
// Three measures:
//  - namespaces: separate users, processes, network and IPC. The processes of the job end with the first of them.
//  - landlock: which files can be opened, made, renamed and deleted.
//  - seccomp: which calls are allowed. It refuses sockets, further processes, signals to others, exec, and what Landlock does
//    not know: modes, owners, times and attributes of files, and truncate() before Landlock's third ABI.
// A job of a stranger needs landlock (any ABI) and seccomp. If a container refuses namespaces, seccomp alone blocks the
// network and further processes, and the supervisor of the job (child.hpp) ends what is left.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/base/error.hpp"

struct sock_filter;

namespace vacuform {

// The measures to use; none by default.
struct Sandbox {
  bool namespaces = false;
  int landlock = 0;  // the ABI to use; 0: none
  bool seccomp = false;

  // Every measure, with the Landlock ABI that the kernel reports. Only a trial shows whether they work (child.hpp).
  static Sandbox all();
  // Whether a job of a stranger may run in it.
  bool is_enough() const { return landlock > 0 && seccomp; }
  // "namespaces", "landlock" and "seccomp": those in use and those not in use.
  std::vector<std::string> measures(bool taken) const;
};

// A sandbox for one child, prepared before the fork, because nothing may be allocated after it.
class Confinement {
 public:
  // `program` is a descriptor of the one program that may be executed, open as long as this object exists. `home` and,
  // if not empty, `cache` are the folders for it. Errors: internal.
  static Result<Confinement> prepare(const Sandbox& sandbox, int program, const std::filesystem::path& home,
                                     const std::filesystem::path& cache = {});
  Confinement(Confinement&& other) noexcept;
  Confinement(const Confinement&) = delete;
  Confinement& operator=(const Confinement&) = delete;
  ~Confinement();

  // Flags for clone(); 0: none.
  unsigned long namespaces() const;

  // In the child, by system calls alone, in this order; false if a measure fails.
  bool leave_files() const;   // once standard input, output and error are in place, without new privileges
  bool hold_program() const;  // closes every other descriptor
  bool leave_calls() const;   // right before execute()
  void execute(char* const* argv,
               char* const* envp) const;  // returns only if the program cannot be executed

 private:
  Confinement();
  Sandbox sandbox_;
  int program_ = -1;
  int ruleset_ = -1;
  std::vector<sock_filter> filter_;
};

}  // namespace vacuform
