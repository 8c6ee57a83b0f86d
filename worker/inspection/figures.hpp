// Every figure of a finished job, computed once. Pictures, files and report only read them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "worker/conductors/electrical_check.hpp"
#include "worker/electrical/array_circuit.hpp"
#include "worker/inspection/both.hpp"
#include "worker/inspection/coil_figures.hpp"
#include "worker/inspection/stretched_traces.hpp"

namespace vacuform {

// A value with the area that has it.
struct Weighted {
  double value, area;
};
// Area-weighted. A percentile is the smallest value such that at least its share of the area has no larger one. All 0
// without values.
struct Statistics {
  double mean = 0, p95 = 0, p99 = 0, max = 0;
};
Statistics statistics(std::vector<Weighted> values);

// How the drawing comes out on the formed part. With the singular values s1 >= s2 of J, the map from pattern coordinates
// to the inked surface:
struct Distortion {
  Statistics shape;  // s1 / s2, the anisotropy: 1 where a circle stays round
  Statistics area;   // max(s1 s2, 1 / (s1 s2)): 1 where an area stays as large
};
// Of every triangle of the chart that has an area, on the inked surface, mm2.
struct DistortionValues {
  std::vector<Weighted> shape, area;
};

// Of one way to print the drawing, over the chart (Flattening::triangles).
struct WayFigures {
  DistortionValues triangles;
  Distortion chart;
  std::optional<Distortion> favoured, rest;  // of the parts of the chart, if the settings favour one
};

// Of a vector print.
struct Measured {
  CoilTable coils;
  TraceFigures traces;
  // Over the neighbourhoods of the elements that lie on the head, if the drawing has elements.
  std::optional<Both<Distortion>> elements = {};
  std::vector<Warning> warnings = {};  // of coils and traces
};

// Over formed area.
struct PlacedStatistics {
  Statistics values;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the largest, on the formed sheet, mm
};
// How far the colours of a scan lie off their place on the formed part, and how different they look (colour_errors.hpp).
struct ColourErrors {
  struct Figures {
    // From the pixel's origin on the scan to the formed place, mm. Contains the gap where the sheet does not reach the
    // scan.
    PlacedStatistics position;
    // From the pixel's origin to the place of the scan that is nearest to the formed place, mm: how far the colours
    // have moved on the scan.
    PlacedStatistics along;
    // CIEDE2000 between the pixel, on white, and the scan nearest to the formed place, both seen over a pixel. If the
    // ink is compensated, the pixel is as the stretched sheet shows it.
    PlacedStatistics colour;
  };
  Figures whole;     // where the print has colour, faded or not
  Figures touching;  // where the formed place is within reach of full colour
  // Means around each vertex of the sheet; NaN where the print has no colour.
  std::vector<double> position_of_vertices, colour_of_vertices;

  // The same where the sheet touches, if the print lies this far off its place on the sheet: towards +s, -s, +t and -t
  // in equal parts.
  struct OffRegister {
    double shift_mm = 0;
    Figures touching;
  };
  std::vector<OffRegister> off_register;  // by register_errors_mm
  // Where the largest of these shifts changes most what is seen of full colour: the place, the outward normal of the
  // sheet there, and the direction of the shift on the flat sheet, one of the four.
  struct Change {
    Eigen::Vector3d place = Eigen::Vector3d::Zero(), outward = Eigen::Vector3d::UnitZ();
    Eigen::Vector2d towards = Eigen::Vector2d::UnitX();
  };
  Change most_changed;
};

// Coils on the head as circuits, in the order of the coils.
struct CircuitFigures {
  std::vector<int> elements, coils;  // indices into Drawing::elements and CoilTable::coils
  std::vector<LoopOnPart> loops;
  double above_mm = 0;  // of the ink over the body
  ArrayCircuit array;
};

// Without: as drawn on the flat sheet. With: as printed.
struct Figures : Both<WayFigures> {
  // Of the sheet's vertices. How forming changes the flat sheet, the mean over the triangles around, weighted by formed
  // area; NaN off the chart.
  std::vector<double> shape, area;
  std::vector<double> mold_distance;  // from the vertex to the mold, mm
  // Least thickness of the sheet and of its part on the chart, mm. Pieces below a quarter of a cell of the grid, into which
  // the sheet is divided where it bends, do not count: their share of the plastic is chance.
  double least_thickness = 0, chart_least_thickness = 0;
  std::optional<Measured> measured;          // of a vector print
  std::optional<ElectricalCheck> circuits;   // of its loops
  std::optional<CircuitFigures> electrical;  // of its coils
  std::optional<ColourErrors> errors;        // of the colours of a scan, if they are printed
};

}  // namespace vacuform
