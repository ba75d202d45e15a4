#pragma once
/// What tests of the live service share: a vehicle as the example range's sensors see it, and archives judged.

#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <archive/compare.hpp>
#include <archive/replay.hpp>
#include <archive/writer.hpp>
#include <downrange/stage/engine.hpp>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "config/load.hpp"
#include "daemon_process.hpp"

namespace downrange::test {

inline Time utc_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return {static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec};
}

/// A vehicle above the sea south of the pad, and what the example range's sensors see of it. No noise: the figures are
/// not the point here.
class Vehicle {
 public:
  [[nodiscard]] RadarTspi plot(std::size_t radar, std::uint64_t sequence, Time epoch) const {
    const RadarConfig& config = range_.radars[radar];
    RadarTspi tspi;
    tspi.sensor = config.id;
    tspi.target = "kslv";
    tspi.sequence = sequence;
    tspi.epoch = epoch;
    tspi.measured = polar_from_enu(config.site.enu_of(at(epoch)));
    tspi.simulated = true;
    return tspi;
  }
  [[nodiscard]] AngleTspi angles(const AngleSensorConfig& tracker, std::uint64_t sequence, Time epoch) const {
    const Polar look = polar_from_enu(tracker.site.enu_of(at(epoch)));
    AngleTspi angles;
    angles.sensor = tracker.id;
    angles.target = "kslv";
    angles.sequence = sequence;
    angles.epoch = epoch;
    angles.azimuth_rad = look.azimuth_rad;
    angles.elevation_rad = look.elevation_rad;
    angles.simulated = true;
    return angles;
  }
  [[nodiscard]] GpsFix fix(std::uint64_t sequence, Time epoch) const {
    GpsFix fix;
    fix.target = "kslv";
    fix.station = "jeju-tgs";
    fix.sequence = sequence;
    fix.epoch = epoch;
    fix.position = at(epoch);
    fix.simulated = true;
    return fix;
  }

 private:
  [[nodiscard]] static Position<Ecef> at(Time t) {
    const double degree = std::numbers::pi / 180;
    const double s = static_cast<double>(t.ns % 1'000'000'000'000) * 1e-9;
    return ecef_from_geodetic({(33 - 0.001 * s) * degree, 127.5 * degree, 80e3 + 10 * s});
  }

  RangeConfig range_ = config::load(naro).range;
};

/// An archive's events once more through an engine in this process, with the configuration attached to it.
inline void replay(const std::filesystem::path& from, const std::filesystem::path& to) {
  struct Recording final : ResultSink {
    explicit Recording(const std::filesystem::path& file) : writer(file) {}
    void emit(const Result& result) override { writer.write(result); }
    archive::Writer writer;
  } recording(to);
  const auto config = config::load_text(archive::read_attachment(from, "config.toml").value_or(""), "config.toml");
  Engine engine(config.range, config.node.stages, recording);
  archive::EventSource source(from);
  while (const auto event = source.next()) {
    recording.writer.write(*event);
    engine.handle(*event);
  }
  engine.advance_to(source.last_tick().value());
  ASSERT_TRUE(recording.writer.close().ok());
}

/// Whether two archives hold the same bits on each of the topics, and on none of them nothing.
inline testing::AssertionResult same_bits(const std::filesystem::path& a, const std::filesystem::path& b,
                                          const std::vector<std::string>& topics = {}) {
  const archive::CompareReport report = archive::compare(a, b, topics);
  const bool empty = std::ranges::any_of(report.topics, [](const auto& topic) { return topic.count_a == 0; });
  if (report.identical() && !empty) return testing::AssertionSuccess();
  auto failure = testing::AssertionFailure();
  for (const auto& t : report.topics) {
    failure << t.topic << ": " << t.count_a << " and " << t.count_b << " messages";
    if (t.first) failure << ", first difference at " << t.first->index << ": " << t.first->what;
    failure << '\n';
  }
  return failure;
}

inline std::uint64_t events_in(const std::filesystem::path& file) {
  archive::EventSource source(file);
  std::uint64_t events = 0;
  while (source.next()) ++events;
  return events;
}

}  // namespace downrange::test
