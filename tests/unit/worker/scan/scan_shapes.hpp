// Shapes with known volumes and undercuts, and the same shapes as files of every format.
#pragma once

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "worker/scan/mold.hpp"
#include "worker/scan/topology.hpp"
#include "worker/surface/stl.hpp"

namespace vacuform::shapes {

using FileBytes = std::vector<std::uint8_t>;

// A solid of revolution about z: the profile runs from the axis at the bottom to the axis at the top, as
// (radius, z); its first and last radius are 0. `n` columns around.
inline TriangleMesh lathe(const std::vector<Eigen::Vector2d>& profile, int n) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, profile.front().y());
  for (std::size_t k = 1; k + 1 < profile.size(); ++k)
    for (int i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      mesh.vertices.emplace_back(profile[k].x() * std::cos(a), profile[k].x() * std::sin(a), profile[k].y());
    }
  mesh.vertices.emplace_back(0, 0, profile.back().y());
  const int rings = static_cast<int>(profile.size()) - 2, top = 1 + rings * n;
  const auto at = [&](int ring, int i) { return 1 + ring * n + i % n; };
  for (int i = 0; i < n; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (int k = 0; k + 1 < rings; ++k) {
      mesh.triangles.push_back({at(k, i), at(k, i + 1), at(k + 1, i + 1)});
      mesh.triangles.push_back({at(k, i), at(k + 1, i + 1), at(k + 1, i)});
    }
    mesh.triangles.push_back({at(rings - 1, i), at(rings - 1, i + 1), top});
  }
  return mesh;
}

inline TriangleMesh sphere(double radius, int rings = 48) {
  std::vector<Eigen::Vector2d> profile;
  for (int k = 0; k <= rings; ++k) {
    const double a = std::numbers::pi * k / rings;
    profile.emplace_back(k == 0 || k == rings ? 0 : radius * std::sin(a), -radius * std::cos(a));
  }
  return lathe(profile, 2 * rings);
}

// A stem of radius 15 under a cap of radius 40 whose flat underside lies at z = 40: the undercut is 25 mm
// deep and pi (40^2 - 15^2) = 4320 mm2 large.
inline TriangleMesh mushroom(double cap_height) {
  return lathe({{0, 0},
                {15, 0},
                {15, 40},
                {40, 40},
                {40, 40 + cap_height / 2},
                {20, 40 + cap_height},
                {0, 40 + cap_height}},
               180);
}

inline TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back((i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}
inline TriangleMesh cube(double side) {
  return box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(side));
}

inline TriangleMesh moved(TriangleMesh mesh, const Eigen::Affine3d& by) {
  for (auto& p : mesh.vertices) p = by * p;
  return mesh;
}
inline TriangleMesh shifted(TriangleMesh mesh, double x, double y, double z) {
  return moved(std::move(mesh), Eigen::Affine3d(Eigen::Translation3d(x, y, z)));
}
inline TriangleMesh scaled(TriangleMesh mesh, double by) {
  return moved(std::move(mesh), Eigen::Affine3d(Eigen::Scaling(by)));
}

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int base = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return a;
}
inline TriangleMesh turned_over(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}
// Without the triangles for which `gone` holds of all three corners: a jagged border, as a scanner's box
// leaves.
inline TriangleMesh without(TriangleMesh mesh, const std::function<bool(const Eigen::Vector3d&)>& gone) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    for (const int v : t)
      if (!gone(mesh.vertices[static_cast<std::size_t>(v)])) return false;
    return true;
  });
  return mesh;
}

// The mesh with its +z turned to `up`.
inline TriangleMesh fallen(const TriangleMesh& mesh, const Eigen::Vector3d& up) {
  return moved(mesh, Eigen::Affine3d(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up)));
}

inline FileBytes text_bytes(const std::string& text) { return {text.begin(), text.end()}; }
inline std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}
inline void put(FileBytes& bytes, std::uint64_t value, int size, bool big = false) {
  for (int i = 0; i < size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(value >> 8 * (big ? size - 1 - i : i)));
}
inline void put_float(FileBytes& bytes, double x, bool big = false) {
  put(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(x)), 4, big);
}

inline FileBytes stl(const TriangleMesh& mesh) { return stl_bytes(mesh); }

inline FileBytes stl_ascii(const TriangleMesh& mesh) {
  std::string text = "solid cube\n";
  for (const auto& t : mesh.triangles) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const int v : t) {
      const auto& p = mesh.vertices[static_cast<std::size_t>(v)];
      text += "  vertex " + number(p.x()) + " " + number(p.y()) + " " + number(p.z()) + "\n";
    }
    text += " endloop\nendfacet\n";
  }
  return text_bytes(text + "endsolid cube\n");
}

