#include "worker/printing/print_pdf.hpp"

#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "worker/printing/pdf_writer.hpp"

namespace vacuform {

namespace {

using Eigen::Vector2d;

std::string pdf_point(const Vector2d& p) { return pdf_number(p.x()) + " " + pdf_number(p.y()) + " "; }

std::string pdf_path(const Curve& curve) {
  const auto& p = curve.points;
  std::string out = pdf_point(p[0]) + "m\n";
  for (std::size_t i = 1; i + 2 < p.size(); i += 3)
    out += pdf_point(p[i]) + pdf_point(p[i + 1]) + pdf_point(p[i + 2]) + "c\n";
  return curve.closed ? out + "h\n" : out;
}

Curve circle(const Vector2d& centre, double radius) {
  const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
  Curve out{.points = {centre + Vector2d(radius, 0)}, .closed = true};
  Vector2d from(1, 0);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Vector2d to(-from.y(), from.x());
    for (const Vector2d& p : {Vector2d(from + k * to), Vector2d(to + k * from), to})
      out.points.push_back(centre + radius * p);
    from = to;
  }
  return out;
}

// From UTF-8 to the characters of WinAnsiEncoding, as a string of PDF.
std::string pdf_text(std::string_view utf8) {
  std::string out = "(";
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    auto c = static_cast<unsigned char>(utf8[i]);
    if ((c == 0xc2 || c == 0xc3) && i + 1 < utf8.size())
      c = static_cast<unsigned char>((c == 0xc3 ? 0x40 : 0) + static_cast<unsigned char>(utf8[++i]));
    else if (c >= 0x80)
      c = '?';
    if (c == '(' || c == ')' || c == '\\') out += '\\';
    out += static_cast<char>(c);
  }
  return out + ")";
}

// Width in em in Helvetica, of the characters that centred marks use.
double text_width(std::string_view text) {
  double width = 0;
  for (const char c : text) width += c == '+' ? 0.584 : c == 't' || c == ' ' ? 0.278 : 0.556;
  return width;
}

std::string content_of(const Mark& mark) {
  std::string out;
  const auto dashed = [&](bool yes) { out += yes ? "[1.5] 0 d\n" : "[] 0 d\n"; };
  for (const Line& line : mark.lines) {
    dashed(line.dashed);
    for (std::size_t i = 0; i < line.points.size(); ++i)
      out += pdf_point(line.points[i]) + (i == 0 ? "m\n" : "l\n");
    if (line.closed) out += "h\n";
    out += line.filled ? "f\n" : "S\n";
  }
  for (const MarkCircle& c : mark.circles) {
    dashed(c.dashed);
    out += pdf_path(circle(c.centre, c.radius)) + "S\n";
  }
  for (const Text& text : mark.texts) {
    const double back = text.centred ? text_width(text.text) * text.size / 2 : 0;
    const Vector2d start = text.at - back * (text.upwards ? Vector2d(0, 1) : Vector2d(1, 0));
    out += std::string("BT /F1 ") + pdf_number(text.size) + " Tf " +
           (text.upwards ? "0 1 -1 0 " : "1 0 0 1 ") + pdf_point(start) + "Tm " + pdf_text(text.text) +
           " Tj ET\n";
  }
  return out;
}

// The vectors, and the opacities that they use: each by its name among the resources.
std::string content_of(const VectorPrint& vectors, std::map<std::string, std::string>& opacities) {
  std::string out;
  for (const PrintedElement& element : vectors.elements)
    for (const PaintedArea& area : element.areas) {
      const Colour& c = area.colour;
      const std::string opacity = pdf_number(c.a);
      std::string name("A");
      name += std::to_string(opacities.size());
      const auto named = opacities.try_emplace(opacity, std::move(name)).first;
      out += std::string("/") + named->second + " gs\n";
      if (c.r == c.g && c.g == c.b)
        out += pdf_number(c.r) + " g\n";
      else
        out += pdf_number(c.r) + " " + pdf_number(c.g) + " " + pdf_number(c.b) + " rg\n";
      for (const Curve& outline : area.outlines) out += pdf_path(outline);
      out += area.even_odd ? "f*\n" : "f\n";
    }
  return out;
}

std::uint32_t number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 24 | static_cast<std::uint32_t>(bytes[at + 1]) << 16 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 8 | bytes[at + 3];
}

// PDF takes the rows of a PNG in compressed form: the content of its IDAT chunks.
int embed(PdfWriter& pdf, std::span<const std::uint8_t> png, const std::string& rgb,
          const std::string& more) {
  const std::uint32_t width = number_at(png, 16), height = number_at(png, 20);
  const int channels = png[25] == 0 ? 1 : 3;
  std::vector<std::uint8_t> rows;
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = number_at(png, at);
    if (std::string_view(reinterpret_cast<const char*>(png.data()) + at + 4, 4) == "IDAT")
      rows.insert(rows.end(), png.begin() + static_cast<std::ptrdiff_t>(at) + 8,
                  png.begin() + static_cast<std::ptrdiff_t>(at + 8 + length));
    at += length + 12;
  }
  return pdf.stream(std::string("/Type /XObject /Subtype /Image /Width ") + std::to_string(width) +
                        " /Height " + std::to_string(height) + " /BitsPerComponent 8 /ColorSpace " +
                        (channels == 1 ? std::string("/DeviceGray") : rgb) + more +
                        " /Filter /FlateDecode /DecodeParms << /Predictor 15 /Colors " +
                        std::to_string(channels) + " /BitsPerComponent 8 /Columns " + std::to_string(width) +
                        " >>",
                    rows);
}

