#pragma once
/// Fine test, the main detector: do two witnesses still differ as they did some seconds ago, with the biases as they
/// were known then? What a bias explains drops out; what is left is noise, the wander of mounts and receivers over
/// that time, 2 sigma^2 (1 - e^(-lag/tau)), and what the change of geometry makes of what is not known of the biases.

#include "coarse_test.hpp"

namespace downrange::integrity {

/// How two witnesses differed at some time: the median of five samples, and the biases as known then.
struct Reference {
  Time epoch;  ///< of the newest of them
  Vec<3> d = Vec<3>::Zero();
  Mat<3, 3> white = Mat<3, 3>::Zero();
  Mat<3, bias_term_count> by_first = Mat<3, bias_term_count>::Zero();
  Mat<3, bias_term_count> by_second = Mat<3, bias_term_count>::Zero();
  KnownBias first;
  KnownBias second;
};

/// Which samples a reference may be made of: `from` <= epoch <= `to`; the newest five, or the oldest.
struct ReferenceSpan {
  Time from;
  Time to;
  bool newest = true;
};

/// What is taken as known of the biases.
enum class Knowledge : std::uint8_t {
  Prior,   ///< what is configured or calibrated
  Learnt,  ///< and what GPS taught
};

/// None: fewer than three instants of which both have a sample.
[[nodiscard]] std::optional<Reference> reference_of(const Witness& first, const Witness& second,
                                                    const ReferenceSpan& span, Knowledge knowledge);

/// Of two receivers, which have no biases to be excused by: the median of their last five differences up to `at`.
[[nodiscard]] TestResult steady_test(const Witness& first, const Witness& second, Time at, const Threshold& threshold);

[[nodiscard]] TestResult fine_test(const Witness& first, const Sample& a, const Witness& second, const Sample& b,
                                   const Reference& reference, const Threshold& threshold);

}  // namespace downrange::integrity
