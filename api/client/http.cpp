#include "api/client/http.hpp"
#include "api/base/json_text.hpp"
#include "api/problem.hpp"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>

namespace vacuform {

namespace {

constexpr std::size_t body_limit = 4u << 20;

struct Closer {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
  void operator()(curl_mime* mime) const { curl_mime_free(mime); }
};

// What the callbacks of one exchange share.
struct Exchange {
  CURL* curl;
  const HttpRequest& request;
  HttpResponse response;
  std::uint64_t to_send = 0, file_sent = 0;
  bool given_up = false, overflow = false;
};

std::size_t take_body(char* bytes, std::size_t, std::size_t count, void* user) {
  auto& x = *static_cast<Exchange*>(user);
  long status = 0;
  curl_easy_getinfo(x.curl, CURLINFO_RESPONSE_CODE, &status);
  if (x.request.sink && status >= 200 && status < 300) {
    x.given_up = !x.request.sink({reinterpret_cast<const std::uint8_t*>(bytes), count});
    return x.given_up ? 0 : count;
  }
  x.overflow = x.response.body.size() + count > body_limit;
  if (x.overflow) return 0;
  x.response.body.append(bytes, count);
  return count;
}

std::size_t take_header(char* bytes, std::size_t, std::size_t count, void* user) {
  auto& x = *static_cast<Exchange*>(user);
  std::string line(bytes, count);
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n' || line.back() == ' ')) line.pop_back();
  const auto colon = line.find(':');
  if (colon == std::string::npos || x.response.headers.size() >= 100) return count;
  std::string name = line.substr(0, colon);
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const auto value = line.find_first_not_of(' ', colon + 1);
  x.response.headers[name] = value == std::string::npos ? "" : line.substr(value);
  return count;
}

// By position, so that no other user of the descriptor matters, and to the stated length, whatever the file grows to.
std::size_t give_file(char* bytes, std::size_t, std::size_t count, void* user) {
  auto& x = *static_cast<Exchange*>(user);
  const auto most = std::min<std::uint64_t>(count, x.request.file_bytes - x.file_sent);
  const ssize_t n =
      ::pread(x.request.file, bytes, most, static_cast<off_t>(x.request.file_offset + x.file_sent));
  if (n < 0 || (n == 0 && most > 0)) return CURL_READFUNC_ABORT;
  x.file_sent += static_cast<std::uint64_t>(n);
  return static_cast<std::size_t>(n);
}

int seek_file(void* user, curl_off_t offset, int origin) {
  if (origin != SEEK_SET) return CURL_SEEKFUNC_CANTSEEK;
  static_cast<Exchange*>(user)->file_sent = static_cast<std::uint64_t>(offset);
  return CURL_SEEKFUNC_OK;
}

int keep_going(void* user, curl_off_t, curl_off_t, curl_off_t total, curl_off_t sent) {
  auto& x = *static_cast<Exchange*>(user);
  if (total > 0) x.to_send = static_cast<std::uint64_t>(total);
  if (x.request.going && !x.request.going(static_cast<std::uint64_t>(sent), x.to_send)) x.given_up = true;
  return x.given_up ? 1 : 0;
}

// The host of a URL; empty where it has none or is no URL.
std::string host_of(const std::string& url) {
  struct Free {
    void operator()(CURLU* parts) const { curl_url_cleanup(parts); }
  };
  const std::unique_ptr<CURLU, Free> parts(curl_url());
  char* text = nullptr;
  if (!parts || curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK ||
      curl_url_get(parts.get(), CURLUPART_HOST, &text, 0) != CURLUE_OK)
    return {};
  std::string host = text;
  curl_free(text);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return host;
}

bool loopback(const std::string& host) {
  in_addr v4{};
  in6_addr v6{};
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  if (::inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

// Whether it is an address of this machine's own: what is sent there does not leave the machine.
bool own_address(const std::string& host) {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return false;
  bool found = false;
  for (const ifaddrs* one = all; one && !found; one = one->ifa_next) {
    if (!one->ifa_addr) continue;
    const int family = one->ifa_addr->sa_family;
    const socklen_t size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
    char text[NI_MAXHOST];
    found = (family == AF_INET || family == AF_INET6) &&
            ::getnameinfo(one->ifa_addr, size, text, sizeof text, nullptr, 0, NI_NUMERICHOST) == 0 &&
            host == text;
  }
  ::freeifaddrs(all);
  return found;
}

}  // namespace

struct Http::Handle {
  CURL* curl;
  Handle() {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    curl = curl_easy_init();
    if (!curl) std::abort();  // out of memory
  }
  ~Handle() { curl_easy_cleanup(curl); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
};

Http::Http() : handle_(std::make_unique<Handle>()) {}
Http::Http(Http&&) noexcept = default;
Http& Http::operator=(Http&&) noexcept = default;
Http::~Http() = default;

Result<Http> Http::to(const std::string& url, const std::string& token) {
  const bool http = url.rfind("http://", 0) == 0, https = url.rfind("https://", 0) == 0;
  if (!http && !https)
    return fail(Code::bad_usage, "not a server's address: " + url, "--server",
                "write for example http://127.0.0.1:8080");
  const std::string host = host_of(url);
  if (host.empty())
    return fail(Code::bad_usage, "not a server's address: " + url, "--server",
                "write for example http://127.0.0.1:8080");
  if (http && !token.empty() && !loopback(host) && !own_address(host))
    return fail(Code::bad_usage, "a token must not cross the network in plain HTTP", url,
                "use the server's https:// address");
  if (token.find_first_of("\r\n") != std::string::npos)
    return fail(Code::bad_usage, "the token holds a line break", "",
                "keep the token on one line of its file");
  Http door;
  door.loopback_ = loopback(host);
  door.url_ = url;
  while (door.url_.back() == '/') door.url_.pop_back();
  door.token_ = token;
  return door;
}

Result<HttpResponse> Http::send(const HttpRequest& request) {
  CURL* curl = handle_->curl;
  curl_easy_reset(curl);  // keeps the connections
  Exchange x{curl, request, {}};

  const std::string address = url_ + request.path;
  curl_easy_setopt(curl, CURLOPT_URL, address.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, 5L);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, 30L);
  if (request.limit.count() > 0)
    curl_easy_setopt(curl, CURLOPT_TIMEOUT, static_cast<long>(request.limit.count()));
  if (loopback_) curl_easy_setopt(curl, CURLOPT_PROXY, "");
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, take_body);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &x);
  curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, take_header);
  curl_easy_setopt(curl, CURLOPT_HEADERDATA, &x);
  curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, keep_going);
  curl_easy_setopt(curl, CURLOPT_XFERINFODATA, &x);
  curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);

  std::unique_ptr<curl_mime, Closer> mime;
  if (!request.form.empty()) {
    mime.reset(curl_mime_init(curl));
    for (const FormPart& part : request.form) {
      curl_mimepart* p = curl_mime_addpart(mime.get());
      curl_mime_name(p, part.name.c_str());
      if (part.file.empty())
        curl_mime_data(p, part.text.data(), part.text.size());
      else if (curl_mime_filedata(p, part.file.c_str()) != CURLE_OK)
        return fail(Code::unreadable, "the file cannot be read", part.file.string(),
                    "check its name and permissions");
    }
    curl_easy_setopt(curl, CURLOPT_MIMEPOST, mime.get());
  } else if (request.file >= 0) {
    curl_easy_setopt(curl, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(curl, CURLOPT_READFUNCTION, give_file);
    curl_easy_setopt(curl, CURLOPT_READDATA, &x);
    curl_easy_setopt(curl, CURLOPT_SEEKFUNCTION, seek_file);
    curl_easy_setopt(curl, CURLOPT_SEEKDATA, &x);
    curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.file_bytes));
  } else if (request.method == "HEAD") {
    curl_easy_setopt(curl, CURLOPT_NOBODY, 1L);
  } else if (request.method != "GET") {
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS, request.body.data());
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  }
  curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request.method.c_str());

  std::unique_ptr<curl_slist, Closer> headers;
  const auto add = [&](const std::string& line) {
    headers.reset(curl_slist_append(headers.release(), line.c_str()));
  };
  if (!token_.empty()) add("Authorization: Bearer " + token_);
  for (const auto& [name, value] : request.headers) add(name + ": " + value);
  if (headers) curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());

  const CURLcode code = curl_easy_perform(curl);
  if (x.given_up) return fail(Code::cancelled, "cancelled");
  if (x.overflow)
    return fail(Code::too_large, "the server's answer is longer than 4 MiB", url_,
                "check that this is a Vacuform server");
  if (code == CURLE_READ_ERROR || (code == CURLE_ABORTED_BY_CALLBACK && request.file >= 0))
    return fail(Code::unreadable, "a file could not be read to its end", "", "check that it is a plain file");
  if (code != CURLE_OK)
    return fail(Code::unavailable, std::string("no answer from the server: ") + curl_easy_strerror(code),
                url_, "check the address and that the server runs");
  long status = 0;
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
  x.response.status = static_cast<int>(status);
  return std::move(x.response);
}

