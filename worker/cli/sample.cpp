// vacuform sample: writes the bundled head form and coil pattern.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "worker/cli/commands.hpp"
#include "worker/sample/sample.hpp"
#include "worker/scan/mold.hpp"

namespace vacuform::cli {

namespace {

template <class Bytes>
Result<void> write(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    return fail(Code::unreadable, "cannot write the file", path.string(),
                "choose a folder you may write to, with room");
  return {};
}

Result<void> write_sample(const std::filesystem::path& out, HeadForm form) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error)
    return fail(Code::unreadable, "cannot make the folder: " + error.message(), out.string(),
                "choose a folder you may write to");
  VACUFORM_CHECK(write(out / "head.stl", stl_bytes(sample_head(form))));
  VACUFORM_CHECK(write(out / "pattern.svg", sample_pattern()));
  return {};
}

}  // namespace

void add_sample(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("sample", "Write the bundled sample: head.stl and pattern.svg");
  auto out = std::make_shared<std::string>();
  command->add_option("--out", *out, "Folder to write into; made when absent")->type_name("DIR")->required();
  auto head = std::make_shared<std::string>("adult");
  command->add_option("--head", *head, "Size of the head form")->check(CLI::IsMember({"adult", "newborn"}));
  command->callback([out, head, &exit_code] {
    const HeadForm form = *head == "newborn" ? HeadForm::newborn : HeadForm::adult;
    if (const auto written = write_sample(*out, form); !written)
      exit_code = refuse(written.error());
    else
      std::cout << "wrote head.stl and pattern.svg into " << *out << '\n';
  });
}

}  // namespace vacuform::cli
