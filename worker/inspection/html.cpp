#include "worker/inspection/html.hpp"

#include <algorithm>
#include <cmath>

#include "api/base/decimal.hpp"

namespace vacuform::html {

namespace {

// Three to six round ticks from `low` to at least `high`.
double tick_step(double low, double high) {
  const double wanted = std::max(1e-9, high - low) / 5,
               decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0})
    if (factor * decade >= wanted * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}
int places_of(double step) {
  int places = 0;
  for (; places < 6 && std::abs(step - std::round(step)) > 1e-6; step *= 10) ++places;
  return places;
}

std::string number(double value) { return decimal(value, 1); }

std::string rectangle(double x, double y, double width, double height, const char* kind) {
  return "<rect class=\"" + std::string(kind) + "\" x=\"" + number(x) + "\" y=\"" + number(y) +
         "\" width=\"" + number(width) + "\" height=\"" + number(height) + "\"/>";
}
std::string line(double x1, double y1, double x2, double y2, const char* kind) {
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + number(x1) + "\" y1=\"" + number(y1) +
         "\" x2=\"" + number(x2) + "\" y2=\"" + number(y2) + "\"/>";
}
std::string words(double x, double y, const char* anchor, std::string_view text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + std::string(anchor) +
         "\">" + escaped(text) + "</text>";
}
std::string open_svg(double width, double height, const std::string& title) {
  return "<svg viewBox=\"0 0 " + number(width) + " " + number(height) + "\" role=\"img\" aria-label=\"" +
         escaped(title) + "\">";
}

}  // namespace

std::string table(std::string_view caption, const std::vector<Column>& columns, const Rows& rows) {
  std::string out = "<div class=\"wide\"><table>\n<caption>" + escaped(caption) + "</caption>\n<thead><tr>";
  for (const Column& column : columns)
    out += std::string("<th scope=\"col\"") + (column.number ? " class=\"number\">" : ">") +
           escaped(column.title) + "</th>";
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    if (row.size() == 1) {
      out += "<tr><th scope=\"rowgroup\" colspan=\"" + std::to_string(columns.size()) +
             "\" class=\"group\">" + escaped(row[0]) + "</th></tr>\n";
      continue;
    }
    out += "<tr><th scope=\"row\">" + escaped(row[0]) + "</th>";
    for (std::size_t i = 1; i < row.size(); ++i)
      out += std::string("<td") + (i < columns.size() && columns[i].number ? " class=\"number\">" : ">") +
             escaped(row[i]) + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody>\n</table></div>\n";
}

std::string facts(std::string_view caption, const std::vector<std::pair<std::string, std::string>>& rows) {
  std::string out =
      "<div class=\"wide\"><table class=\"facts\">\n<caption>" + escaped(caption) + "</caption>\n<tbody>\n";
  for (const auto& [name, value] : rows)
    out += "<tr><th scope=\"row\">" + escaped(name) + "</th><td>" + escaped(value) + "</td></tr>\n";
  return out + "</tbody>\n</table></div>\n";
}