Error error_of(const HttpResponse& response) {
  Error error;
  const auto problem = nlohmann::json::parse(response.body, nullptr, false);
  constexpr std::string_view prefix = "/problems/";
  const std::string type = text_of(problem, "type");
  const auto code = type.starts_with(prefix) ? code_from(type.substr(prefix.size())) : std::nullopt;
  if (code) {
    error = {*code, text_of(problem, "what"), text_of(problem, "where"), text_of(problem, "fix")};
    if (const auto list = problem.find("proposals"); list != problem.end())
      error.proposals = proposals_from(*list).value_or(std::vector<Proposal>());
    if (error.what.empty()) error.what = std::string(meaning(*code).title);
    return error;
  }
  switch (response.status) {
    case 404:
      error.code = Code::not_found;
      break;
    case 409:
      error.code = Code::conflict;
      break;
    case 413:
      error.code = Code::too_large;
      break;
    case 408:
    case 429:
    case 502:
    case 503:
    case 504:
      error.code = Code::unavailable;
      break;
    default:
      error.code = response.status >= 500 ? Code::internal : Code::bad_usage;
  }
  error.what = "the server answered " + std::to_string(response.status) + " without saying why";
  error.fix = "check that the address is that of a Vacuform server";
  return error;
}

}  // namespace vacuform