std::string reference(int object) { return std::to_string(object) + " 0 R"; }

// The colour space of a profile of RGB.
std::string icc_based(PdfWriter& pdf, std::span<const std::uint8_t> icc) {
  const int stream = pdf.deflated_stream("/N 3 /Alternate /DeviceRGB", {icc.begin(), icc.end()});
  return std::string("[/ICCBased ") + reference(stream) + "]";
}

// Writes pages one after another, with what they share once.
class Pages {
 public:
  explicit Pages(const OutputProfile& profile)
      : profile_(profile),
        pattern_(pdf_.object("<< /Type /OCG /Name (pattern) >>")),
        marks_(pdf_.object("<< /Type /OCG /Name (marks) >>")),
        font_(
            pdf_.object("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>")),
        parent_(pdf_.reserve()) {}

  void add(const PdfPage& each) {
    const auto& [name, page, shown] = each;
    const double points = 72 / 25.4;
    const Vector2d size = points * page.size_mm;
    // Millimetres from the sheet's centre, y up.
    std::string content = pdf_number(points, 9) + " 0 0 " + pdf_number(points, 9) + " " +
                          pdf_number(size.x() / 2, 6) + " " + pdf_number(size.y() / 2, 6) + " cm\n";
    std::map<std::string, std::string> opacities;
    std::string resources = std::string(" /Font << /F1 ") + reference(font_) +
                            " >> /Properties << /Pattern " + reference(pattern_) + " /Marks " +
                            reference(marks_) + " >>";
    content += "/OC /Pattern BDC\nq\n";
    if (page.mirrored) content += "-1 0 0 1 0 0 cm\n";
    if (shown.vectors) content += content_of(*shown.vectors, opacities);
    if (shown.picture) {
      resources += picture(shown);
      const PlacedPicture& at = *shown.picture;
      content += pdf_number(at.width_mm, 6) + " 0 0 " + pdf_number(at.height_mm, 6) + " " +
                 pdf_number(at.left_mm, 6) + " " + pdf_number(-at.top_mm - at.height_mm, 6) +
                 " cm\n/Picture Do\n";
    }
    content += "Q\nEMC\n/OC /Marks BDC\nq\n0 g 0 G 0.15 w\n";
    for (const Mark& mark : page.marks.marks) content += content_of(mark);
    content += "Q\nEMC\n";
    if (!opacities.empty()) {
      resources += " /ExtGState <<";
      for (const auto& [opacity, state] : opacities)
        resources += std::string(" /") + state + " << /Type /ExtGState /ca " + opacity + " >>";
      resources += " >>";
    }
    // Whatever is RGB without a profile of its own is sRGB (ISO 32000-1, 8.6.5.6).
    if (content.find(" rg\n") != std::string::npos || !shown.opacity.empty())
      resources += std::string(" /ColorSpace << /DefaultRGB ") + srgb() + " >>";
    const int stream = pdf_.deflated_stream("", content);
    const int number =
        pdf_.object(std::string("<< /Type /Page /Parent ") + reference(parent_) + " /MediaBox [0 0 " +
                    pdf_number(size.x(), 6) + " " + pdf_number(size.y(), 6) + "] /Contents " +
                    reference(stream) + " /Resources <<" + resources + " >> >>");
    labels_ += std::to_string(count_++) + " << /P " + pdf_text(name) + " >> ";
    kids_ += reference(number) + " ";
  }

  std::vector<std::uint8_t> finish() {
    pdf_.object(parent_, std::string("<< /Type /Pages /Count ") + std::to_string(count_) + " /Kids [" +
                             kids_ + "] >>");
    const std::string layers = std::string("[") + reference(pattern_) + " " + reference(marks_) + "]";
    const std::string named =
        count_ > 1 ? std::string(" /PageLabels << /Nums [") + labels_ + "] >>" : std::string();
    // Printed at its own size: otherwise viewers would fit the page to the paper.
    return pdf_.finish(pdf_.object(std::string("<< /Type /Catalog /Pages ") + reference(parent_) + named +
                                   " /ViewerPreferences << /PrintScaling /None >> /OCProperties << /OCGs " +
                                   layers + " /D << /Order " + layers + " /ON " + layers + " >> >> >>"));
  }

 private:
  std::string picture(const PageContent& shown) {
    const std::span<const std::uint8_t> alpha = shown.opacity;
    if (icc_.empty() && !profile_.icc().empty() && !alpha.empty()) icc_ = icc_based(pdf_, profile_.icc());
    const std::string rgb = alpha.empty() || icc_.empty() ? std::string("/DeviceRGB") : icc_;
    const int mask = alpha.empty() ? 0 : embed(pdf_, alpha, rgb, "");
    const int image = embed(pdf_, shown.picture->png, rgb,
                            mask ? std::string(" /SMask ") + reference(mask) : std::string());
    return std::string(" /XObject << /Picture ") + reference(image) + " >>";
  }
  const std::string& srgb() {
    if (srgb_.empty()) srgb_ = icc_based(pdf_, srgb_icc());
    return srgb_;
  }

  const OutputProfile& profile_;
  PdfWriter pdf_;
  const int pattern_, marks_, font_, parent_;  // objects
  std::string icc_, srgb_;                     // colour spaces, once they are needed
  std::string labels_, kids_;
  int count_ = 0;
};

}  // namespace

std::vector<std::uint8_t> make_pdf(const std::vector<const PdfPage*>& pages, const OutputProfile& profile) {
  Pages written(profile);
  for (const PdfPage* page : pages) written.add(*page);
  return written.finish();
}

}  // namespace vacuform
