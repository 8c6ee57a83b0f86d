// A PostgreSQL of its own for a test program, from Debian's packages: made and started at its first use, reachable by a
// socket in a private folder alone, stopped at the end of the program.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace vacuform {

class PostgresServer {
 public:
  // The one of this program. Ends the program with a message if PostgreSQL is not installed or does not start.
  static PostgresServer& get();
  // The address of a schema in it, which is made.
  std::string url(const std::string& schema);
  // kill -9 of all its processes.
  void kill();
  void start();
  // Of psql, as the administrator of the database.
  std::string answer(const std::string& sql);
  ~PostgresServer();

 private:
  PostgresServer();
  std::filesystem::path folder_;
  pid_t process_ = 0;
};

}  // namespace vacuform
