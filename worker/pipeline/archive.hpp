// Values to bytes and back, for files that only the program that wrote them reads: machine's own byte order, no versions.
//
// A structure takes part by a function  template <class A> void fields(A& archive, T& value)  that hands each of its
// fields to the archive; it is found by argument-dependent lookup.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace vacuform {

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class ArchiveWriter {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  std::vector<std::uint8_t> bytes;

 private:
  void raw(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), from, from + size);
  }
  template <Plain T>
  void put(T value) {
    raw(&value, sizeof value);
  }
  template <int N>
  void put(const Eigen::Matrix<double, N, 1>& v) {
    raw(v.data(), sizeof(double) * N);
  }
  template <Plain T, std::size_t N>
  void put(const std::array<T, N>& values) {
    raw(values.data(), sizeof values);
  }
  void put(const std::string& text) {
    put(std::uint64_t{text.size()});
    raw(text.data(), text.size());
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    for (const T& value : values) put(value);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(std::uint8_t{value.has_value()});
    if (value) put(*value);
  }
  template <class T>
  requires std::is_class_v<T>
  void put(const T& value) {
    fields(*this, const_cast<T&>(value));  // a writer only reads
  }
};

// Reads what the writer wrote. Where the bytes do not hold what is asked of them, ok() is false from there on and
// values stay as they are.
class ArchiveReader {
 public:
  explicit ArchiveReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && rest_.empty(); }

 private:
  void raw(void* data, std::size_t size) {
    ok_ = ok_ && size <= rest_.size();
    if (!ok_) return;
    std::memcpy(data, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  template <Plain T>
  void get(T& value) {
    raw(&value, sizeof value);
  }
  template <int N>
  void get(Eigen::Matrix<double, N, 1>& v) {
    raw(v.data(), sizeof(double) * N);
  }
  template <Plain T, std::size_t N>
  void get(std::array<T, N>& values) {
    raw(values.data(), sizeof values);
  }
  // Of a list; each entry takes at least a byte, so that memory is never asked for what is not there.
  std::size_t count() {
    std::uint64_t n = 0;
    get(n);
    ok_ = ok_ && n <= rest_.size();
    return ok_ ? n : 0;
  }
  void get(std::string& text) {
    text.resize(count());
    raw(text.data(), text.size());
  }
  template <class T>
  void get(std::vector<T>& values) {
    const std::size_t n = count();
    values.clear();
    for (std::size_t i = 0; i < n && ok_; ++i) get(values.emplace_back());
  }
  template <class T>
  void get(std::optional<T>& value) {
    std::uint8_t is_there = 0;
    get(is_there);
    value.reset();
    if (ok_ && is_there != 0) get(value.emplace(T{}));
  }
  template <class T>
  requires std::is_class_v<T>
  void get(T& value) { fields(*this, value); }

  std::span<const std::uint8_t> rest_;
  bool ok_ = true;
};

}  // namespace vacuform
