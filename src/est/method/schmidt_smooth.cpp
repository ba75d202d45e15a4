/// Method schmidt with GPS smoothed by later fixes: the GPS track at the last fixes is part of the state, every fix
/// corrects it, and a plot between two of them teaches the bias when enough fixes have come.
///
/// Two things that plot and track have in common are left out, both small: the plot's noise, which has moved the fused
/// track in the meantime, and the jerk between the two fixes, which moved the track and the interval's other plots too
/// (0.1 m at fixes a second apart, a metre at three).

#include <algorithm>
#include <downrange/est/method/schmidt.hpp>
#include <span>

#include "consider.hpp"

namespace downrange {

void Schmidt::forget_knots(Target& t) {
  t.knot_count = 0;
  t.held.clear();
}

void Schmidt::add_knot(Target& t) const {
  if (knots_ == 0) return;
  for (int i = 0; i < t.bank.count; ++i) {
    Hypothesis& h = t.bank.mode[static_cast<std::size_t>(i)];
    for (int k = 0; k < knots_; ++k) {
      const int from = k + 1 < knots_ ? knot_at(k + 1) : gps_at;
      h.x.segment<9>(knot_at(k)) = h.x.segment<9>(from);
      h.P.middleRows<9>(knot_at(k)) = h.P.middleRows<9>(from);
    }
    for (int k = 0; k < knots_; ++k)
      h.P.middleCols<9>(knot_at(k)) = h.P.middleCols<9>(k + 1 < knots_ ? knot_at(k + 1) : gps_at);
  }
  std::rotate(t.knots.begin(), t.knots.begin() + 1, t.knots.begin() + knots_);
  t.knots[static_cast<std::size_t>(knots_ - 1)] = t.epoch;
  t.knot_count = std::min(t.knot_count + 1, knots_);
}

template <int First, int M>
void Schmidt::update_biases_between_knots(Target& t, const Held& held) const {
  const auto source = static_cast<std::size_t>(held.source);
  const RadarModel& radar = settings_.radars[source];
  const RadarBlock& block = layout(t).radars[source];
  const Bridge between = bridge(gps_model_, (held.epoch - t.knots[0]).seconds(), (t.knots[1] - held.epoch).seconds());

  // GPS and biases are the same in all modes: linearised once.
  const Eigen::VectorXd& x = t.bank.mode[0].x;
  Vec<9> motion = Vec<9>::Zero();
  for (int part = 0; part < 3; ++part) {
    for (int k = 0; k < 3; ++k)
      motion.segment<3>(3 * part) += between.from(part, k) * x.segment<3>(knot_at(0) + 3 * k) +
                                     between.to(part, k) * x.segment<3>(knot_at(1) + 3 * k);
  }
  const auto l = components<First, M>(linearise_plot(motion, gps_at, x, radar, block, held.plot.measured));
  Mat<M, 18> H = Mat<M, 18>::Zero();  // by the two knots
  Mat<M, M> R = plot_noise<First, M>(radar, held.plot);
  for (int part = 0; part < 3; ++part) {
    const Mat<M, 3> J = l.H.of_motion.template middleCols<3>(3 * part);
    for (int k = 0; k < 3; ++k) {
      H.template middleCols<3>(3 * k) += between.from(part, k) * J;
      H.template middleCols<3>(9 + 3 * k) += between.to(part, k) * J;
      R += between.noise(part, k) * J * l.H.of_motion.template middleCols<3>(3 * k).transpose();
    }
  }
  const auto H_bias = l.H.of_radar.leftCols(block.size());

  std::array<Evidence<M>, ModelSet::max_models> evidence;
  const auto count = static_cast<std::size_t>(t.bank.count);
  for (std::size_t k = 0; k < count; ++k) {
    const Hypothesis& h = t.bank.mode[k];
    Evidence<M>& e = evidence[k];
    e.nu = l.nu;
    e.W.resize(h.x.size(), M);
    e.W = h.P.middleCols<18>(knot_at(0)).lazyProduct(H.transpose());
    e.W += h.P.middleCols(block.at, block.size()).lazyProduct(H_bias.transpose());
    e.S = H * e.W.template middleRows<18>(knot_at(0)) + H_bias.lazyProduct(e.W.middleRows(block.at, block.size())) + R;
    factorise(e);
  }
  const bool learns =
      evidence[0].nis <= gates_[M] && std::ranges::none_of(std::span(evidence).first(count), &Evidence<M>::singular);
  for (std::size_t k = 0; k < count && learns; ++k)
    update_biases<M>(t.bank.mode[k], first_radar_, evidence[k], evidence[k].W.template middleRows<9>(fused_at));
  note_learnt(t, held.source, {.epoch = held.epoch, .plot = held.plot}, learns);
}

void Schmidt::release_held(Target& t) const {
  if (t.knot_count < knots_) return;
  const auto end = std::ranges::find_if(t.held, [&](const Held& plot) { return plot.epoch > t.knots[1]; });
  for (auto plot = t.held.begin(); plot != end; ++plot) {
    if (plot->epoch < t.knots[0]) continue;
    with_components(plot->plot, [&]<int First, int M>() { update_biases_between_knots<First, M>(t, *plot); });
  }
  t.held.erase(t.held.begin(), end);
}

}  // namespace downrange
