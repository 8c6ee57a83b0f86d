// make_sample FOLDER: writes the bundled head form and coil pattern, as `vacuform sample --out FOLDER` does.
#include <iostream>

#include "worker/sample/sample_files.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_sample FOLDER\n";
    return 2;
  }
  if (const auto written = vacuform::write_sample(argv[1], "head", vacuform::HeadForm::adult); !written) {
    std::cerr << "make_sample: " << written.error().text() << '\n';
    return 1;
  }
  return 0;
}
