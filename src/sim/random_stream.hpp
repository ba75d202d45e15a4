#pragma once
/// Random numbers of one source: the same on every machine with the same mathematics library, and untouched by what
/// other sources draw.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>

namespace downrange::sim {

/// The stream of (seed, name). Two names give unrelated streams, so adding a sensor leaves the others' noise as it was.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name) : engine_(mixed(seed, name)) {}

  /// In [0, 1), 53 bits.
  [[nodiscard]] double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Mean 0, sigma 1. Box-Muller written out: the standard leaves the algorithm of std::normal_distribution open.
  [[nodiscard]] double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  /// FNV-1a over the name, then the SplitMix64 finaliser.
  static std::uint64_t mixed(std::uint64_t seed, std::string_view name) {
    std::uint64_t h = 0xcbf29ce484222325u;
    for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    h += seed * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return h ^ (h >> 31);
  }

  std::mt19937_64 engine_;
};

/// First-order Gauss-Markov error, stationary from the first value on.
class ColouredNoise {
 public:
  /// `tau_s` > 0; `step_s` between two values.
  ColouredNoise(RandomStream& random, double sigma, double tau_s, double step_s)
      : random_(&random), sigma_(sigma), keep_(std::exp(-step_s / tau_s)), value_(sigma * random.normal()) {}

  /// The current value; moves on by one step.
  [[nodiscard]] double next() {
    const double value = value_;
    value_ = keep_ * value_ + sigma_ * std::sqrt(1 - keep_ * keep_) * random_->normal();
    return value;
  }

 private:
  RandomStream* random_;
  double sigma_;
  double keep_;
  double value_;
};

}  // namespace downrange::sim
