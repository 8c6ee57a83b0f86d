// The settings of a job: one structure, one schema, the same for the API, the command line and the web form.
// Every field is described once, in settings.cpp; parsing, defaults, the schema and the form follow from that.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/error.hpp"
#include "api/job.hpp"

namespace vacuform {

enum class Unit { automatic, um, mm, cm, m, in, ft };
enum class BodyChoice { automatic, all, first, second, third, fourth, fifth, sixth, seventh, eighth };
enum class UpAxis { automatic, plus_x, minus_x, plus_y, minus_y, plus_z, minus_z };
enum class FrontSide { automatic, plus_x, minus_x, plus_y, minus_y };
enum class LeftSide { unknown, minus_x, plus_x };
enum class Mirror { automatic, no, yes };
enum class Material { petg, pc, abs, hips, pvc };
enum class WindowShape { rectangle, circle };
enum class HeatSource { uniform, heaters, measured };
enum class FormingModel { membrane, viscoplastic, mass_spring, projection };
enum class FormingQuality { fast, standard, fine };
enum class MembraneLaw { neo_hookean, mooney_rivlin };
enum class Integrator { implicit_euler, verlet };
enum class FlatteningMethod { arap, symmetric_dirichlet, lscm, cgal_arap, bfs };
enum class FlatteningWeights { uniform, ink, center, painted };
enum class PatternSource { file, scan, both };
enum class PatternPlacement { automatic, elements, chart, segments };
enum class CoilKeep { area, diameter };
enum class CoilBuild { single, two_faces, bridges };
enum class GapRule { count, frequency };
enum class CapacitorCase { c0805, c1111, custom, printed };
enum class PortSide { edge, top };
// Where the tails of the loops end beside the head; front and back as of ArrayRegion.
enum class TailExit { none, nearest, front, back };
// Front is the half of the formed part towards +y, back the other; scan.yaw_deg turns the head.
enum class ArrayRegion { dome, front, back };
enum class InkedFace { outer, inner };
enum class Background { white, transparent };

struct ScanSettings {
  Unit units = Unit::automatic;
  std::optional<double>
      size_mm;  // longest side of the whole scan, where nobody knows its unit; none: by units
  BodyChoice body = BodyChoice::automatic;  // of several large separate ones (worker/scan/bodies.hpp)
  UpAxis up = UpAxis::automatic;
  Mirror mirror =
      Mirror::automatic;  // of the upright scan in x = 0; automatic: not, with a warning where it might be
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;  // then turned about x, y, z, in this order
  FrontSide front =
      FrontSide::automatic;  // of the scan before its yaw: comes to +y; automatic: +Z of a glTF file, else +y
  LeftSide left_side = LeftSide::unknown;  // of the placed mold, where a person saw the patient's left
  std::optional<double> trim_mm;  // height above the scan's lowest point; none: where undercuts begin
  double clearance_mm = 0;        // offset skin for padding or hair
};

struct SheetSettings {
  double width_mm = 300, height_mm = 300;  // along s (x) and t (y)
  double thickness_mm = 1;
  Material material = Material::petg;
  double resolution_mm = 1.5;  // grid spacing
  // As the dielectric of printed capacitors; none: by the material (worker/electrical/sheet_dielectric.hpp).
  std::optional<double> permittivity, loss_tangent;
  double thickness_tolerance = 0.05;  // of the formed sheet, as a share
};

// A flat radiant heater that faces the sheet.
struct Heater {
  double x_mm = 0, y_mm = 0;               // its centre, from the sheet's
  double z_mm = 150;                       // above the sheet; negative: below it
  double width_mm = 100, height_mm = 100;  // along x and y
  std::optional<double> celsius;           // of its face; either this
  std::optional<double> power_w;           // or what its face radiates more than it receives
  double emissivity = 0.9;
  std::string zone;  // heaters that are turned up and down together (HeatSettings::gains)
};

struct MachineSettings {
  WindowShape window = WindowShape::rectangle;
  double window_width_mm = 280, window_height_mm = 280;  // a circle's diameter is the width
  double drape_height_mm = 0;  // where the clamp frame stops above the platform, and the vacuum starts
  double drape_speed_mm_s = 50;
  double vacuum_kpa = 85;     // the limit of the vacuum ramp
  double vacuum_seconds = 2;  // from nothing to the limit
  double plug_height_mm = 0;  // of a straight plug under the mold, of its own outline
  std::vector<Heater> heaters;
  double reflector_mm = 0;   // mirror walls around the heaters, from their face towards the sheet; 0: none
  double reflectance = 0.8;  // of those walls
  double lip_mm = 0;  // upright inner edge of the clamp frame on both faces of the sheet, which shades it
};

struct HeatSettings {
  HeatSource source = HeatSource::uniform;
  std::optional<double> temperature_c;     // none: the middle of the material's forming window
  std::optional<double> seconds;           // under the heaters; none: until the sheet's mean is temperature_c
  double transfer_seconds = 2;             // from the heaters to the mold
  double ambient_c = 23;                   // of the air, the surroundings, and the sheet at first
  double convection_w_m2k = 7;             // between each face and the air
  std::map<std::string, double> gains;     // by zone: its heaters' share of their power
  std::optional<double> black_c, white_c;  // what black and white mean in a measured picture
};

struct FormingSettings {
  FormingModel model = FormingModel::membrane;
  MembraneLaw law = MembraneLaw::mooney_rivlin;
  // On a grid of sheet.resolution_mm, or of half of it (fine), or extrapolated to it from grids of four and two times the
  // spacing (fast; membrane only).
  FormingQuality quality = FormingQuality::standard;
  double edge_stiffness = 1;  // of the sheet at the clamp frame against its centre, by calibration
  bool sag = false;           // under its own weight while it is hot
  // membrane: the frame descends no further between two searches for contact; none: two thirds of the grid's spacing
  std::optional<double> step_mm;
  double thin_limit = 0.3;  // of the thickness before forming: below it, a warning is given; 0: nothing tears
  double yield_kpa = 0;     // viscoplastic: stress below which the sheet is elastic
  Integrator integrator = Integrator::implicit_euler;  // mass_spring
  std::optional<double> time_step_ms;                  // mass_spring; none: chosen for the integrator
};

struct FlatteningSettings {
  FlatteningMethod method = FlatteningMethod::arap;
  std::optional<double>
      lambda;  // arap, cgal_arap: 0 keeps angles, the larger the more areas; none: as rigid as possible
  FlatteningWeights weights = FlatteningWeights::uniform;
  double weight = 10;                       // of what weights favours, against the rest
  std::vector<std::array<double, 4>> pins;  // rows s, t, u, v: sheet points held at points of the chart
};

struct PatternSettings {
  PatternSource source = PatternSource::
      file;            // scan: the colours of the scan itself, and no drawing; both: each as its own print
  double fade_mm = 3;  // of those colours, where the sheet does not touch the scan; 0: none there
  std::optional<double> width_mm;  // physical width; none: the file's own size
  std::optional<double>
      dpi;  // pixels an inch: of a picture, or of an SVG in px or without unit; none: by the file
  double length_limit = 0.02;                                // error of lengths above which a warning says so
  std::optional<double> line_mm;                             // width of the lines of a DXF that have none
  PatternPlacement placement = PatternPlacement::automatic;  // elements where the drawing has them
  std::array<double, 2> offset_mm{0, 0};  // the pattern's centre, from the top of the mold along the surface
  double rotate_deg = 0;                  // counter-clockwise on the inked face as drawn
  double scale = 1;
  // Rows u, v, x, y, z: points of the drawing and of the mold to match. One moves the drawing; a second also rotates
  // it; three or more do both by least squares. offset_mm and rotate_deg are then added.
  std::vector<std::array<double, 5>> points;
  double distortion_limit = 1.1;  // segments: of each, as worker/placement/segments.hpp defines it
  // segments: rows x, y, z, x, y, z, each a cut from a point of the mold to another; rows that share points continue
  std::vector<std::array<double, 6>> seams;
  InkedFace inked_face = InkedFace::outer;
};

struct CoilSettings {
  // What of a drawn coil is the same on the surface: worker/surface/polar_grid.hpp defines both.
  CoilKeep keep = CoilKeep::area;
  bool decouple = false;       // moves and resizes loops until they couple little
  double size_limit = 0.05;    // largest change of a loop's size by that
  double stretch_limit = 0.2;  // of a trace, at which its ink fails
  // What parts loops that cross: nothing, the two faces of the sheet with bridges where these do not suffice, or bridges.
  CoilBuild build = CoilBuild::single;
  double patch_margin_mm = 0.5;    // of the dielectric beyond the conductors that it parts
  double bridge_overlap_mm = 1.5;  // of a bridge on each end of the loop below it
  double clearance_mm = 0.5;       // least distance of conductors of different loops
  // Gaps for capacitors in each loop without drawn ones, one of them the port: `gaps` of them, 0 for none; or as few as leave
  // parts of at most a tenth of a wavelength and capacitors of at least 2 pF at circuit.frequency_mhz.
  GapRule gap_rule = GapRule::count;
  int gaps = 0;
  CapacitorCase capacitor = CapacitorCase::c0805;
  double gap_mm = 1, pad_length_mm = 1,
         pad_width_mm = 1.5;        // of a custom case: between the pads, along, across
  double plate_width_mm = 8;        // of printed capacitors, across the trace
  PortSide port = PortSide::edge;   // where the cables leave
  TailExit tails = TailExit::none;  // two leads from each port to pads beside the head
  double tail_width_mm = 1.5;       // of each of the two leads
};

// Loops as circuits at their frequency (worker/electrical).
struct CircuitSettings {
  double frequency_mhz = 127.74;  // of the hydrogen nucleus at 3 T
  double conductivity = 0.6;      // of the body, S/m
  double ink_mohm = 25;           // per square, as printed and cured, before it is stretched
  // Rows of the length of a trace over its printed length and of its resistance over that of an ink that only changes its
  // shape; none: 1 everywhere, which is a lower bound.
  std::vector<std::array<double, 2>> ink_stretch;
  double ink_um = 10, dielectric_um = 40;  // thickness as printed and cured
  double port_ohm = 50;                    // of the cable or the preamplifier's match
  double preamp_db = 20;  // by which preamplifiers of low impedance reduce the currents in the loops
};

// An array of loops of one size, for jobs of kind layout.
struct LayoutSettings {
  int count = 16;
  double diameter_mm = 0;  // 10 to 300; 0: the largest that fit on the region and couple little
  ArrayRegion region = ArrayRegion::dome;
  double overlap =
      0;  // distance of neighbouring centres over the diameter, 0.5 to 1.5; 0: they are decoupled
};

// Rows printed, cyan, magenta, yellow: worker/colour/ink_curve.hpp. The first row is all 0, the last printed is 1.
using InkCurveRows = std::vector<std::array<double, 4>>;

struct PrintSettings {
  int dpi = 300;
  bool marks = true;
  double margin_mm = 3;                       // free of marks along the sheet's edge
  bool compensate_width = false;              // wider traces of loops where the sheet stretches more
  bool compensate_ink = false;                // more ink where the sheet stretches more; shades of gray only
  bool compensate_colours = true;             // the same for the colours of a scan, by the curve of the ink
  InkCurveRows ink_curve;                     // none: linear
  Background background = Background::white;  // of print.png where the drawing has colours
};

struct Settings {
  ScanSettings scan;
  SheetSettings sheet;
  MachineSettings machine;
  HeatSettings heat;
  FormingSettings forming;
  FlatteningSettings flattening;
  PatternSettings pattern;
  CoilSettings coils;
  CircuitSettings circuit;
  LayoutSettings layout;
  PrintSettings print;
};

// The spacing of the simulation's grid, mm.
inline double grid_spacing_mm(const SheetSettings& sheet, const FormingSettings& forming) {
  return sheet.resolution_mm / (forming.quality == FormingQuality::fine ? 2 : 1);
}
inline double grid_spacing_mm(const Settings& settings) {
  return grid_spacing_mm(settings.sheet, settings.forming);
}

// Parses a JSON object of groups; fields that are absent keep their defaults. Refuses, by its dotted name, every
// unknown group or key, every value of the wrong type or out of range, and combinations that contradict each other
// (Code::bad_settings). The message names the range or the choices.
Result<Settings> settings_from_json(const nlohmann::json& object);
Result<Settings> settings_from_text(
    std::string_view text);  // the same from JSON text; an empty text is all defaults
// JSON text as strict_json() reads it, before its groups and keys are looked at. Errors: bad_settings.
Result<nlohmann::json> settings_json(std::string_view text);

// What only shows when the kind of the job is known: the group layout is for layouts alone, and a layout has no drawing
// that could weigh the flattening. Errors: bad_settings, naming the setting.
Result<void> check_for(JobKind kind, const Settings& settings);

// Applies one "group.key=value" to a JSON object of settings that is parsed later. The value is read as JSON where
// it is JSON (3, true, "auto", [1, 2]) and as a string otherwise (petg). Refuses a text without a dot or '='.
Result<void> set_in_json(nlohmann::json& object, std::string_view assignment);

// Every field with its value, in the order of the schema.
nlohmann::ordered_json to_json(const Settings& settings);

// JSON Schema (2020-12) with title, description, default, minimum, maximum, unit ("x-unit") and choices of each field.
nlohmann::ordered_json settings_schema();

std::string_view name(Unit);
std::string_view name(BodyChoice);
std::string_view name(UpAxis);
std::string_view name(FrontSide);
std::string_view name(LeftSide);
std::string_view name(Material);
std::string_view name(CoilKeep);
std::string_view name(InkedFace);
std::string_view name(HeatSource);
std::string_view name(FormingModel);
std::string_view name(MembraneLaw);
std::string_view name(FormingQuality);

}  // namespace vacuform
