#pragma once
/// Names of the configuration <-> the indices that estimators count with.

#include <cassert>
#include <cstddef>
#include <downrange/geo/name.hpp>
#include <vector>

namespace downrange {

/// Position of the entry named `id`. The caller has checked that it exists (ingest rejects unknown names).
template <class Config>
[[nodiscard]] int index_of(const std::vector<Config>& entries, const Name& id) {
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

/// Upper triangle, row by row, of the leading n x n block of `m`.
template <class Matrix, std::size_t Size>
void pack_upper_triangle(const Matrix& m, int n, std::array<double, Size>& out) {
  std::size_t k = 0;
  for (int row = 0; row < n; ++row) {
    for (int column = row; column < n; ++column) out[k++] = m(row, column);
  }
}

}  // namespace downrange
