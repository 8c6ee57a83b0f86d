#include "server/submission.hpp"

#include <algorithm>
#include <charconv>
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

bool has(const NewJob& job, std::string_view name) {
  return std::any_of(job.inputs.begin(), job.inputs.end(),
                     [&](const NewInput& input) { return input.name == name; });
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
    } else if (refers(name) && !references.contains(name)) {
      text_ = &references[name];
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
  std::map<std::string, std::string> references;  // by the names of their fields; perhaps empty

  // What the field says; empty where there is none.
  std::string reference(const std::string& field) const {
    const auto found = references.find(field);
    return found == references.end() ? std::string() : found->second;
  }
  // The same without files, from a JSON object: settings is an object there, and everything else a field.
  Result<void> read(const nlohmann::json& object) {
    for (const auto& [name, value] : object.items()) {
      const bool known = name == "settings" ? value.is_object() : refers(name);
      if (!known || !(value.is_object() || value.is_string() || value.is_number_integer()))
        return fail(Code::bad_usage, "an unknown or misshapen member: " + name.substr(0, 64), "request body",
                    "send settings, an object, and from, priority, profile, scan_id or ids of uploads");
      (name == "settings" ? settings.emplace() : references[name]) =
          value.is_string() ? value.get<std::string>() : value.dump();
    }
    return {};
  }

 private:
  // Fields that name something by its id, and the priority.
  static bool refers(const std::string& name) {
    for (const char* plain : {"scan_id", "profile", "from", "priority"})
      if (name == plain) return true;
    constexpr std::string_view tail = "_upload";
    return name.ends_with(tail) && input_kind(name.substr(0, name.size() - tail.size()));
  }

  Store& store_;
  std::map<std::string, std::string>& fields_;
  std::string part_;
  const InputKind* kind_ = nullptr;  // of the current part, if it is a file
  UploadedFile* file_ = nullptr;     // where it goes
  std::string* text_ = nullptr;
  std::uint64_t text_bytes_ = 0;
};

// Files that every job needs must be there, and not empty.
Result<void> check_files(const NewJob& job) {
  for (const InputKind& kind : input_kinds)
    if (kind.always && !has(job, kind.name))
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

// `base` is known to be settings.
Result<Settings> merged_settings(const std::string& base, const std::string& text,
                                 const std::map<std::string, std::string>& fields) {
  nlohmann::json object = nlohmann::json::parse(base);
  if (text.find_first_not_of(" \t\r\n") != std::string::npos) {
    const auto alone = settings_from_text(text);  // also bounds its depth
    if (!alone && (base == "{}" || alone.error().code != Code::bad_settings)) return alone;
    const auto given = nlohmann::json::parse(text, nullptr, false);
    if (!given.is_object() && !alone) return alone;
    if (!given.is_object()) return settings_from_json(given);
    for (const auto& [group, values] : given.items()) {
      if (!values.is_object() || !object[group].is_object())
        object[group] = values;
      else
        for (const auto& [key, value] : values.items()) object[group][key] = value;
    }
  }
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

// The file that a field names by an id.
Result<NewInput> shared_input(Service& service, const Caller& caller, const std::string& field,
                              const std::string& id) {
  if (field == "scan_id") {
    VACUFORM_TRY(scan, scan_for(service, id, caller));
    return NewInput{"scan", scan.blob, scan.extension};
  }
  VACUFORM_TRY(begun, upload_for(service, id, caller));
  VACUFORM_TRY(upload, service.uploads.whole(begun));
  if (field != upload.input + "_upload")
    return fail(Code::bad_usage, "the upload is a " + upload.input, field,
                "name it in the field " + upload.input + "_upload");
  return NewInput{upload.input, *upload.blob, upload.extension};
}

Result<void> add_inputs(Service& service, const Caller& caller, Form& form, NewJob& job) {
  for (auto& [name, file] : form.files)
    if (file.given()) job.add(std::string(name), std::move(*file.upload), std::move(file.extension));
  for (const auto& [field, id] : form.references) {
    if (field == "profile" || field == "from" || field == "priority" || id.empty()) continue;
    VACUFORM_TRY(input, shared_input(service, caller, field, id));
    if (has(job, input.name))
      return fail(Code::bad_usage, "there is more than one " + input.name, field, "send one");
    job.inputs.push_back(std::move(input));
  }
  return {};
}

// The files of the job that this one comes from, in place of those that were not sent: of those that not every job needs
// only what the settings still ask for.
void share_inputs(const Job& from, const Settings& settings, NewJob& job) {
  for (const Input& input : from.inputs) {
    const bool asked = input.name == "temperature" ? settings.heat.source == HeatSource::measured
                       : input.name == "weights"   ? settings.flattening.weights == FlatteningWeights::painted
                                                   : true;
    if (asked && !has(job, input.name)) job.add(input.name, input.blob, input.extension);
  }
}

Result<int> priority_of(const Form& form, const Caller& caller) {
  const std::string text = form.reference("priority");
  int priority = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), priority);
  if (text.empty()) return 0;
  if (error != std::errc() || end != text.data() + text.size() || priority < lowest_priority ||
      priority > highest_priority)
    return fail(Code::bad_usage, "not a priority: " + text.substr(0, 64), "priority",
                "give a number from -10 to 10");
  if (priority > 0 && !caller.scopes.has(Scope::admin))
    return fail(Code::forbidden, "only an administrator raises a job above the others", "priority",
                "give 0 or less");
  return priority;
}

