// An object store of its own for a test program: OpenStack Swift from Debian's packages, by tests/integration/object_store.py.
// Made and started at its first use, reachable on loopback alone, stopped at the end of the program.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>

#include "server/store/blobs/s3/s3_client.hpp"

namespace vacuform {

class S3Server {
 public:
  // The one of this program. Ends the program with a message if Swift is not installed or does not start.
  static S3Server& get();
  // The address of a folder in its bucket, as --blobs takes it.
  std::string url(const std::string& folder) const;
  const S3Credentials& credentials() const { return credentials_; }
  // A private file with them, as --blobs-credentials takes it; deleted at the end of the program.
  const std::filesystem::path& credentials_file() const { return file_; }
  // The requests of a user of that folder.
  S3Client client(const std::string& folder) const;
  // kill -9 of all its processes.
  void kill() { tell("kill"); }
  void start() { tell("start"); }
  // Bounds the bytes of the bucket; 0: no bound.
  void set_quota(std::uint64_t bytes) { tell("quota " + std::to_string(bytes)); }
  ~S3Server();
  S3Server(const S3Server&) = delete;
  S3Server& operator=(const S3Server&) = delete;

 private:
  S3Server();
  std::string line();
  void tell(const std::string& word);

  pid_t process_ = 0;
  std::FILE* to_ = nullptr;
  std::FILE* from_ = nullptr;
  std::string bucket_, endpoint_;
  S3Credentials credentials_;
  std::filesystem::path file_;
};

}  // namespace vacuform