std::string histogram(const Histogram& h) {
  constexpr double width = 340, height = 190, left = 38, right = 318, top = 12, bottom = 146;
  const std::size_t count = h.with.size();
  double most = 0.01;
  for (const auto* shares : {&h.with, &h.without})
    for (const double share : *shares) most = std::max(most, share);
  const double share_step = tick_step(0, 100 * most);
  const double highest = share_step * std::ceil(100 * most / share_step);
  const double bin = (right - left) / static_cast<double>(std::max<std::size_t>(1, count));
  const auto row = [&](double share) { return bottom - (bottom - top) * 100 * share / highest; };
  std::string out = open_svg(width, height, h.title);
  for (double p = 0; p <= highest * 1.001; p += share_step) {
    out += line(left, row(p / 100), right, row(p / 100), "grid");
    out += words(left - 5, row(p / 100) + 4, "end", decimal(p, places_of(share_step)));
  }
  for (std::size_t i = 0; i < count; ++i)
    out += rectangle(left + bin * static_cast<double>(i) + 0.5, row(h.with[i]), bin - 1,
                     bottom - row(h.with[i]), "with");
  if (!h.without.empty()) {
    out += "<path class=\"without\" d=\"M" + number(left) + " " + number(bottom);
    for (std::size_t i = 0; i < h.without.size(); ++i)
      out += " V" + number(row(h.without[i])) + " H" + number(left + bin * static_cast<double>(i + 1));
    out += " V" + number(bottom) + "\"/>";
  }
  const double high = h.low + h.step * static_cast<double>(count), step = tick_step(h.low, high);
  for (double v = h.low; v <= high + 1e-9; v += step) {
    const double x = left + (right - left) * (v - h.low) / (high - h.low);
    const bool last = h.open_above && v + step > high + 1e-9;
    out += line(x, bottom, x, bottom + 4, "axis");
    out += words(x, bottom + 17, "middle",
                 (last && std::abs(v - high) < 1e-9 ? "≥ " : "") + decimal(v, places_of(step)));
  }
  out += line(left, bottom, right, bottom, "axis");
  out += words((left + right) / 2, bottom + 36, "middle", h.quantity);
  return "<figure class=\"chart\">" + out + "</svg><figcaption>" + escaped(h.title) +
         ", per cent of the inked area.</figcaption></figure>\n";
}

std::string bars(const Bars& b) {
  constexpr double width = 480, left = 92, right = 470, top = 22, row_height = 20;
  double most = 0.1;
  for (const auto& row : b.rows)
    for (const auto& value : {row.with, row.without})
      if (value) most = std::max(most, std::abs(*value));
  const double step = tick_step(0, b.signed_values ? 2 * most : most), high = step * std::ceil(most / step);
  const double low = b.signed_values ? -high : 0;
  const auto column = [&](double value) { return left + (right - left) * (value - low) / (high - low); };
  const double bottom = top + row_height * static_cast<double>(b.rows.size());
  std::string out = open_svg(width, bottom + 24, b.title);
  for (double v = low; v <= high * 1.001; v += step) {
    out += line(column(v), top, column(v), bottom, std::abs(v) < step / 2 ? "axis" : "grid");
    out += words(column(v), top - 7, "middle", decimal(v, places_of(step)));
  }
  out += words((left + right) / 2, bottom + 17, "middle", b.quantity);
  for (std::size_t i = 0; i < b.rows.size(); ++i) {
    const double y = top + row_height * static_cast<double>(i);
    out += words(left - 6, y + 14, "end", b.rows[i].name.substr(0, 12));
    const auto bar = [&](const std::optional<double>& value, double from, const char* kind) {
      if (!value) return;
      const double a = column(std::min(0.0, *value)), z = column(std::max(0.0, *value));
      out += rectangle(a, from, std::max(0.6, z - a), 7, kind);
    };
    bar(b.rows[i].with, y + 2, "with");
    bar(b.rows[i].without, y + 10, "without");
  }
  return "<figure class=\"chart\">" + out + "</svg><figcaption>" + escaped(b.title) +
         "</figcaption></figure>\n";
}

std::string matrix(const Matrix& m) {
  constexpr double left = 70, top = 8, most_wide = 400;
  const double cell =
      std::min(22.0, most_wide / static_cast<double>(std::max<std::size_t>(1, m.names.size())));
  const double side = cell * static_cast<double>(m.names.size());
  std::string out = open_svg(left + side + 8, top + side + 8, m.title);
  for (std::size_t a = 0; a < m.names.size(); ++a) {
    const double y = top + cell * static_cast<double>(a);
    out += words(left - 6, y + 0.5 * cell + 4, "end", m.names[a].substr(0, 12));
    for (std::size_t b = 0; b < m.names.size(); ++b) {
      const double x = left + cell * static_cast<double>(b);
      const std::optional<double>& value = m.values[a][b];
      const double strength = value ? std::min(1.0, std::abs(*value) / m.full) : 0;
      out += "<g><title>" + escaped(m.names[a]) + ", " + escaped(m.names[b]) +
             (value ? ": " + decimal(*value, 4) : std::string()) + "</title><rect x=\"" + number(x) +
             "\" y=\"" + number(y) + "\" width=\"" + number(cell) + "\" height=\"" + number(cell) +
             "\" class=\"" + (value ? *value < 0 ? "below" : "above" : "none") + "\" fill-opacity=\"" +
             decimal(strength, 2) + "\"/></g>";
    }
  }
  return "<figure class=\"chart\">" + out + "</svg><figcaption>" + escaped(m.title) +
         "</figcaption></figure>\n";
}

