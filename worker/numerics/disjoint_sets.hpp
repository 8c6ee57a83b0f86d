// Disjoint sets of 0 ... n - 1. The smallest member names its set.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace vacuform {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[i] != i) {
      int& up = parent_[i];
      up = parent_[up];
      i = up;
    }
    return i;
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace vacuform
