#include "api/base/strict_json.hpp"

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace vacuform {

namespace {

// Sees each value as it is parsed and remembers the first thing that is wrong.
template <class Json>
class Inspector {
 public:
  explicit Inspector(int deepest) : deepest_(deepest) {}

  // False drops the value, so that nothing below `deepest` levels is kept.
  bool operator()(int depth, typename Json::parse_event_t event, Json& parsed) {
    using Event = typename Json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      if (depth >= deepest_)
        refuse("is nested more than " + std::to_string(deepest_) + " levels deep", "nest it less");
      names_.emplace_back();
    } else if (event == Event::object_end || event == Event::array_end) {
      names_.pop_back();
    } else if (event == Event::key) {
      const auto& name = parsed.template get_ref<const std::string&>();
      if (!names_.back().insert(name).second)
        refuse("holds the name \"" + name.substr(0, 64) + "\" twice", "give each name once");
    }
    return !error_;
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  void refuse(const std::string& what, const char* fix) {
    if (!error_) error_ = Error{Code::bad_usage, "the JSON " + what, "", fix};
  }
  int deepest_;
  std::vector<std::set<std::string>> names_;  // of the objects that are open
  std::optional<Error> error_;
};

}  // namespace

template <class Json>
Result<Json> strict_json(std::string_view text, int deepest) {
  Inspector<Json> inspector(deepest);
  try {
    Json value = Json::parse(text, std::ref(inspector));
    if (inspector.error()) return tl::make_unexpected(*inspector.error());
    return value;
  } catch (const nlohmann::json::parse_error& error) {
    if (inspector.error()) return tl::make_unexpected(*inspector.error());
    return fail(Code::bad_usage, "not valid JSON, near byte " + std::to_string(error.byte), "",
                "check quotes, commas and brackets");
  } catch (const nlohmann::json::out_of_range&) {  // such as 1e999
    return fail(Code::bad_usage, "the JSON holds a number that is too large", "", "give a smaller number");
  }
}

template Result<nlohmann::json> strict_json(std::string_view, int);
template Result<nlohmann::ordered_json> strict_json(std::string_view, int);

}  // namespace vacuform
