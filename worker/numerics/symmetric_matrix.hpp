// A sparse symmetric matrix as factorizations take it.
#pragma once

#include <vector>

namespace vacuform {

// The lower triangle of a symmetric matrix, compressed by columns; rows ascend within a column, and every column
// begins with its diagonal.
struct SymmetricMatrix {
  int size = 0;
  std::vector<int> column_start;  // size + 1
  std::vector<int> row;
  std::vector<double> value;
};

}  // namespace vacuform
