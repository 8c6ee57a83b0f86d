#include "worker/inspection/layers_dxf.hpp"

#include "api/base/decimal.hpp"
#include "worker/printing/inked_rings.hpp"

namespace vacuform {

namespace {

// Pairs of a group code and a value, each on a line (Autodesk, DXF Reference, R12).
class Dxf {
 public:
  void add(int code, std::string_view value) {
    text_ += std::to_string(code);
    text_ += '\n';
    text_ += value;
    text_ += '\n';
  }
  void add(int code, double value) { add(code, decimal(value, 4)); }
  void add(int code, int value) { add(code, std::to_string(value)); }
  void begin(std::string_view section) {
    add(0, "SECTION");
    add(2, section);
  }
  void end() { add(0, "ENDSEC"); }
  std::string text() const { return text_ + "0\nEOF\n"; }

 private:
  std::string text_;
};

void add_ring(Dxf& dxf, const Ring& ring, std::string_view layer) {
  dxf.add(0, "POLYLINE");
  dxf.add(8, layer);
  dxf.add(66, 1);  // vertices follow
  dxf.add(70, 1);  // closed
  for (const Eigen::Vector2d& p : ring) {
    dxf.add(0, "VERTEX");
    dxf.add(8, layer);
    dxf.add(10, p.x());
    dxf.add(20, p.y());
  }
  dxf.add(0, "SEQEND");
  dxf.add(8, layer);
}

}  // namespace

std::string layers_dxf(const Finished& job) {
  Dxf dxf;
  dxf.begin("HEADER");
  dxf.add(9, "$ACADVER");
  dxf.add(1, "AC1009");
  dxf.add(9, "$INSUNITS");
  dxf.add(70, 4);
  dxf.end();
  dxf.begin("TABLES");
  dxf.add(0, "TABLE");
  dxf.add(2, "LAYER");
  dxf.add(70, static_cast<int>(job.print.layers.size()));
  int colour = 0;
  for (const Layer& layer : job.print.layers) {
    dxf.add(0, "LAYER");
    dxf.add(2, layer.name);
    dxf.add(70, 0);
    dxf.add(62, ++colour);
    dxf.add(6, "CONTINUOUS");
  }
  dxf.add(0, "ENDTAB");
  dxf.end();
  dxf.begin("ENTITIES");
  for (const Layer& layer : job.print.layers) {
    if (const VectorPrint* const vectors = layer.source->vectors())
      for (const Ring& ring : inked_rings(*vectors, 0.005)) add_ring(dxf, ring, layer.name);
  }
  dxf.end();
  return dxf.text();
}

}  // namespace vacuform
