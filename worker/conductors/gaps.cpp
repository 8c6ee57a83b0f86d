#include "worker/conductors/gaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "worker/pattern/drawn_loop.hpp"

namespace vacuform {

namespace {

bool is_within(const Eigen::Vector2d& p, const Area& area) {
  bool inside = false;
  for (const Ring& ring : area) inside ^= is_inside(p, ring);
  return inside;
}

// Where no middle of a gap may lie.
class Taken {
 public:
  Taken(const std::vector<Interval>& blocked, double half, double length) : length_(length) {
    for (const Interval& b : blocked) add(b, half);
  }
  void add(const Interval& blocked, double half) {
    parts_.push_back({blocked.from - half, blocked.to + half});
  }

  // The free place nearest to one, and how far that is; nothing if no place is free.
  struct Free {
    double at, moved;
  };
  std::optional<Free> nearest(double at) const {
    if (is_free(at)) return Free{at, 0};
    constexpr double past = 1e-6;
    std::optional<Free> best;
    for (const Interval& part : parts_)
      for (const double end : {part.from - past, part.to + past})
        if (const double moved = apart_on_loop(end, at, length_);
            is_free(end) && (!best || moved < best->moved))
          best = Free{end, moved};
    return best;
  }

 private:
  bool is_free(double at) const {
    return std::none_of(parts_.begin(), parts_.end(), [&](const Interval& part) {
      const double in = at - part.from;
      return in - length_ * std::floor(in / length_) <= part.length();
    });
  }

  const double length_;
  std::vector<Interval> parts_;
};

// The parts of a path whose points are not in a set, between those that are.
template <class In>
std::vector<Interval> parts_outside(const LoopPath& path, const In& is_in) {
  constexpr double step = 0.1, least = 0.05;
  const int count = std::max(8, static_cast<int>(std::ceil(path.length() / step)));
  const auto along = [&](int i) { return path.length() * i / count; };
  std::vector<char> inked;
  for (int i = 0; i < count; ++i) inked.push_back(is_in(path.at(along(i))));
  const auto border = [&](double in, double off) {
    for (int i = 0; i < 20; ++i) {
      const double middle = (in + off) / 2;
      (is_in(path.at(middle)) ? in : off) = middle;
    }
    return in;
  };
  std::vector<Interval> out;
  for (int i = 0; i < count; ++i) {
    if (!inked[static_cast<std::size_t>(i)] || inked[static_cast<std::size_t>((i + 1) % count)]) continue;
    int end = i + 1;
    while (!inked[static_cast<std::size_t>(end % count)]) ++end;
    const Interval gap{border(along(i), along(i + 1)), border(along(end), along(end - 1))};
    if (gap.length() >= least) out.push_back(gap);
  }
  return out;
}

}  // namespace

std::vector<Interval> drawn_gaps(const LoopPath& path, const Area& ink) {
  return parts_outside(path, [&](const Eigen::Vector2d& p) { return is_within(p, ink); });
}

std::vector<Interval> inked_parts(const LoopPath& path, const Islands& ink) {
  return parts_outside(path, [&](const Eigen::Vector2d& p) { return ink.at(p) < 0; });
}

int gaps_for_frequency(double length_mm, double width_mm, double frequency_mhz) {
  constexpr double light_mm_mhz = 299792.458, mu0_nh_mm = 0.4 * M_PI, most = 16;
  const double radius = length_mm / 2 / M_PI, omega = 2 * M_PI * frequency_mhz * 1e6;
  // A strip has the inductance of a round wire of a quarter of its width (Grover, Inductance Calculations, 1946).
  const double inductance_nh = mu0_nh_mm * radius * (std::log(32 * radius / width_mm) - 2);
  const double parts = length_mm / (light_mm_mhz / frequency_mhz / 10);
  const double total_pf = inductance_nh > 0 ? 1e12 / (omega * omega * inductance_nh * 1e-9) : least_gap_pf;
  constexpr double port_and_one = 2;
  return static_cast<int>(
      std::clamp(std::ceil(std::max(parts, least_gap_pf / total_pf)), port_and_one, most));
}

std::vector<double> places_for_gaps(double length, int count, const GapRoom& room, double port,
                                    const std::vector<Interval>& blocked) {
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  constexpr int rotations = 120;
  const double space = length / count;
  for (int r = 0; r < rotations; ++r) {
    // Nearest to the port first, so that of equals the nearest one is taken.
    const double shift = (r % 2 == 0 ? r / 2 : -(r + 1) / 2) * space / rotations;
    Taken taken(blocked, room.half, length);
    const Taken by_port(blocked, std::max(room.half, room.of_port), length);
    std::vector<double> places;
    double cost =
        std::abs(shift) / space;  // a gap that moves by a hundredth of a space counts as much as that
    for (int i = 0; i < count; ++i) {
      const double wanted = port + shift + i * space;
      auto found = i == 0 ? by_port.nearest(wanted) : taken.nearest(wanted);
      if (i == 0 && !found) found = taken.nearest(wanted);
      if (!found) {
        cost += 1e6;
        continue;
      }
      cost += std::pow(10 * found->moved / space, 2);
      places.push_back(found->at);
      const double half = i == 0 ? std::max(room.half, room.of_port) : room.half;
      taken.add({found->at - half, found->at + half}, room.half);
    }
    if (cost < least) least = cost, best = std::move(places);
  }
  return best;
}

}  // namespace vacuform
