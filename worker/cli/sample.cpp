// vacuform sample: writes the bundled head form and coil pattern, or a model that wears colours.
#include <iostream>
#include <memory>
#include <string>

#include "worker/cli/commands.hpp"
#include "worker/sample/sample_files.hpp"

namespace vacuform::cli {

void add_sample(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("sample", "Write a bundled sample: a scan, and the pattern if it needs one");
  auto out = std::make_shared<std::string>();
  command->add_option("--out", *out, "Folder to write into; made when absent")->type_name("DIR")->required();
  auto model = std::make_shared<std::string>("head");
  command
      ->add_option(
          "--model", *model,
          "head: head.stl and pattern.svg with coils; mask or figurine: mask.glb or figurine.glb with "
          "colours of its own (pattern.source=scan)")
      ->check(CLI::IsMember({"head", "mask", "figurine"}));
  auto head = std::make_shared<std::string>("adult");
  command->add_option("--head", *head, "Size of the head form")->check(CLI::IsMember({"adult", "newborn"}));
  command->callback([out, model, head, &exit_code] {
    const HeadForm form = *head == "newborn" ? HeadForm::newborn : HeadForm::adult;
    if (const auto written = write_sample(*out, *model, form); !written)
      exit_code = refuse(written.error());
    else
      std::cout << "wrote " << (*model == "head" ? "head.stl and pattern.svg" : *model + ".glb") << " into "
                << *out << '\n';
  });
}

}  // namespace vacuform::cli
