// What keeps a job's process from everything but its job: no network, no file but those in its own folder and the
// system's libraries and fonts, no other process, no system call that a pipeline has no use for. A scan that takes over
// a parser is then alone with itself.
//
// Three measures:
//  - namespaces: users, processes, network and IPC of its own. The job's processes end with the first of them.
//  - landlock: which files can be opened, made, renamed and deleted.
//  - seccomp: which calls are allowed. It refuses sockets, further processes, signals to others, exec, and what Landlock does
//    not know: modes, owners, times and attributes of files, and truncate() before Landlock's third ABI.
// A job of a stranger needs landlock (any ABI) and seccomp. Where a container refuses namespaces, seccomp alone refuses the
// network and further processes, and the job's supervisor (child.hpp) ends what is left.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "api/base/error.hpp"

struct sock_filter;

namespace vacuform {

// The measures to take; by default none.
struct Sandbox {
  bool namespaces = false;
  int landlock = 0;  // the ABI to use; 0: none
  bool seccomp = false;

  // Every measure, with the ABI of Landlock that the kernel states. Only a trial shows whether they work (child.hpp).
  static Sandbox all();
  // Whether a job of a stranger may run in it.
  bool is_enough() const { return landlock > 0 && seccomp; }
  // "namespaces", "landlock" and "seccomp", those that are taken and those that are not.
  std::vector<std::string> measures(bool taken) const;
};

// A sandbox for one child, made before the fork, for nothing may be allocated after it.
class Confinement {
 public:
  // `program` is a descriptor of the one program that may be executed, open until this object is gone. `home` and, where it
  // is not empty, `kept` are the folders for it. Errors: internal.
  static Result<Confinement> prepare(const Sandbox& sandbox, int program, const std::filesystem::path& home,
                                     const std::filesystem::path& kept = {});
  Confinement(Confinement&& other) noexcept;
  Confinement(const Confinement&) = delete;
  Confinement& operator=(const Confinement&) = delete;
  ~Confinement();

  // Flags for clone(); 0: none.
  unsigned long namespaces() const;

  // In the child, by system calls alone, in this order; false when a measure cannot be taken.
  bool leave_files() const;   // once standard input, output and error are in place, without new privileges
  bool hold_program() const;  // closes every other descriptor
  bool leave_calls() const;   // right before execute()
  void execute(char* const* argv,
               char* const* envp) const;  // returns only when the program cannot be executed

 private:
  Confinement();
  Sandbox sandbox_;
  int program_ = -1;
  int ruleset_ = -1;
  std::vector<sock_filter> filter_;
};

}  // namespace vacuform