inline FileBytes obj(const TriangleMesh& mesh) {
  std::string text;
  for (const auto& p : mesh.vertices)
    text += std::string("v ") + number(p.x()) + " " + number(p.y()) + " " + number(p.z()) + "\n";
  for (const auto& t : mesh.triangles)
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  return text_bytes(text);
}

inline FileBytes off(const TriangleMesh& mesh) {
  std::string text = "OFF\n# a comment\n" + std::to_string(mesh.vertices.size()) + " " +
                     std::to_string(mesh.triangles.size()) + " 0\n";
  for (const auto& p : mesh.vertices)
    text += number(p.x()) + " " + number(p.y()) + " " + number(p.z()) + "\n";
  for (const auto& t : mesh.triangles)
    text +=
        "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + " 255 0 0\n";
  return text_bytes(text);
}

inline FileBytes ply_ascii(const TriangleMesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\ncomment made by a test\nelement vertex " +
                     std::to_string(mesh.vertices.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& p : mesh.vertices)
    text += number(p.x()) + " " + number(p.y()) + " " + number(p.z()) + "\n";
  for (const auto& t : mesh.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  return text_bytes(text);
}

// With properties that nobody asked for around those that matter, and a list of another type.
inline FileBytes ply_binary(const TriangleMesh& mesh, bool big) {
  FileBytes bytes =
      text_bytes(std::string("ply\nformat binary_") + (big ? "big" : "little") +
                 "_endian 1.0\nelement camera 2\nproperty double f\nelement vertex " +
                 std::to_string(mesh.vertices.size()) +
                 "\nproperty uchar red\nproperty float32 z\nproperty list uchar short odd\nproperty double "
                 "x\nproperty float y\nelement face " +
                 std::to_string(mesh.triangles.size()) +
                 "\nproperty short flags\nproperty list uint ushort vertex_index\nend_header\n");
  for (int i = 0; i < 2; ++i) put(bytes, 0x0A0D0A0D0A0D0A0D, 8, big);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& p = mesh.vertices[i];
    put(bytes, 7, 1, big);
    put_float(bytes, p.z(), big);
    put(bytes, i % 3, 1, big);
    for (std::size_t k = 0; k < i % 3; ++k) put(bytes, 99, 2, big);
    put(bytes, std::bit_cast<std::uint64_t>(p.x()), 8, big);
    put_float(bytes, p.y(), big);
  }
  for (const auto& t : mesh.triangles) {
    put(bytes, 1, 2, big);
    put(bytes, 3, 4, big);
    for (const int v : t) put(bytes, static_cast<std::uint64_t>(v), 2, big);
  }
  return bytes;
}

// A GLB of a JSON chunk and a binary chunk, both padded as they must be.
inline FileBytes glb(std::string json, FileBytes binary) {
  while (json.size() % 4) json += ' ';
  while (binary.size() % 4) binary.push_back(0);
  FileBytes bytes = text_bytes("glTF");
  put(bytes, 2, 4);
  put(bytes, 12 + 8 + json.size() + 8 + binary.size(), 4);
  put(bytes, json.size(), 4);
  put(bytes, 0x4E4F534A, 4);
  bytes.insert(bytes.end(), json.begin(), json.end());
  put(bytes, binary.size(), 4);
  put(bytes, 0x004E4942, 4);
  bytes.insert(bytes.end(), binary.begin(), binary.end());
  return bytes;
}
// An indexed mesh under a node of the given members (such as "\"scale\":[2,2,2],").
inline FileBytes glb(const TriangleMesh& mesh, const std::string& node = "", const std::string& root = "") {
  FileBytes binary;
  for (const auto& p : mesh.vertices)
    for (int k = 0; k < 3; ++k) put_float(binary, p[k]);
  const auto index_start = binary.size();
  for (const auto& t : mesh.triangles)
    for (const int v : t) put(binary, static_cast<std::uint64_t>(v), 2);
  const auto n = std::to_string(mesh.vertices.size()), m = std::to_string(3 * mesh.triangles.size());
  return glb(
      "{\"asset\":{\"version\":\"2.0\"}," + root + "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{" +
          node +
          "\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
          "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":" +
          n +
          ",\"type\":\"VEC3\"},"
          "{\"bufferView\":1,\"componentType\":5123,\"count\":" +
          m +
          ",\"type\":\"SCALAR\"}],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":" +
          std::to_string(index_start) + "},{\"buffer\":0,\"byteOffset\":" + std::to_string(index_start) +
          ",\"byteLength\":" + std::to_string(binary.size() - index_start) +
          "}],\"buffers\":[{\"byteLength\":" + std::to_string(binary.size()) + "}]}",
      binary);
}

}  // namespace vacuform::shapes
