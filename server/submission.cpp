#include "server/submission.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/names.hpp"
#include "api/settings.hpp"
#include "server/formats.hpp"
#include "server/http/multipart.hpp"

namespace vacuform {

namespace {

struct UploadedFile {
  std::optional<Upload> upload;
  std::optional<NameFilter> names;  // on the way there
  std::string extension;

  bool given() const { return upload && upload->bytes() > 0; }
};

std::string parts_text() {
  std::string text;
  for (const InputKind& kind : input_kinds) text += std::string(kind.name) + ", ";
  return text + "settings";
}

class Form : public http::PartSink {
 public:
  Form(Store& store, std::map<std::string, std::string>& fields) : store_(store), fields_(fields) {}

  Result<void> begin(const std::string& name, const std::string& file_name) override {
    part_ = name;
    file_ = nullptr;
    text_ = nullptr;
    if ((kind_ = input_kind(name))) {
      file_ = &files[kind_->name];
      if (file_->upload) return fail(Code::bad_usage, "there is more than one " + name, name, "send one");
      VACUFORM_TRY(upload, store_.upload());
      file_->upload.emplace(std::move(upload));
      file_->extension = http::safe_extension(file_name);
      file_->names.emplace(file_->extension);
    } else if (name == "settings" && !settings) {
      text_ = &settings.emplace();
    } else if (name.find('.') != std::string::npos && fields_.find(name) == fields_.end()) {
      text_ = &fields_[name];
    } else {
      return fail(Code::bad_usage, "an unknown or doubled part of the form: " + name.substr(0, 64),
                  "request body", "send " + parts_text() + ", and fields named group.key, each once");
    }
    return {};
  }

  Result<void> data(std::string_view bytes) override {
    if (file_) {
      if (file_->upload->bytes() + bytes.size() > kind_->most_bytes)
        return fail(Code::too_large,
                    "the " + part_ + " is larger than " + std::to_string(kind_->most_bytes >> 20) + " MiB",
                    part_, "send a smaller file");
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

  std::map<std::string_view, UploadedFile> files;  // by the names of input_kinds
  std::optional<std::string> settings;

 private:
  Store& store_;
  std::map<std::string, std::string>& fields_;
  std::string part_;
  const InputKind* kind_ = nullptr;  // of the current part, if it is a file
  UploadedFile* file_ = nullptr;     // where it goes
  std::string* text_ = nullptr;
  std::uint64_t text_bytes_ = 0;
};

// Files that every job needs must be there, and not empty.
Result<void> check_files(std::map<std::string_view, UploadedFile>& files) {
  for (const InputKind& kind : input_kinds)
    if (kind.always && !files[kind.name].given())
      return fail(Code::bad_usage, "there is no " + std::string(kind.name) + ", or it is empty",
                  std::string(kind.name), "choose a file: " + std::string(kind.extensions));
  return {};
}

// A file that the settings can do without turns their default into its use; what asks for a file needs it.
template <class Choice>
Result<void> match(bool given, const std::string& part, Choice& setting, Choice by_default, Choice of_file,
                   const std::string& key, const std::string& value) {
  if (given && setting == by_default) setting = of_file;
  if (given == (setting == of_file)) return {};
  return fail(Code::bad_settings,
              given ? "a file is given as " + part + ", but the settings do not use it"
                    : "the settings ask for a file that is not given: " + part,
              key, "send the file as the part " + part + " together with " + key + " " + value);
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
  std::uint64_t most = largest_settings + (1u << 20);  // the part heads
  for (const InputKind& kind : input_kinds) most += kind.most_bytes;
  if (request.content_length > most)
    return fail(Code::too_large, "the form is larger than " + std::to_string(most >> 20) + " MiB",
                "request body", "send a smaller scan");
  VACUFORM_TRY(client_key, client_key_of(request));
  Form form(store, fields);
  VACUFORM_CHECK(http::read_multipart(request, form));
  VACUFORM_CHECK(check_files(form.files));
  VACUFORM_TRY(settings, merged_settings(form.settings.value_or(""), fields));
  VACUFORM_CHECK(match(form.files["temperature"].given(), "temperature", settings.heat.source,
                       HeatSource::uniform, HeatSource::measured, "heat.source", "measured"));
  VACUFORM_CHECK(match(form.files["weights"].given(), "weights", settings.flattening.weights,
                       FlatteningWeights::uniform, FlatteningWeights::painted, "flattening.weights",
                       "painted"));
  NewJob job{to_json(settings).dump(), std::move(client_key)};
  for (auto& [name, file] : form.files)
    if (file.given()) job.add(std::string(name), std::move(*file.upload), std::move(file.extension));
  job.request = request.id;
  return job;
}

Result<nlohmann::ordered_json> plan_of(NewJob& job, Store& store) {
  nlohmann::ordered_json inputs = nlohmann::ordered_json::object();
  for (const InputKind& kind : input_kinds)
    for (NewInput& input : job.inputs) {
      if (input.name != kind.name) continue;
      auto* upload = std::get_if<Upload>(&input.file);
      VACUFORM_TRY(blob, upload ? upload->seal() : Result<Blob>(std::get<Blob>(input.file)));
      File opened;
      if (!upload) {
        VACUFORM_TRY(file, store.open(blob));
        opened = std::move(file);
      }
      std::string head(format_head, '\0');
      VACUFORM_TRY(n, (upload ? upload->file() : opened).read_at(0, head));
      head.resize(n);
      VACUFORM_TRY(format, format_of(input.name, head, blob.bytes, input.extension));
      inputs[input.name] = {
          {"bytes", blob.bytes}, {"sha256", blob.sha256}, {"extension", input.extension}, {"format", format}};
    }
  return nlohmann::ordered_json{{"settings", nlohmann::ordered_json::parse(job.settings)},
                                {"inputs", std::move(inputs)}};
}

}  // namespace vacuform