// The multipart form, or a JSON object where no file is sent.
Result<void> read_body(http::Request& request, Form& form) {
  if (!request.header("Content-Type").starts_with("application/json"))
    return http::read_multipart(request, form);
  VACUFORM_TRY(text, http::read_text(request, largest_settings + 4096));
  const auto object = nlohmann::json::parse(text, nullptr, false);
  if (!object.is_object())
    return fail(Code::bad_usage, "the body is not a JSON object", "request body", "see /api/v1/openapi.yaml");
  return form.read(object);
}

// The settings to begin with.
Result<std::string> base_of(Service& service, const Form& form, const std::optional<Job>& from) {
  const std::string named = form.reference("profile");
  if (from && !named.empty())
    return fail(Code::bad_usage, "both another job and a profile are given to begin with", "profile",
                "give one of them");
  if (from) return from->settings;
  if (named.empty()) return std::string("{}");
  VACUFORM_TRY(profile, service.store.find_profile(named));
  return profile.settings;
}

Result<std::optional<Job>> origin_of(Service& service, const Form& form, const Caller& caller) {
  const std::string id = form.reference("from");
  if (id.empty()) return std::optional<Job>();
  VACUFORM_TRY(job, service.store.job(id));
  if (!caller.sees(job)) return fail(Code::not_found, "there is no such job", id, "see the list of jobs");
  return std::optional<Job>(std::move(job));
}

}  // namespace

Result<NewJob> read_submission(Service& service, http::Request& request, const Caller& caller,
                               std::map<std::string, std::string>& fields) {
  std::uint64_t most = largest_settings + (1u << 20);  // the part heads
  for (const InputKind& kind : input_kinds) most += kind.most_bytes;
  if (request.content_length > most)
    return fail(Code::too_large, "the form is larger than " + std::to_string(most >> 20) + " MiB",
                "request body", "send a smaller scan");
  VACUFORM_TRY(client_key, client_key_of(request));
  Form form(service.store, fields);
  VACUFORM_CHECK(read_body(request, form));
  NewJob job;
  VACUFORM_CHECK(add_inputs(service, caller, form, job));
  VACUFORM_TRY(from, origin_of(service, form, caller));
  if (!from) VACUFORM_CHECK(check_files(job));
  VACUFORM_TRY(base, base_of(service, form, from));
  VACUFORM_TRY(settings, merged_settings(base, form.settings.value_or(""), fields));
  if (from) {
    share_inputs(*from, settings, job);
    job.derived_from = from->id;
  }
  VACUFORM_TRY(priority, priority_of(form, caller));
  job.priority = priority;
  VACUFORM_CHECK(match(has(job, "temperature"), "temperature", settings.heat.source, HeatSource::uniform,
                       HeatSource::measured, "heat.source", "measured"));
  VACUFORM_CHECK(match(has(job, "weights"), "weights", settings.flattening.weights,
                       FlatteningWeights::uniform, FlatteningWeights::painted, "flattening.weights",
                       "painted"));
  job.settings = to_json(settings).dump();
  job.client_key = std::move(client_key);
  job.request = request.id;
  job.owner = caller.owner;
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
