#include <cmath>
#include <downrange/est/track/assignment.hpp>
#include <limits>

namespace downrange {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Cost of a row with a real column, with its own column for "no partner", with anybody else's.
double cost_of(std::span<const double> cost, int columns, double miss, int row, int column) {
  if (column >= columns) return column == columns + row ? miss : infinity;
  const double c = cost[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + column];
  return std::isnan(c) ? infinity : c;
}

}  // namespace

std::span<const int> Assignment::solve(std::span<const double> cost, int rows, int columns, double miss) {
  const int all = columns + rows;
  column_of_row_.assign(static_cast<std::size_t>(rows), none);
  row_of_column_.assign(static_cast<std::size_t>(all), none);
  price_.assign(static_cast<std::size_t>(all), 0);
  row_price_.assign(static_cast<std::size_t>(rows), 0);
  previous_.resize(static_cast<std::size_t>(all));
  distance_.resize(static_cast<std::size_t>(all));
  done_.resize(static_cast<std::size_t>(all));
  for (int row = 0; row < rows; ++row) augment(cost, columns, miss, row);

  total_ = 0;
  for (int row = 0; row < rows; ++row) {
    int& column = column_of_row_[static_cast<std::size_t>(row)];
    total_ += cost_of(cost, columns, miss, row, column);
    if (column >= columns) column = none;
  }
  return column_of_row_;
}

/// Dijkstra over reduced costs from `row` to the nearest free column; every row can reach its own private one.
void Assignment::augment(std::span<const double> cost, int columns, double miss, int row) {
  const int all = static_cast<int>(row_of_column_.size());
  const auto at = [](auto& v, int i) -> auto& { return v[static_cast<std::size_t>(i)]; };
  for (int j = 0; j < all; ++j) {
    at(distance_, j) = infinity;
    at(previous_, j) = none;
    at(done_, j) = 0;
  }
  int from_row = row;
  int from_column = none;
  double reached = 0;
  int free_column = none;
  while (free_column == none) {
    int nearest = none;
    for (int j = 0; j < all; ++j) {
      if (at(done_, j) != 0) continue;
      const double reduced =
          cost_of(cost, columns, miss, from_row, j) - at(row_price_, from_row) - at(price_, j) + reached;
      if (reduced < at(distance_, j)) {
        at(distance_, j) = reduced;
        at(previous_, j) = from_column;
      }
      if (nearest == none || at(distance_, j) < at(distance_, nearest)) nearest = j;
    }
    reached = at(distance_, nearest);
    at(done_, nearest) = 1;
    from_column = nearest;
    from_row = at(row_of_column_, nearest);
    if (from_row == none) free_column = nearest;
  }
  // New prices keep every reduced cost non-negative, and zero along what is assigned.
  at(row_price_, row) += reached;
  for (int j = 0; j < all; ++j) {
    if (at(done_, j) == 0 || j == free_column) continue;
    at(price_, j) -= reached - at(distance_, j);
    at(row_price_, at(row_of_column_, j)) += reached - at(distance_, j);
  }
  for (int j = free_column; j != none;) {
    const int before = at(previous_, j);
    at(row_of_column_, j) = before == none ? row : at(row_of_column_, before);
    at(column_of_row_, at(row_of_column_, j)) = j;
    j = before;
  }
}

}  // namespace downrange
