#include "tests/unit/server/store/s3_server.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "api/base/secrets.hpp"

namespace vacuform {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void no_object_store(const std::string& what) {
  std::fprintf(stderr, "s3_server: %s\n", what.c_str());
  std::exit(1);
}

}  // namespace

S3Server& S3Server::get() {
  static S3Server server;
  return server;
}

S3Server::S3Server() {
  std::array<int, 2> in{}, out{};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0)
    no_object_store("no pipe could be made");
  process_ = ::fork();
  if (process_ == 0) {
    ::dup2(in[0], 0);
    ::dup2(out[1], 1);
    ::execlp(VACUFORM_PYTHON, VACUFORM_PYTHON, VACUFORM_OBJECT_STORE, nullptr);
    std::_Exit(127);
  }
  ::close(in[0]);
  ::close(out[1]);
  to_ = ::fdopen(in[1], "w");
  from_ = ::fdopen(out[0], "r");
  std::istringstream words(line());
  std::string url;
  words >> url >> credentials_.key_id >> credentials_.secret;
  const auto mark = url.find('?');
  if (mark == std::string::npos) no_object_store("Swift did not start");
  bucket_ = url.substr(0, mark);
  endpoint_ = url.substr(mark);
  file_ = fs::temp_directory_path() / ("vacuform-s3-key-" + random_hex(8));
  std::ofstream(file_) << "[default]\naws_access_key_id = " << credentials_.key_id
                       << "\naws_secret_access_key = " << credentials_.secret << "\n";
  fs::permissions(file_, fs::perms::owner_read | fs::perms::owner_write);
}

S3Server::~S3Server() {
  fs::remove(file_);
  std::fclose(to_);
  ::waitpid(process_, nullptr, 0);
  std::fclose(from_);
}

std::string S3Server::line() {
  std::string text;
  for (int c = std::fgetc(from_); c != EOF && c != '\n'; c = std::fgetc(from_)) text += static_cast<char>(c);
  return text;
}

void S3Server::tell(const std::string& word) {
  std::fprintf(to_, "%s\n", word.c_str());
  std::fflush(to_);
  if (line() != "done") no_object_store("Swift did not " + word);
}

std::string S3Server::url(const std::string& folder) const { return bucket_ + "/" + folder + endpoint_; }

S3Client S3Server::client(const std::string& folder) const {
  return {s3_address(url(folder)).value(), credentials_};
}

}  // namespace vacuform
