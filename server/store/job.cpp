#include "server/store/job.hpp"

#include <algorithm>

namespace vacuform {

const Input* Job::input(std::string_view name) const {
  const auto found =
      std::find_if(inputs.begin(), inputs.end(), [&](const Input& i) { return i.name == name; });
  return found == inputs.end() ? nullptr : &*found;
}

void sort_inputs(std::vector<Input>& inputs) {
  std::sort(inputs.begin(), inputs.end(), [](const Input& a, const Input& b) {
    return input_kind(a.name) < input_kind(b.name);  // index in one table
  });
}

void NewJob::add(std::string name, std::variant<Upload, Blob> file, std::string extension) {
  inputs.push_back({std::move(name), std::move(file), std::move(extension)});
}

}  // namespace vacuform
