// The colours that a scan file gives its triangles, as they are in the file: images stay encoded and are not checked.
// The colour of a point is the product of its material's factor, its texture and its vertex colour, each in linear
// light (IEC 61966-2-1 defines the curve). Opacity, gloss and light are ignored.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vacuform {

struct ScanImage {
  std::string name;  // for messages: its place in the file, or its file name
  std::vector<std::uint8_t> bytes;
};

// What an image shows beyond its borders.
enum class Wrap : std::uint8_t { repeat, mirror, clamp };

struct ScanMaterial {
  Eigen::Vector3f factor{1, 1, 1};  // red, green, blue in linear light, each in [0, 1]
  int image = -1;                   // of ScanColours::images; -1: none
  Wrap across = Wrap::repeat, down = Wrap::repeat;
};

struct ScanColours {
  std::vector<ScanImage> images;        // only those that a triangle shows
  std::vector<ScanMaterial> materials;  // at least one
  std::vector<int> material;            // of each triangle of the file
  // Texture coordinates of the corners of each triangle, from the left and from the top of the image, whose sides are
  // 1. Finite, at most 1e6 in size. Empty if no triangle has an image.
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  // Colour of each vertex of the file: red, green, blue in linear light, each in [0, 1]. Empty if no vertex has a
  // colour.
  std::vector<Eigen::Vector3f> vertex;
};

// Linear light from the encoded value of sRGB, both in [0, 1].
float linear_from_srgb(float encoded);
// The inverse.
float srgb_from_linear(float linear);
// The inverse in whole numbers: the nearest to 255 * srgb_from_linear(linear), for the inner loops.
std::uint8_t srgb_byte(float linear);

}  // namespace vacuform
