#include "server/store/blobs/s3/s3_signature.hpp"

#include <ctime>
#include <string_view>

#include "api/base/secrets.hpp"
#include "api/base/sha256.hpp"

namespace vacuform {

namespace {

constexpr std::string_view algorithm = "AWS4-HMAC-SHA256";

std::string hex_of(std::string_view bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

std::string signed_names(const SignedRequest& request) {
  std::string names;
  for (const auto& [name, value] : request.headers) names += (names.empty() ? "" : ";") + name;
  return names;
}

// Without blanks at its ends, and with one blank in place of several.
std::string trimmed_value(const std::string& value) {
  std::string text;
  for (const char c : value)
    if (c != ' ' || (!text.empty() && text.back() != ' ')) text += c;
  if (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string canonical_request(const SignedRequest& request) {
  std::string text = request.method + "\n" + percent_encoded(request.path, true) + "\n" +
                     encoded_query(request.query) + "\n";
  for (const auto& [name, value] : request.headers) text.append(name + ":" + trimmed_value(value) + "\n");
  return text + "\n" + signed_names(request) + "\n" + request.payload_sha256;
}

}  // namespace

std::string percent_encoded(const std::string& text, bool keep_slashes) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  constexpr std::string_view kept = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (kept.find(c) != std::string_view::npos || (keep_slashes && c == '/'))
      encoded += c;
    else
      encoded.append({'%', digits[byte >> 4], digits[byte & 15]});
  }
  return encoded;
}

std::string encoded_query(const std::map<std::string, std::string>& query) {
  std::map<std::string, std::string> encoded;  // sorted by the encoded names
  for (const auto& [name, value] : query)
    encoded[percent_encoded(name, false)] = percent_encoded(value, false);
  std::string text;
  for (const auto& [name, value] : encoded)
    text.append(text.empty() ? "" : "&").append(name).append("=").append(value);
  return text;
}

std::string s3_time(Millis time) {
  const std::time_t seconds = time / 1000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::string text(17, '\0');  // strftime ends it with a zero
  std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &parts);
  text.pop_back();
  return text;
}

std::string s3_authorization(const SignedRequest& request, const S3Credentials& credentials,
                             const S3Scope& scope) {
  const std::string time = request.headers.at("x-amz-date"), day = time.substr(0, 8);
  const std::string place = day + "/" + scope.region + "/" + scope.service + "/aws4_request";
  const std::string text =
      std::string(algorithm) + "\n" + time + "\n" + place + "\n" + text_hash(canonical_request(request));
  std::string key = "AWS4" + credentials.secret;
  for (const std::string_view part : {std::string_view(day), std::string_view(scope.region),
                                      std::string_view(scope.service), std::string_view("aws4_request")})
    key = hmac_sha256(key, part);
  return std::string(algorithm) + " Credential=" + credentials.key_id + "/" + place +
         ",SignedHeaders=" + signed_names(request) + ",Signature=" + hex_of(hmac_sha256(key, text));
}

}  // namespace vacuform
