// A maximum cut of the graph of crossings, by local search from a colouring in order of distance, which is exact where
// two colours suffice.
#include "worker/conductors/faces.hpp"

#include <algorithm>
#include <map>
#include <queue>

#include "worker/stage/index.hpp"

namespace vacuform {

namespace {

class Graph {
 public:
  Graph(int count, const std::vector<Crossing>& crossings) : edges_(index(count)), faces_(index(count), -1) {
    for (const Crossing& c : crossings)
      if (c.a != c.b) ++edges_[index(c.a)][c.b], ++edges_[index(c.b)][c.a];
  }

  void colour() {
    for (int start = 0; start < static_cast<int>(faces_.size()); ++start) {
      if (faces_[index(start)] >= 0) continue;
      faces_[index(start)] = 0;
      std::queue<int> next({start});
      for (; !next.empty(); next.pop()) {
        const int at = next.front();
        for (const auto& [to, weight] : edges_[index(at)])
          if (faces_[index(to)] < 0) {
            faces_[index(to)] = 1 - faces_[index(at)];
            next.push(to);
          }
      }
    }
  }

  void improve() {
    constexpr int most_rounds = 50;
    bool better = true;
    for (int round = 0; better && round < most_rounds; ++round) {
      better = false;
      for (int i = 0; i < static_cast<int>(faces_.size()); ++i) {
        if (gain(i) > 0) {
          flip(i);
          better = true;
        }
        for (const auto& [k, weight] : edges_[index(i)])
          if (k > i && faces_[index(k)] != faces_[index(i)] && gain(i) + gain(k) + 2 * weight > 0) {
            flip(i), flip(k);
            better = true;
          }
      }
    }
  }

  // With the first loop of each group on face 0.
  std::vector<int> faces() {
    std::vector<char> seen(faces_.size(), 0);
    for (int start = 0; start < static_cast<int>(faces_.size()); ++start) {
      if (seen[index(start)]) continue;
      const int wrong = faces_[index(start)];
      seen[index(start)] = 1;
      std::queue<int> next({start});
      for (; !next.empty(); next.pop()) {
        const int at = next.front();
        faces_[index(at)] ^= wrong;
        for (const auto& [to, weight] : edges_[index(at)])
          if (!seen[index(to)]) seen[index(to)] = 1, next.push(to);
      }
    }
    return faces_;
  }

 private:
  // By how many crossings on one face become fewer if the loop changes its face.
  int gain(int i) const {
    int out = 0;
    for (const auto& [to, weight] : edges_[index(i)])
      out += faces_[index(to)] == faces_[index(i)] ? weight : -weight;
    return out;
  }
  void flip(int i) { faces_[index(i)] ^= 1; }

  std::vector<std::map<int, int>> edges_;  // crossings with each other loop
  std::vector<int> faces_;
};

}  // namespace

std::vector<int> choose_faces(int count, const std::vector<Crossing>& crossings) {
  Graph graph(count, crossings);
  graph.colour();
  graph.improve();
  return graph.faces();
}

std::vector<Crossing> crossings_on(int face, const std::vector<int>& faces,
                                   const std::vector<Crossing>& crossings) {
  std::vector<Crossing> out;
  for (const Crossing& c : crossings)
    if (faces[index(c.a)] == face && faces[index(c.b)] == face) out.push_back(c);
  return out;
}

}  // namespace vacuform
