// Every setting, described once: its name, its range and unit, and its text for users. Parsing, defaults, the schema
// and the form follow from this. Only for settings.cpp and settings_json.cpp.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "api/settings.hpp"

namespace vacuform {

// The names of each enumeration's values, in the order of the values.
inline constexpr std::array<std::string_view, 7> unit_names{"auto", "um", "mm", "cm", "m", "in", "ft"};
inline constexpr std::array<std::string_view, 10> body_names{"auto",   "all",   "first", "second",  "third",
                                                             "fourth", "fifth", "sixth", "seventh", "eighth"};
inline constexpr std::array<std::string_view, 7> up_names{"auto", "+x", "-x", "+y", "-y", "+z", "-z"};
inline constexpr std::array<std::string_view, 5> side_names{"auto", "+x", "-x", "+y", "-y"};
inline constexpr std::array<std::string_view, 3> left_names{"unknown", "minus_x", "plus_x"};
inline constexpr std::array<std::string_view, 3> mirror_names{"auto", "no", "yes"};
inline constexpr std::array<std::string_view, 5> material_names{"petg", "pc", "abs", "hips", "pvc"};
inline constexpr std::array<std::string_view, 2> window_names{"rectangle", "circle"};
inline constexpr std::array<std::string_view, 3> source_names{"uniform", "heaters", "measured"};
inline constexpr std::array<std::string_view, 4> model_names{"membrane", "viscoplastic", "mass_spring",
                                                             "projection"};
inline constexpr std::array<std::string_view, 3> quality_names{"fast", "standard", "fine"};
inline constexpr std::array<std::string_view, 2> law_names{"neo_hookean", "mooney_rivlin"};
inline constexpr std::array<std::string_view, 2> integrator_names{"implicit_euler", "verlet"};
inline constexpr std::array<std::string_view, 5> method_names{"arap", "symmetric_dirichlet", "lscm",
                                                              "cgal_arap", "bfs"};
inline constexpr std::array<std::string_view, 4> weights_names{"uniform", "ink", "center", "painted"};
inline constexpr std::array<std::string_view, 3> pattern_source_names{"file", "scan", "both"};
inline constexpr std::array<std::string_view, 4> placement_names{"auto", "elements", "chart", "segments"};
inline constexpr std::array<std::string_view, 2> keep_names{"area", "diameter"};
inline constexpr std::array<std::string_view, 3> build_names{"single", "two_faces", "bridges"};
inline constexpr std::array<std::string_view, 4> case_names{"0805", "1111", "custom", "printed"};
inline constexpr std::array<std::string_view, 2> rule_names{"count", "frequency"};
inline constexpr std::array<std::string_view, 2> port_names{"edge", "top"};
inline constexpr std::array<std::string_view, 4> tail_names{"none", "nearest", "front", "back"};
inline constexpr std::array<std::string_view, 3> region_names{"dome", "front", "back"};
inline constexpr std::array<std::string_view, 2> face_names{"outer", "inner"};
inline constexpr std::array<std::string_view, 2> background_names{"white", "transparent"};

inline std::span<const std::string_view> names_of(Unit) { return unit_names; }
inline std::span<const std::string_view> names_of(BodyChoice) { return body_names; }
inline std::span<const std::string_view> names_of(UpAxis) { return up_names; }
inline std::span<const std::string_view> names_of(FrontSide) { return side_names; }
inline std::span<const std::string_view> names_of(LeftSide) { return left_names; }
inline std::span<const std::string_view> names_of(Mirror) { return mirror_names; }
inline std::span<const std::string_view> names_of(Material) { return material_names; }
inline std::span<const std::string_view> names_of(WindowShape) { return window_names; }
inline std::span<const std::string_view> names_of(HeatSource) { return source_names; }
inline std::span<const std::string_view> names_of(FormingModel) { return model_names; }
inline std::span<const std::string_view> names_of(FormingQuality) { return quality_names; }
inline std::span<const std::string_view> names_of(MembraneLaw) { return law_names; }
inline std::span<const std::string_view> names_of(Integrator) { return integrator_names; }
inline std::span<const std::string_view> names_of(FlatteningMethod) { return method_names; }
inline std::span<const std::string_view> names_of(FlatteningWeights) { return weights_names; }
inline std::span<const std::string_view> names_of(PatternSource) { return pattern_source_names; }
inline std::span<const std::string_view> names_of(PatternPlacement) { return placement_names; }
inline std::span<const std::string_view> names_of(CoilKeep) { return keep_names; }
inline std::span<const std::string_view> names_of(CoilBuild) { return build_names; }
inline std::span<const std::string_view> names_of(CapacitorCase) { return case_names; }
inline std::span<const std::string_view> names_of(GapRule) { return rule_names; }
inline std::span<const std::string_view> names_of(PortSide) { return port_names; }
inline std::span<const std::string_view> names_of(TailExit) { return tail_names; }
inline std::span<const std::string_view> names_of(ArrayRegion) { return region_names; }
inline std::span<const std::string_view> names_of(InkedFace) { return face_names; }
inline std::span<const std::string_view> names_of(Background) { return background_names; }

template <class E>
std::string_view name_of(E value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

struct Range {
  double low, high;
  std::string_view unit;
};

template <class S, class V>
void describe_heater(S& h, V& v) {
  v.field("x_mm", h.x_mm, {-2000, 2000, "mm"}, "Centre of the heater along x, from the sheet's centre");
  v.field("y_mm", h.y_mm, {-2000, 2000, "mm"}, "Centre of the heater along y, from the sheet's centre");
  v.field("z_mm", h.z_mm, {-2000, 2000, "mm"}, "Distance above the sheet; negative below it");
  v.field("width_mm", h.width_mm, {1, 4000, "mm"}, "Width of the heater, along x");
  v.field("height_mm", h.height_mm, {1, 4000, "mm"}, "Height of the heater, along y");
  v.field("celsius", h.celsius, {0, 1500, "C"}, "Temperature of its face; auto where the power is given");
  v.field("power_w", h.power_w, {0, 50000, "W"}, "Radiated power; auto where the temperature is given");
  v.field("emissivity", h.emissivity, {0.05, 1, "1"}, "Emissivity of its face");
  v.field("zone", h.zone, "Name of the zone that heat.gains turns up or down");
}

// The one description of all settings. A visitor has group(name, title) and, per kind of field,
// field(key, value&, text) for choices, switches, short names and the list of heaters, and
// field(key, value&, Range, text) for numbers and for numbers by name.
template <class S, class V>
void describe(S& s, V& v) {
  v.group("scan", "Scan: how the file becomes a mold");
  v.field(
      "units", s.scan.units,
      "Unit of the scan's coordinates; um is micrometres, ft is feet; auto guesses only when one unit makes "
      "a plausible size");
  v.field("size_mm", s.scan.size_mm, {10, 2000, "mm"},
          "Longest side of the whole scan, for models without a unit; auto goes by the unit");
  v.field("body", s.scan.body,
          "Which of several large separate bodies is taken, counted along the axis of the file on which they "
          "are farthest apart; auto refuses two heads, all makes one mold of all");
  v.field("up", s.scan.up, "The axis of the scan that points to the ceiling of the machine");
  v.field("mirror", s.scan.mirror,
          "Whether the scan is a mirror image, left and right swapped; auto warns where its triangles face "
          "inwards");
  v.field("roll_deg", s.scan.roll_deg, {-180, 180, "deg"}, "Turn about the x axis, after up");
  v.field("pitch_deg", s.scan.pitch_deg, {-180, 180, "deg"}, "Turn about the y axis, after the roll");
  v.field(
      "front", s.scan.front,
      "The side of the upright scan that is the face; it is turned to +y, before the yaw. Auto takes +z of a "
      "GLB, which glTF defines as the front, and otherwise the placed scan's +y");
  v.field(
      "yaw_deg", s.scan.yaw_deg, {-180, 180, "deg"},
      "Turn about the vertical axis, after the pitch; with scan.front at most 45 degrees either way, so that "
      "the face stays at +y");
  v.field("left_side", s.scan.left_side,
          "The side of the placed mold on which a person saw the patient's left; a face at +y has it at -x. "
          "Pictures, "
          "marks and report say so. It changes neither mold nor drawing");
  v.field("trim_mm", s.scan.trim_mm, {0, 2000, "mm"},
          "Height above the scan's lowest point at which it is cut; auto cuts where undercuts begin");
  v.field("clearance_mm", s.scan.clearance_mm, {0, 30, "mm"},
          "Offset skin around the scan, for padding or hair");

  v.group("sheet", "Sheet: the plastic");
  v.field("width_mm", s.sheet.width_mm, {50, 2000, "mm"}, "Width of the sheet, along x");
  v.field("height_mm", s.sheet.height_mm, {50, 2000, "mm"}, "Height of the sheet, along y");
  v.field("thickness_mm", s.sheet.thickness_mm, {0.05, 10, "mm"}, "Thickness before forming");
  v.field("material", s.sheet.material, "Plastic");
  v.field("resolution_mm", s.sheet.resolution_mm, {0.5, 20, "mm"}, "Grid spacing of the simulation");
  v.field("permittivity", s.sheet.permittivity, {1, 20, "1"},
          "Relative permittivity of the plastic at the frequency of the loops, for printed capacitors; none: "
          "by the material");
  v.field("loss_tangent", s.sheet.loss_tangent, {0, 0.5, "1"},
          "Loss tangent of the plastic there; none: by the material");
  v.field("thickness_tolerance", s.sheet.thickness_tolerance, {0, 0.5, "1"},
          "Share by which the thickness of the formed sheet may differ from the simulation, for the "
          "tolerance of printed "
          "capacitors");

  v.group("machine", "Machine: clamp frame and vacuum");
  v.field("window", s.machine.window, "Shape of the opening of the clamp frame");
  v.field("window_width_mm", s.machine.window_width_mm, {40, 2000, "mm"},
          "Width of the opening, or a circle's diameter");
  v.field("window_height_mm", s.machine.window_height_mm, {40, 2000, "mm"},
          "Height of the opening; a circle ignores it");
  v.field("drape_height_mm", s.machine.drape_height_mm, {0, 500, "mm"},
          "Height above the platform at which the frame stops and the vacuum starts");
  v.field("drape_speed_mm_s", s.machine.drape_speed_mm_s, {0.1, 1000, "mm/s"},
          "Speed of the frame's descent");
  v.field("vacuum_kpa", s.machine.vacuum_kpa, {1, 101, "kPa"},
          "Pressure difference at the end of the vacuum ramp");
  v.field("vacuum_seconds", s.machine.vacuum_seconds, {0.01, 600, "s"}, "Length of the vacuum ramp");
  v.field("plug_height_mm", s.machine.plug_height_mm, {0, 500, "mm"},
          "Height of a straight plug under the mold, of the mold's own outline");
  v.field("heaters", s.machine.heaters,
          "Flat radiant heaters, as a list such as [{\"x_mm\": 0, \"y_mm\": 0, \"z_mm\": 150, "
          "\"width_mm\": 200, \"height_mm\": 200, \"celsius\": 500}]");
  v.field("reflector_mm", s.machine.reflector_mm, {0, 2000, "mm"},
          "Height of mirror walls around the heaters, from their face towards the sheet; 0 for none");
  v.field("reflectance", s.machine.reflectance, {0, 1, "1"}, "Reflectance of those walls");
  v.field("lip_mm", s.machine.lip_mm, {0, 200, "mm"},
          "Height of the clamp frame's inner edge over each face of the sheet, which shades it");

  v.group("heat", "Heat: how warm the sheet is when it meets the mold");
  v.field("source", s.heat.source,
          "Uniform, computed from the machine's heaters, or measured and given as a file");
  v.field("temperature_c", s.heat.temperature_c, {20, 300, "C"},
          "Temperature of the sheet; auto is the middle of the plastic's forming window");
  v.field("seconds", s.heat.seconds, {0.1, 3600, "s"},
          "Time under the heaters; auto heats until the mean of the sheet is at its temperature");
  v.field("transfer_seconds", s.heat.transfer_seconds, {0, 120, "s"},
          "Time between heaters and mold, in which the sheet cools");
  v.field("ambient_c", s.heat.ambient_c, {-20, 200, "C"},
          "Temperature of air and surroundings, and of the sheet at first");
  v.field("convection_w_m2k", s.heat.convection_w_m2k, {0, 100, "W/m2K"},
          "Heat transfer between each face and the air; 5 to 10 in still air");
  v.field("gains", s.heat.gains, {0, 10, "1"},
          "Share of their power at which zones of heaters run, such as {\"rim\": 1.2}");
  v.field("black_c", s.heat.black_c, {-50, 500, "C"}, "Temperature that black means in a measured picture");
  v.field("white_c", s.heat.white_c, {-50, 500, "C"}, "Temperature that white means in a measured picture");

  v.group("forming", "Forming: the simulation");
  v.field("model", s.forming.model, "Model of the sheet");
  v.field(
      "law", s.forming.law,
      "Law of the membrane: mooney_rivlin hardens as it stretches; neo_hookean does not, and tears on deep "
      "molds");
  v.field(
      "quality", s.forming.quality,
      "Standard forms on the grid spacing, fine on half of it; fast extrapolates from grids of four and two "
      "times the spacing (membrane), for a first look");
  v.field("edge_stiffness", s.forming.edge_stiffness, {0.1, 10, "1"},
          "Stiffness of the sheet at the clamp frame against its centre, as calibrated");
  v.field("sag", s.forming.sag, "The hot sheet sags under its own weight");
  v.field(
      "step_mm", s.forming.step_mm, {0.1, 20, "mm"},
      "The frame descends no further between two searches for contact (membrane); auto is two thirds of the "
      "grid spacing");
  v.field(
      "thin_limit", s.forming.thin_limit, {0, 1, "1"},
      "Share of its thickness below which a thin place is a warning; 0 turns off this warning and the check "
      "whether the sheet tears, so a torn sheet is printed without a word");
  v.field("yield_kpa", s.forming.yield_kpa, {0, 1000, "kPa"},
          "Stress below which a viscoplastic sheet stays elastic");
  v.field("integrator", s.forming.integrator, "Time integration of the mass-spring model");
  v.field("time_step_ms", s.forming.time_step_ms, {0.001, 1000, "ms"},
          "Time step of the mass-spring model; auto suits the integrator");

  v.group("flattening", "Flattening: from the formed sheet back to the drawing");
  v.field("method", s.flattening.method, "Method of flattening");
  v.field("lambda", s.flattening.lambda, {0, 1e6, "1"},
          "0 keeps angles, the larger the more areas too; auto is as rigid as possible");
  v.field("weights", s.flattening.weights, "Where the chart is distorted least");
  v.field("weight", s.flattening.weight, {1, 1000, "1"}, "Weight of those places against the rest");
  v.field("pins", s.flattening.pins, {-2000, 2000, "mm"},
          "Points of the sheet held at points of the chart, as rows [s, t, u, v]");

  v.group("pattern", "Pattern: how the drawing lies on the head");
  v.field("source", s.pattern.source,
          "What is printed: the drawing of a file, the colours of the scan itself, which needs no file, or "
          "both, each as its own print");
  v.field("fade_mm", s.pattern.fade_mm, {0, 100, "mm"},
          "Colours of the scan: where the sheet does not touch it they fade out over this distance; 0: none "
          "there");
  v.field("width_mm", s.pattern.width_mm, {1, 2000, "mm"},
          "Physical width of the drawing; auto takes the file's own");
  v.field("dpi", s.pattern.dpi, {10, 10000, "1/in"},
          "Pixels an inch of the drawing, where its size is in px, without a unit, or contradictory; auto "
          "takes the "
          "program's own where that is known");
  v.field("length_limit", s.pattern.length_limit, {0.001, 1, "1"},
          "Error of lengths on the formed part above which a warning says so");
  v.field("line_mm", s.pattern.line_mm, {0.01, 100, "mm"},
          "Width of the lines of a DXF that have neither a width nor a line weight");
  v.field("placement", s.pattern.placement,
          "Each coil in its own neighbourhood, all on one chart, or on several with seams; auto: elements "
          "where there are");
  v.field("offset_mm", s.pattern.offset_mm, {-500, 500, "mm"},
          "The drawing's centre, from the top of the mold along the inked surface");
  v.field("rotate_deg", s.pattern.rotate_deg, {-360, 360, "deg"}, "Turn of the drawing, counter-clockwise");
  v.field("scale", s.pattern.scale, {0.01, 100, "1"},
          "Size of the drawing on the head against the drawing itself");
  v.field("points", s.pattern.points, {-2000, 2000, "mm"},
          "Points of the drawing and the points of the mold where they go, as rows [u, v, x, y, z]");
  v.field("distortion_limit", s.pattern.distortion_limit, {1.01, 10, "1"},
          "Segments: the most that one may stretch or shrink what is drawn on it");
  v.field("seams", s.pattern.seams, {-2000, 2000, "mm"},
          "Segments: cuts to make, as rows [x, y, z, x, y, z] from a point of the mold to another");
  v.field("inked_face", s.pattern.inked_face,
          "Face of the sheet that carries the ink; the inner face touches the mold");

  v.group("coils", "Coils: loops that must not couple");
  v.field("keep", s.coils.keep,
          "What a coil keeps on the head: the area inside it, or its diameter along the surface");
  v.field("decouple", s.coils.decouple,
          "Move and resize loops until they couple as little as the surface lets them");
  v.field("size_limit", s.coils.size_limit, {0, 0.5, "1"}, "Largest change of a loop's size by decoupling");
  v.field("stretch_limit", s.coils.stretch_limit, {0, 5, "1"}, "Stretch at which the ink of a trace fails");
  v.field(
      "build", s.coils.build,
      "What parts loops that cross: nothing (one layer of ink joins them), the two faces of the sheet with "
      "bridges where two do not suffice, or bridges");
  v.field("patch_margin_mm", s.coils.patch_margin_mm, {0.2, 10, "mm"},
          "Dielectric of a bridge beyond both conductors that it parts");
  v.field("bridge_overlap_mm", s.coils.bridge_overlap_mm, {0.2, 20, "mm"},
          "Overlap of a bridge with each end of its loop");
  v.field("clearance_mm", s.coils.clearance_mm, {0.05, 10, "mm"},
          "Least distance between conductors of different loops");
  v.field("gap_rule", s.coils.gap_rule,
          "How many gaps for capacitors a loop has that is drawn without: coils.gaps, or as few as its "
          "frequency allows "
          "(parts of at most a tenth of a wavelength, capacitors of at least 2 pF)");
  v.field("gaps", s.coils.gaps, {0, 16, "1"},
          "Gaps for capacitors in each loop that is drawn without, the first of them its port; 0 leaves "
          "loops closed");
  v.field("capacitor", s.coils.capacitor,
          "Case of the capacitors: the size of the pads at each gap; printed: a plate on the other face of "
          "the sheet under "
          "each gap but the port, which has the pads of 0805");
  v.field("gap_mm", s.coils.gap_mm, {0.1, 20, "mm"}, "Between the pads of a custom case");
  v.field("pad_length_mm", s.coils.pad_length_mm, {0.1, 20, "mm"}, "Pad of a custom case, along the trace");
  v.field("pad_width_mm", s.coils.pad_width_mm, {0.1, 20, "mm"}, "Pad of a custom case, across the trace");
  v.field("plate_width_mm", s.coils.plate_width_mm, {1, 60, "mm"},
          "Plates of printed capacitors, across the trace");
  v.field("port", s.coils.port,
          "Where the cables leave: each loop's port is on its side towards the edge, or the top");
  v.field(
      "tails", s.coils.tails,
      "A tail for each loop: two printed leads from its port to pads beside the head, by the shortest way "
      "(nearest), or to "
      "its front or back");
  v.field("tail_width_mm", s.coils.tail_width_mm, {0.2, 10, "mm"},
          "Width of each of the two leads of a tail; they are as far apart as the port is wide");

  v.group("circuit", "Circuit: the loops at their frequency");
  v.field("frequency_mhz", s.circuit.frequency_mhz, {1, 1000, "MHz"},
          "Frequency of the loops; 63.87, 127.74 and 298.04 for hydrogen at 1.5, 3 and 7 T");
  v.field("conductivity", s.circuit.conductivity, {0.01, 5, "S/m"}, "Conductivity of the body");
  v.field("ink_mohm", s.circuit.ink_mohm, {0.1, 10000, "mohm"},
          "Resistance of a square of the conductor as it is printed and cured, before it is stretched");
  v.field("ink_stretch", s.circuit.ink_stretch, {1, 1000, "1"},
          "What stretch does to the ink, as rows [length of the trace over its printed length, resistance "
          "over that of an "
          "ink that only changes its shape]; none: 1 everywhere, a lower bound");
  v.field("ink_um", s.circuit.ink_um, {0.1, 500, "um"},
          "Thickness of the conductor as it is printed and cured");
  v.field("dielectric_um", s.circuit.dielectric_um, {0.1, 500, "um"},
          "Thickness of the dielectric as it is printed and cured");
  v.field("port_ohm", s.circuit.port_ohm, {1, 1000, "ohm"}, "What each port is matched to");
  v.field("preamp_db", s.circuit.preamp_db, {0, 60, "dB"},
          "By how much preamplifiers of low impedance reduce the currents in the loops");

  v.group("layout", "Layout: an array of coils made for a scan, for jobs of kind layout");
  v.field("count", s.layout.count, {4, 64, "1"}, "Number of coils");
  v.field(
      "diameter_mm", s.layout.diameter_mm, {0, 300, "mm"},
      "Diameter of the coils, at least 10 mm; 0 takes the largest that fit on the region and couple little");
  v.field("region", s.layout.region,
          "The whole dome, or its front half (towards +y of the mold; scan.yaw_deg turns the head), or its "
          "back half");
  v.field("overlap", s.layout.overlap, {0, 1.5, "1"},
          "Distance of neighbouring centres over the diameter, at least 0.5, without decoupling; 0 decouples "
          "them");

  v.group("print", "Print: the file for the printer");
  v.field("dpi", s.print.dpi, {72, 1200, "1/in"}, "Resolution of print.png");
  v.field("marks", s.print.marks, "Registration marks, ruler, sheet edge and text");
  v.field("margin_mm", s.print.margin_mm, {0, 50, "mm"}, "Free of marks along the sheet's edge");
  v.field("compensate_width", s.print.compensate_width,
          "Wider traces of loops where the sheet stretches more, at most three times as wide, so that each "
          "millimetre of the "
          "array has the same resistance; not within bridges and gaps");
  v.field("compensate_ink", s.print.compensate_ink,
          "More ink where the sheet stretches more; pictures in shades of gray only");
  v.field(
      "compensate_colours", s.print.compensate_colours,
      "Colours of the scan: more ink where the sheet stretches more, by the area ratio and print.ink_curve");
  v.field(
      "ink_curve", s.print.ink_curve, {0, 4, "1"},
      "Ink that the printer lays, as rows [printed, cyan, magenta, yellow] from all 0 to printed 1; none: "
      "linear. 1 covers unstretched plastic fully; vacuform chart measures it");
  v.field("background", s.print.background,
          "What print.png has where there is no ink; a drawing in shades of gray is always on white");
}

}  // namespace vacuform
