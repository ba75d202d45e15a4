#pragma once
/// How far a set of estimates is from a set of truths: OSPA and GOSPA.

#include <Eigen/Core>
#include <downrange/est/track/assignment.hpp>
#include <span>
#include <vector>

namespace downrange {

/// GOSPA and what it is made of, each in units of length^p.
struct Gospa {
  double distance = 0;      ///< (localisation + missed_cost + false_cost)^(1/p), metres
  double localisation = 0;  ///< sum of d^p over the pairs
  double missed_cost = 0;   ///< c^p / 2 per truth without estimate
  double false_cost = 0;    ///< c^p / 2 per estimate without truth
  int pairs = 0;
  int missed = 0;
  int false_tracks = 0;
};

/// Distances of sets of positions (any Cartesian frame, metres), with cut-off c > 0 and order p >= 1. A position that
/// is not finite is nobody's partner.
class SetDistance {
 public:
  SetDistance(double cutoff_m, double order) : c_(cutoff_m), p_(order) {}

  /// Optimal sub-pattern assignment (Schuhmacher, Vo, Vo 2008, doi 10.1109/TSP.2008.920469), per target: metres,
  /// 0 to c; 0 for two empty sets, c where one is empty.
  [[nodiscard]] double ospa(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates);

  /// Generalised OSPA with alpha = 2 (Rahmathullah, Garcia-Fernandez, Svensson 2017, doi
  /// 10.23919/ICIF.2017.8009645): not per target; each missed or false one costs c^p / 2.
  [[nodiscard]] Gospa gospa(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates);

 private:
  /// d^p of every pair into costs_; pairs at c or further are forbidden.
  void fill(std::span<const Eigen::Vector3d> truths, std::span<const Eigen::Vector3d> estimates);

  double c_;
  double p_;
  Assignment assignment_;
  std::vector<double> costs_;
};

}  // namespace downrange
