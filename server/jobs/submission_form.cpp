#include "server/jobs/submission_form.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "server/messages/problem.hpp"

namespace vacuform {

namespace {

constexpr std::array<std::string_view, 7> plain_fields{"kind",      "from",   "priority", "profile",
                                                       "reference", "rescan", "note"};

bool known(const std::string& field) {
  return SubmissionForm::is_file(field) ||
         std::find(plain_fields.begin(), plain_fields.end(), field) != plain_fields.end();
}

Error unknown(const std::string& what, const std::string& name, const std::string& fix) {
  return {Code::bad_usage, "an unknown " + what + ": " + name.substr(0, 64), "request body", fix};
}

}  // namespace

bool SubmissionForm::is_file(const std::string& field) {
  constexpr std::string_view tail = "_upload";
  return field == "scan_id" ||
         (field.ends_with(tail) && input_kind(field.substr(0, field.size() - tail.size())));
}

std::string SubmissionForm::field(const std::string& name) const {
  const auto found = fields_.find(name);
  return found == fields_.end() ? std::string() : found->second;
}

Result<void> SubmissionForm::read(http::Request& request) {
  if (!request.header("Content-Type").starts_with("application/json"))
    return http::read_multipart(request, *this);
  VACUFORM_TRY(object, read_object(request, largest_settings + 4096));
  return take(object);
}

Result<void> SubmissionForm::begin(const std::string& name, const std::string& file_name) {
  part_ = name;
  file_ = nullptr;
  text_ = nullptr;
  if (const InputKind* kind = input_kind(name)) {
    if (files.contains(kind->name))
      return fail(Code::bad_usage, "there is more than one " + name, name, "send one");
    VACUFORM_TRY(file, FormFile::begin(store_, *kind, http::safe_extension(file_name)));
    file_ = &files.emplace(kind->name, std::move(file)).first->second;
  } else if (name == "settings" && !has_settings_) {
    has_settings_ = true;
    text_ = &settings;
  } else if ((known(name) || is_setting(name)) && !fields_.contains(name)) {
    text_ = &fields_[name];
  } else {
    std::string parts;
    for (const InputKind& each : input_kinds) parts += std::string(each.name) + ", ";
    return tl::make_unexpected(unknown("or repeated part of the form", name,
                                       "send " + parts + "settings, and fields named group.key, each once"));
  }
  return {};
}

Result<void> SubmissionForm::data(std::string_view bytes) {
  if (file_) return file_->write(bytes);
  text_bytes_ += bytes.size();
  if (text_bytes_ > largest_settings)
    return fail(Code::too_large, "the settings are longer than 64 KiB", part_, "send fewer");
  text_->append(bytes);
  return {};
}

Result<void> SubmissionForm::end() { return file_ ? file_->end() : Result<void>(); }

// Here settings is an object, and everything else a field.
Result<void> SubmissionForm::take(const nlohmann::json& object) {
  for (const auto& [name, value] : object.items()) {
    const bool is_settings = name == "settings", is_number = name == "priority",
               is_yes_or_no = name == "rescan";
    if (!is_settings && !known(name))
      return tl::make_unexpected(unknown("member", name,
                                         "send settings, kind, from, priority, profile, reference, rescan, "
                                         "note, scan_id or ids of uploads"));
    if (is_settings    ? !value.is_object()
        : is_number    ? !value.is_number_integer()
        : is_yes_or_no ? !value.is_boolean()
                       : !value.is_string())
      return fail(Code::bad_usage,
                  std::string("not ") + (is_settings    ? "an object"
                                         : is_number    ? "a whole number"
                                         : is_yes_or_no ? "true or false"
                                                        : "a string"),
                  name, "see /api/v1/openapi.yaml");
    (is_settings ? settings : fields_[name]) = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return {};
}

}  // namespace vacuform
