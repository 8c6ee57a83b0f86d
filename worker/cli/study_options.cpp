#include "worker/cli/study_options.hpp"

#include "api/job_inputs.hpp"

#include <fstream>

#include "worker/pipeline/inputs.hpp"

namespace vacuform::cli {

void StudyOptions::add_to(CLI::App& command) {
  command.add_option("--scan", scan, "STL, OBJ, PLY, OFF, GLB, or a zip with an OBJ or PLY and its images")
      ->required()
      ->type_name("FILE");
  settings.add_to(command);
  command
      .add_option("--temperature", temperature,
                  "Measured temperature of the sheet: CSV of degrees Celsius, or a gray PNG")
      ->type_name("FILE");
}

Result<Study> StudyOptions::read() const {
  Study study;
  VACUFORM_TRY(object, settings.read());
  VACUFORM_TRY(parsed, settings_from_json(object));
  study.written = std::move(object);
  study.settings = std::move(parsed);
  VACUFORM_TRY(bytes, read_file(scan));
  study.scan = {std::move(bytes), scan};
  if (temperature.empty()) return study;
  VACUFORM_TRY(measured, read_file(temperature));
  study.temperature = InputFile{std::move(measured), temperature};
  use_inputs([](std::string_view name) { return name == "temperature"; }, study.settings);
  return study;
}

Result<void> write_json(const std::string& path, const nlohmann::ordered_json& value) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << value.dump(2) << '\n';
  out.close();
  if (!out)
    return fail(Code::unreadable, "the file cannot be written", path,
                "check the folder's permissions and the free space");
  return {};
}

}  // namespace vacuform::cli
