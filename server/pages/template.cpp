#include "server/pages/template.hpp"

#include <kainjow/mustache.hpp>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "server/pages/assets.hpp"

namespace vacuform {

using nlohmann::ordered_json;
namespace mustache = kainjow::mustache;

namespace {

// The text of a template with its partials in place, each without its last line end.
std::string text_of(std::string_view name, int depth = 0) {
  if (depth > 8) throw std::logic_error("a template contains itself: " + std::string(name));
  constexpr std::string_view begin = "{{> ", end = "}}";
  std::string text(asset(std::string(name) + ".mustache"));
  if (text.ends_with('\n')) text.pop_back();
  for (std::size_t at = 0; (at = text.find(begin, at)) != std::string::npos;) {
    const std::size_t after = text.find(end, at);
    if (after == std::string::npos) throw std::logic_error("a partial has no end: " + std::string(name));
    const std::string partial = text_of(text.substr(at + begin.size(), after - at - begin.size()), depth + 1);
    text.replace(at, after + end.size() - at, partial);
    at += partial.size();
  }
  return text;
}

mustache::mustache& parsed(std::string_view name) {
  static std::mutex mutex;
  static std::map<std::string, mustache::mustache, std::less<>> all;
  const std::lock_guard hold(mutex);
  const auto found = all.find(name);
  if (found != all.end()) return found->second;
  mustache::mustache made(text_of(name) + "\n");
  if (!made.is_valid()) throw std::logic_error(std::string(name) + ".mustache: " + made.error_message());
  return all.emplace(name, std::move(made)).first->second;
}

mustache::data data_of(const ordered_json& value) {
  if (value.is_null()) return false;
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return text.empty() ? mustache::data(false) : mustache::data(text);
  }
  if (value.is_array()) {
    mustache::data list(mustache::data::type::list);
    for (const auto& item : value) list.push_back(data_of(item));
    return list;
  }
  if (!value.is_object()) throw std::logic_error("a value for a template is a number");
  mustache::data object(mustache::data::type::object);
  for (const auto& [key, member] : value.items()) object.set(key, data_of(member));
  return object;
}

// Values that must be there: the library itself shows nothing for a name that it does not find.
class Values : public mustache::context<std::string> {
 public:
  Values(const mustache::data* data, std::string_view page) : context(data), page_(page) {}

  const mustache::data* get(const std::string& name) const override {
    const auto* found = context::get(name);
    if (!found) throw std::logic_error(page_ + ".mustache: there is no value for " + name);
    return found;
  }

 private:
  const std::string page_;
};

}  // namespace

std::string rendered(std::string_view name, const ordered_json& values) {
  const mustache::data data = data_of(values);
  Values context(&data, name);
  std::ostringstream text;
  auto& page = parsed(name);
  page.render(context, text);  // changes nothing of the parsed template
  if (!page.is_valid()) throw std::logic_error(std::string(name) + ".mustache: " + page.error_message());
  return std::move(text).str();
}

}  // namespace vacuform
