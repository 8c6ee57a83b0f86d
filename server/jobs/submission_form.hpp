// The content of a submission before its validation: a multipart form, or a JSON object if no file is sent.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/jobs/form_file.hpp"
#include "server/messages/message.hpp"
#include "server/messages/multipart.hpp"
#include "server/store/store.hpp"

namespace vacuform {

inline constexpr std::uint64_t largest_settings = 64ull << 10;  // all texts of a form together

class SubmissionForm : public http::PartSink {
 public:
  explicit SubmissionForm(Store& store) : store_(store) {}

  // Streams the files into the store, without the names in them. Errors: too_large, bad_usage (an unknown or repeated
  // part), those of the body.
  Result<void> read(http::Request& request);

  std::map<std::string_view, FormFile> files;  // by the names of input_kinds
  std::string settings;                        // JSON text; perhaps empty

  // Texts except the JSON of `settings`, by their names.
  const std::map<std::string, std::string>& fields() const { return fields_; }
  // The value of the field; empty if it is absent.
  std::string field(const std::string& name) const;
  // Whether a field is a setting, group.key, and whether it names a file by an id.
  static bool is_setting(const std::string& field) { return field.find('.') != std::string::npos; }
  static bool is_file(const std::string& field);

 private:
  Result<void> begin(const std::string& name, const std::string& file_name) override;
  Result<void> data(std::string_view bytes) override;
  Result<void> end() override;
  Result<void> take(const nlohmann::json& object);

  Store& store_;
  std::map<std::string, std::string> fields_;
  bool has_settings_ = false;
  std::string part_;
  FormFile* file_ = nullptr;  // where it goes
  std::string* text_ = nullptr;
  std::uint64_t text_bytes_ = 0;
};

}  // namespace vacuform
