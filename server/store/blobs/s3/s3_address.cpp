#include "server/store/blobs/s3/s3_address.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string_view>

#include "api/base/file.hpp"

namespace vacuform {

namespace {

constexpr std::string_view s3_scheme = "s3://", secure = "https://", plain_http = "http://";

tl::unexpected<Error> bad_blobs(const std::string& what) {
  return fail(Code::bad_usage, what, "--blobs",
              "give for example s3://vacuform?endpoint=https://s3.example.org&region=us-east-1");
}

bool consists_of(std::string_view text, std::string_view more) {
  return std::all_of(text.begin(), text.end(), [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || more.find(c) != std::string_view::npos;
  });
}

bool is_loopback_endpoint(std::string_view host) {
  host = host.substr(0, host.starts_with('[') ? host.find(']') + 1 : host.find(':'));
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

Result<void> check_endpoint(const std::string& endpoint) {
  const bool http = endpoint.starts_with(plain_http);
  const std::string_view host =
      std::string_view(endpoint).substr(std::min(endpoint.size(), (http ? plain_http : secure).size()));
  if ((!http && !endpoint.starts_with(secure)) || host.empty() || !consists_of(host, ".-:[]"))
    return bad_blobs("not the address of an object store: " + endpoint);
  if (http && !is_loopback_endpoint(host))
    return bad_blobs("refusing plain HTTP to an object store on another machine: " + endpoint);
  return {};
}

Result<void> take_parameter(S3Address& address, std::string_view text) {
  const auto equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  const std::string value(equals == std::string_view::npos ? "" : text.substr(equals + 1));
  if (name == "endpoint") {
    address.endpoint = value;
    while (address.endpoint.ends_with('/')) address.endpoint.pop_back();
    return check_endpoint(address.endpoint);
  }
  if (name == "region" && !value.empty() && consists_of(value, "-_")) {
    address.region = value;
    return {};
  }
  if (name == "addressing" && (value == "path" || value == "virtual")) {
    address.path_style = value == "path";
    return {};
  }
  return bad_blobs("not a parameter of an object store: " + std::string(name));
}

std::string trimmed_text(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

Result<S3Credentials> credentials_in(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) == 0 && (status.st_mode & S_IROTH) != 0)
    return fail(Code::bad_usage, "every user of this machine can read the secret of the object store",
                file.string(), "run: chmod o= on that file");
  VACUFORM_TRY(text, read_text_file(file, 64 * 1024));
  S3Credentials found;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string name = trimmed_text(line.substr(0, equals)),
                      value = trimmed_text(line.substr(equals + 1));
    if (name == "aws_access_key_id") found.key_id = value;
    if (name == "aws_secret_access_key") found.secret = value;
    if (name == "aws_session_token") found.session = value;
  }
  if (found.key_id.empty() || found.secret.empty())
    return fail(Code::bad_usage, "the file has no access key for the object store", file.string(),
                "write two lines: aws_access_key_id = ID and aws_secret_access_key = SECRET");
  return found;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

std::string S3Address::host() const {
  const std::string server = endpoint.substr(endpoint.find("://") + 3);
  return path_style ? server : bucket + "." + server;
}

std::string S3Address::url() const { return endpoint.substr(0, endpoint.find("://") + 3) + host(); }

Result<S3Address> s3_address(const std::string& text) {
  if (!text.starts_with(s3_scheme)) return bad_blobs("not a place for files: " + text);
  S3Address address;
  const auto mark = text.find('?');
  const std::string place =
      text.substr(s3_scheme.size(), mark == std::string::npos ? mark : mark - s3_scheme.size());
  const auto slash = place.find('/');
  address.bucket = place.substr(0, slash);
  if (slash != std::string::npos) address.prefix = place.substr(slash + 1);
  while (address.prefix.ends_with('/')) address.prefix.pop_back();
  if (address.bucket.empty() || !consists_of(address.bucket, ".-_") || !consists_of(address.prefix, "-_/") ||
      address.prefix.starts_with('/') || address.prefix.find("//") != std::string::npos)
    return bad_blobs("not the name of a bucket, or of a folder in one: " + place);
  if (!address.prefix.empty()) address.prefix += '/';
  for (std::string_view rest = mark == std::string::npos ? "" : std::string_view(text).substr(mark + 1);
       !rest.empty();) {
    const std::string_view one = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    VACUFORM_CHECK(take_parameter(address, one));
  }
  if (address.endpoint.empty()) address.endpoint = "https://s3." + address.region + ".amazonaws.com";
  return address;
}

bool blobs_in_files(const std::string& blobs) { return blobs.empty() || blobs == "file:"; }

Result<void> check_blobs(const std::string& blobs) {
  if (blobs_in_files(blobs)) return {};
  VACUFORM_CHECK(s3_address(blobs));
  return {};
}

Result<S3Credentials> s3_credentials(const std::filesystem::path& file) {
  if (!file.empty()) return credentials_in(file);
  S3Credentials found{environment("AWS_ACCESS_KEY_ID"), environment("AWS_SECRET_ACCESS_KEY"),
                      environment("AWS_SESSION_TOKEN")};
  if (found.key_id.empty() || found.secret.empty())
    return fail(Code::bad_usage, "there is no access key for the object store", "--blobs-credentials",
                "name a file with the key, or set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY");
  return found;
}

}  // namespace vacuform