std::string legend() {
  return "<p class=\"legend\"><svg viewBox=\"0 0 22 12\" aria-hidden=\"true\">" +
         rectangle(1, 1, 20, 10, "with") +
         "</svg> printed with Vacuform <svg viewBox=\"0 0 22 12\" aria-hidden=\"true\">" +
         rectangle(1, 1, 20, 10, "without") + "</svg> printed as drawn</p>\n";
}

std::string_view style() {
  return R"css(
:root { color-scheme: light dark; --text: #1b1d21; --soft: #4b5059; --paper: #fff; --band: #f3f4f6; --rule: #c9cdd3;
  --with: #0072b2; --without: #b34b00; --warn: #8a4500; --serious: #a3201f; }
@media (prefers-color-scheme: dark) { :root { --text: #e8eaed; --soft: #b6bcc6; --paper: #16181c; --band: #22262c;
  --rule: #474d57; --with: #56b4e9; --without: #f0a35e; --warn: #f3b26b; --serious: #ff8b85; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 68rem; padding: 1.2rem; color: var(--text); background: var(--paper);
  font: 1rem/1.45 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; padding-top: .5rem; border-top: 1px solid var(--rule); }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
p, ul { margin: .4rem 0; max-width: 52rem; }
.soft, figcaption, caption { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .6rem 0; font-size: .92rem; }
caption { text-align: left; padding: .2rem 0; font-size: .92rem; }
th, td { text-align: left; padding: .18rem .7rem .18rem 0; border-bottom: 1px solid var(--rule); vertical-align: top; }
tbody th { font-weight: 500; min-width: 4.6rem; }
th.group { background: var(--band); font-weight: 600; padding-left: .4rem; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th.number { white-space: normal; min-width: 4.2rem; }
.facts td { overflow-wrap: anywhere; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); gap: 1rem; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(19rem, 1fr)); gap: 1rem; align-items: start; }
figure { margin: 0; }
figure img { width: 100%; height: auto; display: block; border: 1px solid var(--rule); background: #fff; }
figcaption { font-size: .9rem; padding-top: .25rem; }
.chart svg { width: 100%; height: auto; max-width: 34rem; font-size: 12px; fill: var(--text); }
.legend svg { width: 22px; height: 12px; margin-left: .8rem; }
svg .with { fill: var(--with); } svg .without { fill: none; stroke: var(--without); stroke-width: 1.6; }
svg .below { fill: var(--with); stroke: var(--rule); } svg .above { fill: var(--without); stroke: var(--rule); }
svg .none { fill: none; stroke: var(--rule); }
svg .grid { stroke: var(--rule); stroke-width: .6; } svg .axis { stroke: var(--text); stroke-width: 1; }
.warnings > li { margin-bottom: .6rem; } .warnings b:first-child { color: var(--warn); text-transform: capitalize; }
.warnings .serious b:first-child { color: var(--serious); } .warnings .note b:first-child { color: var(--soft); }
@page { size: A4; margin: 14mm; }
@media print {
  :root { color-scheme: light; --text: #000; --soft: #333; --paper: #fff; --band: #eee; --rule: #999; --with: #0072b2;
    --without: #b34b00; --warn: #7a3c00; --serious: #8a1010; }
  body { max-width: none; padding: 0; font-size: 9.5pt; } figcaption, caption { font-size: 8.5pt; }
  .pictures { grid-template-columns: 1fr 1fr; gap: 4mm; } .charts { grid-template-columns: 1fr 1fr; gap: 4mm; }
  th.number { min-width: 0; } table { font-size: 8.2pt; } th, td { padding-right: 2mm; }
  figure, tr, li { break-inside: avoid; } h2, h3, caption { break-after: avoid; } thead { display: table-header-group; }
  .wide { overflow: visible; }
}
)css";
}

}  // namespace vacuform::html
