#pragma once
/// Global assignment of rows to columns at least cost, where a row may stay without partner.

#include <span>
#include <vector>

namespace downrange {

/// Shortest augmenting paths with dual prices (Jonker, Volgenant 1987, doi 10.1007/BF02278710), O(rows^2 (rows +
/// columns)). Keeps its workspace: nothing is allocated once the largest problem was seen.
class Assignment {
 public:
  static constexpr int none = -1;

  /// `cost` row by row, rows x columns; infinity or NaN forbids a pair. A row without partner costs `miss` (finite):
  /// what is minimised is the sum over all rows. Returns the column of each row, or none; valid until the next call.
  /// Pairs that cost exactly `miss` may or may not be made.
  std::span<const int> solve(std::span<const double> cost, int rows, int columns, double miss);

  /// The sum that the last `solve` reached.
  [[nodiscard]] double total() const { return total_; }

 private:
  void augment(std::span<const double> cost, int columns, double miss, int row);

  double total_ = 0;
  std::vector<int> column_of_row_;
  std::vector<int> row_of_column_;  ///< real columns, then one private column per row that stands for "no partner"
  std::vector<int> previous_;       ///< column before this one on the shortest path
  std::vector<double> price_;
  std::vector<double> row_price_;
  std::vector<double> distance_;
  std::vector<char> done_;
};

}  // namespace downrange
