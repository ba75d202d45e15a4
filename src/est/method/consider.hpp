#pragma once
/// Updates of method schmidt: what a measurement may not correct is considered, and keeps mean and covariance.

#include <downrange/est/method/schmidt.hpp>

namespace downrange {

/// A fix corrects what stands from `at` on; what stands before is considered: it keeps mean and covariance, and what it
/// has in common with the rest shrinks with it.
template <int M>
void update_considering_first(Hypothesis& h, const Evidence<M>& e, Eigen::Index at) {
  const Eigen::Index corrected = h.x.size() - at;
  const auto W = e.W.bottomRows(corrected);
  const auto considered = e.W.topRows(at);
  h.x.tail(corrected) += W.lazyProduct(e.whitened);
  subtract_product(h.P.bottomRightCorner(corrected, corrected), W, W);
  subtract_product(h.P.topRightCorner(at, corrected), considered, W);
  h.P.bottomLeftCorner(corrected, at) = h.P.topRightCorner(at, corrected).transpose();
}

/// A plot corrects all but the GPS track and what is `considered` besides (apply_evidence_but).
template <int M>
void update_considering_gps(Hypothesis& h, const Evidence<M>& f, const Columns<M>& considered) {
  const Vec<12> gps = h.x.segment<12>(Schmidt::gps_at);
  const Mat<12, 12> P_gps = h.P.block<12, 12>(Schmidt::gps_at, Schmidt::gps_at);
  apply_evidence_but<M>(considered, h, f);
  h.x.segment<12>(Schmidt::gps_at) = gps;
  h.P.block<12, 12>(Schmidt::gps_at, Schmidt::gps_at) = P_gps;
}

// A plot, compared with the fused track A (evidence f) and with GPS (evidence g), corrects by the one A and by the
// other the biases B, while what is known of GPS, G, stands between them and keeps what it is. With K = [W_fA L_f^-1;
// 0; W_gB L_g^-1] in (I - K H) P (I - K H)' + K R K':
//
//   P_AA - W_fA W_fA'    P_GA - W_fG W_fA'    P_BB - W_gB W_gB'    P_BG - W_gB W_gG'
//   P_BA - W_fB W_fA' - W_gB W_gA' + W_gB C' W_fA',  C = L_f^-1 (H_f P H_g' + R) L_g^-T
//
// C is what the two have in common, the plot's own noise included. `b`: where the biases begin.

template <int M>
void update_track(Hypothesis& h, Eigen::Index b, const Evidence<M>& f) {
  constexpr int a = Schmidt::fused_at;
  constexpr int gps = Schmidt::gps_at;
  const Eigen::Index others = h.x.size() - gps;
  const Mat<9, M> W_fA = f.W.template middleRows<9>(a);
  h.x.segment<9>(a) += W_fA * f.whitened;
  subtract_product(h.P.block<9, 9>(a, a), W_fA, W_fA);
  subtract_product(h.P.block(gps, a, b - gps, 9), f.W.middleRows(gps, b - gps), W_fA);
  subtract_product(h.P.block(b, a, h.x.size() - b, 9), f.W.bottomRows(h.x.size() - b), W_fA);
  h.P.block(a, gps, 9, others) = h.P.block(gps, a, others, 9).transpose();
}

/// `of_A`: W_gA, less W_fA C where the same plot was followed.
template <int M>
void update_biases(Hypothesis& h, Eigen::Index b, const Evidence<M>& g, const Mat<9, M>& of_A) {
  constexpr int a = Schmidt::fused_at;
  constexpr int gps = Schmidt::gps_at;
  const Eigen::Index biases = h.x.size() - b;
  const auto W_gB = g.W.bottomRows(biases);
  h.x.tail(biases) += W_gB.lazyProduct(g.whitened);
  subtract_product(h.P.bottomRightCorner(biases, biases), W_gB, W_gB);
  subtract_product(h.P.block(b, gps, biases, b - gps), W_gB, g.W.middleRows(gps, b - gps));
  subtract_product(h.P.block(b, a, biases, 9), W_gB, of_A);
  h.P.block(a, b, b, biases) = h.P.block(b, a, biases, b).transpose();
}

/// C.
template <int M>
Mat<M, M> in_common(const Evidence<M>& f, const BlockJacobian<M>& H_f, const Evidence<M>& g, const Mat<M, M>& R) {
  const Mat<M, M> R_L = g.L.template triangularView<Eigen::Lower>().solve(R).transpose();  // R L_g^-T
  return f.L.template triangularView<Eigen::Lower>().solve(observe(H_f, g.W) + R_L);
}

}  // namespace downrange
