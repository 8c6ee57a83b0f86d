#include "api/base/base64.hpp"
#include "worker/inspection/report_html.hpp"
#include "worker/inspection/shrunk_png.hpp"

namespace vacuform {

std::string embedded_png(const std::vector<std::uint8_t>& png, int width, int skipped) {
  const std::vector<std::uint8_t> small = shrunk_png(png, width, skipped, false);
  return to_base64({reinterpret_cast<const char*>(small.data()), small.size()});
}

}  // namespace vacuform
