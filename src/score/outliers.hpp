#pragma once
/// Plots that no noise explains, told by the truth.

#include <array>
#include <cstdint>
#include <downrange/geo/polar.hpp>
#include <downrange/stage/source_table.hpp>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "score/truth.hpp"

namespace downrange::score {

/// Which message of which sensor.
using MessageId = std::pair<Name, std::uint64_t>;

/// The one definition of an outlier: a plot (of an angles-only tracker: a direction) that is further than 10 sigma from
/// the median error of its radar within its 10 s, in range, azimuth on the sky or elevation; sigma is the instrument's
/// as it is configured. A bias or a slow pointing error moves the median along, and is no outlier. Fewer plots than
/// five within 10 s have no median to be judged by: none of them is one.
class OutlierFinder {
 public:
  OutlierFinder(const RangeConfig& range, TruthFunction truth);

  /// A plot as it was measured, in any order; judged in the parts that it has and its sensor measures. Of a sensor that
  /// is not configured, at a time without truth, or not finite: left out.
  void add(const Name& sensor, std::uint64_t sequence, Time epoch, const Plot& measured);

  [[nodiscard]] std::set<MessageId> outliers() const;

 private:
  struct Instrument {
    Site site;
    std::array<double, 3> sigma;  ///< range, azimuth, elevation; 0: not measured
  };
  struct Judged {
    std::uint64_t sequence;
    std::array<double, 3> sigmas;  ///< its error over the instrument's 1-sigma
  };

  TruthFunction truth_;
  std::map<Name, Instrument> instruments_;
  std::map<std::pair<Name, std::int64_t>, std::vector<Judged>> bins_;  ///< by sensor and 10 s
};

}  // namespace downrange::score
