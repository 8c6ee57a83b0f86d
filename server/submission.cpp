#include "server/submission.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/names.hpp"
#include "api/settings.hpp"
#include "server/http/multipart.hpp"

namespace vacuform {

namespace {

struct UploadedFile {
  std::optional<Upload> upload;
  std::optional<NameFilter> names;  // on the way there
  std::string extension;
};

class Form : public http::PartSink {
 public:
  Form(Store& store, std::map<std::string, std::string>& fields) : store_(store), fields_(fields) {}

  Result<void> begin(const std::string& name, const std::string& file_name) override {
    part_ = name;
    file_ = nullptr;
    text_ = nullptr;
    if (name == "scan" || name == "pattern" || name == "temperature") {
      file_ = name == "scan" ? &scan : name == "pattern" ? &pattern : &temperature;
      if (file_->upload) return fail(Code::bad_usage, "there is more than one " + name, name, "send one");
      VACUFORM_TRY(upload, store_.upload());
      file_->upload.emplace(std::move(upload));
      file_->extension = http::safe_extension(file_name);
      file_->names.emplace(file_->extension);
      limit_ = name == "scan" ? largest_scan : name == "pattern" ? largest_pattern : largest_temperature;
    } else if (name == "settings" && !settings) {
      text_ = &settings.emplace();
    } else if (name.find('.') != std::string::npos && fields_.find(name) == fields_.end()) {
      text_ = &fields_[name];
    } else {
      return fail(Code::bad_usage, "an unknown or doubled part of the form: " + name.substr(0, 64),
                  "request body",
                  "send scan, pattern, temperature, settings, and fields named group.key, each once");
    }
    return {};
  }

  Result<void> data(std::string_view bytes) override {
    if (file_) {
      if (file_->upload->bytes() + bytes.size() > limit_)
        return fail(Code::too_large,
                    "the " + part_ + " is larger than " + std::to_string(limit_ >> 20) + " MiB", part_,
                    "send a smaller file");
      return file_->upload->write(file_->names->pass(bytes));
    }
    text_bytes_ += bytes.size();
    if (text_bytes_ > largest_settings)
      return fail(Code::too_large, "the settings are longer than 64 KiB", part_, "send fewer");
    text_->append(bytes);
    return {};
  }

  Result<void> end() override {
    return file_ ? file_->upload->write(file_->names->finish()) : Result<void>();
  }

  UploadedFile scan, pattern, temperature;
  std::optional<std::string> settings;

 private:
  Store& store_;
  std::map<std::string, std::string>& fields_;
  std::string part_;
  UploadedFile* file_ = nullptr;  // where the current part goes
  std::string* text_ = nullptr;
  std::uint64_t limit_ = 0, text_bytes_ = 0;
};

Result<void> check_file(const UploadedFile& file, const std::string& name, const std::string& kinds) {
  if (!file.upload || file.upload->bytes() == 0)
    return fail(Code::bad_usage, "there is no " + name + ", or it is empty", name, "choose a file: " + kinds);
  return {};
}

Result<Settings> merged_settings(const std::string& text, const std::map<std::string, std::string>& fields) {
  VACUFORM_TRY(alone, settings_from_text(text));  // also bounds its depth
  if (fields.empty()) return alone;
  nlohmann::json object = nlohmann::json::object();
  if (text.find('{') != std::string::npos) object = nlohmann::json::parse(text);
  for (const auto& [name, value] : fields) {
    const std::size_t begin = value.find_first_not_of(" \t\r\n");
    if (begin == std::string::npos) continue;
    std::string given = value.substr(begin, value.find_last_not_of(" \t\r\n") + 1 - begin);
    if (given.find(',') != std::string::npos && given.front() != '[' && given.front() != '{')
      given = "[" + given + "]";  // "3, 4" is a pair
    VACUFORM_CHECK(set_in_json(object, name + "=" + given));
  }
  return settings_from_json(object);
}

// The Idempotency-Key of a request; empty when it has none.
Result<std::string> client_key_of(const http::Request& request) {
  std::string key(request.header("Idempotency-Key"));
  const bool visible = std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!key.empty() && (key.size() < 8 || key.size() > 128 || !visible))
    return fail(Code::bad_usage, "the key has not 8 to 128 visible ASCII characters", "Idempotency-Key",
                "send for example a random UUID");
  return key;
}

}  // namespace

Result<NewJob> read_submission(http::Request& request, Store& store,
                               std::map<std::string, std::string>& fields) {
  constexpr std::uint64_t most = largest_scan + largest_pattern + largest_temperature + largest_settings +
                                 (1u << 20);  // and the part heads
  if (request.content_length > most)
    return fail(Code::too_large, "the form is larger than " + std::to_string(most >> 20) + " MiB",
                "request body", "send a smaller scan");
  VACUFORM_TRY(client_key, client_key_of(request));
  Form form(store, fields);
  VACUFORM_CHECK(http::read_multipart(request, form));
  VACUFORM_CHECK(check_file(form.scan, "scan", "STL, OBJ, PLY, OFF or GLB"));
  VACUFORM_CHECK(check_file(form.pattern, "pattern", "SVG, PNG or JPEG"));
  VACUFORM_TRY(settings, merged_settings(form.settings.value_or(""), fields));
  const bool measured = form.temperature.upload && form.temperature.upload->bytes() > 0;
  if (measured && settings.heat.source == HeatSource::uniform) settings.heat.source = HeatSource::measured;
  if (measured != (settings.heat.source == HeatSource::measured))
    return fail(Code::bad_settings,
                measured ? "measured temperatures are given, but the settings take them from the heaters"
                         : "there is no file of measured temperatures",
                "heat.source", "send the file as the part temperature together with heat.source measured");
  NewJob job{to_json(settings).dump(),          std::move(*form.scan.upload),
             std::move(form.scan.extension),    std::move(*form.pattern.upload),
             std::move(form.pattern.extension), std::move(client_key)};
  if (measured) {
    job.temperature.emplace(std::move(*form.temperature.upload));
    job.temperature_extension = std::move(form.temperature.extension);
  }
  job.request = request.id;
  return job;
}

}  // namespace vacuform
