#pragma once
/// What the archive's tests share: a folder of their own and one record of every kind.

#include <gtest/gtest.h>
#include <unistd.h>

#include <archive/reader.hpp>
#include <archive/writer.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "../support/samples.hpp"

namespace downrange::archive {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "downrange-archive-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_bytes(const std::filesystem::path& path, ByteView bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline void write_text(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline constexpr Time t0{1'517'949'900'000'000'000};  // 2018-02-06T20:45:00Z

inline RadarTspi some_radar(std::uint64_t i) {
  RadarTspi r;
  r.sensor = "goheung";
  r.target = "naro";
  r.sequence = i;
  r.epoch = t0 + milliseconds(static_cast<std::int64_t>(50 * i));
  r.received = r.epoch + milliseconds(40);
  r.measured = {12'345.678 + static_cast<double>(i), 1.25, 0.5};
  r.range_rate_m_s = -812.5;
  r.range_rate_valid = true;
  r.mode = TrackMode::Coast;
  r.snr_db = 17.25;
  r.snr_valid = true;
  r.simulated = true;
  return r;
}

inline AngleTspi some_angles() {
  AngleTspi a;
  a.sensor = "optical";
  a.target = "naro";
  a.sequence = 12;
  a.epoch = t0 + milliseconds(20);
  a.received = t0 + milliseconds(90);
  a.azimuth_rad = 3.25;
  a.elevation_rad = 0.75;
  a.mode = TrackMode::Acquire;
  a.simulated = true;
  return a;
}

inline GpsFix some_gps() {
  GpsFix g;
  g.target = "naro";
  g.receiver = "gps-1";
  g.station = "jeju";
  g.sequence = 1ULL << 40;
  g.epoch = t0 + milliseconds(3);
  g.received = t0 + milliseconds(700);
  g.position = {{-3.1e6, 4.1e6, 3.6e6}};
  g.velocity = {{1.5, -2.5, 3.5}};
  g.velocity_valid = true;
  g.sigma_horizontal_m = 4;
  g.sigma_vertical_m = 6;
  g.sigma_velocity_m_s = 0.15;
  g.fix = FixType::Differential;
  g.satellites = 11;
  g.satellites_valid = true;
  g.simulated = true;
  return g;
}

inline MissionEvent some_mission() {
  return {"flight-3", "lift-off", MissionEventKind::Liftoff, 7, t0, t0 + milliseconds(1), true};
}

inline Observation some_observation() {
  Observation o;
  o.verdict = Reason::Frozen;
  o.sensor = "jeju";
  o.target = "naro";
  o.receiver = "gps-1";
  o.sequence = 41;
  o.step = 99;
  o.epoch = t0 + milliseconds(5);
  o.received = t0 + milliseconds(800);
  o.measured = Fix{.position = {{-3.2e6, 4.2e6, 3.7e6}},
                   .velocity = {{-1, -2, -3}},
                   .velocity_valid = true,
                   .sigma_horizontal_m = 1,
                   .sigma_vertical_m = 2,
                   .sigma_velocity_m_s = 3};
  o.simulated = true;
  return o;
}

inline SensorBias some_bias(int terms = 4) {
  SensorBias b;
  b.sensor = "goheung";
  b.method = "song2015";
  b.epoch = t0;
  b.received = t0 + milliseconds(20);
  b.reference = BiasReference::CrossRadar;
  b.samples = 1234;
  b.terms = terms;
  for (std::size_t i = 0; i < static_cast<std::size_t>(terms); ++i) {
    b.term[i] = static_cast<BiasTerm>(12 - i);
    b.state[i] = static_cast<BiasState>(i % 4);
    b.value[i] = 0.5 * static_cast<double>(i) - 1;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(triangle_size(terms)); ++i) {
    b.covariance[i] = 1.0 / (1.0 + static_cast<double>(i));
  }
  return b;
}

inline Trajectory some_trajectory(int state_size = 6) {
  Trajectory t;
  t.target = "naro";
  t.method = "song2015";
  t.primary = true;
  t.epoch = t0 + milliseconds(50);
  t.received = t0 + milliseconds(90);
  t.quality = TrackQuality::Coasting;
  t.state_size = state_size;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state_size); ++i)
    t.state[i] = 1e6 / (3.0 + static_cast<double>(i));
  for (std::size_t i = 0; i < static_cast<std::size_t>(triangle_size(state_size)); ++i) {
    t.covariance[i] = 0.1 * static_cast<double>(i + 1);
  }
  t.geodetic = {0.6, 2.2, 150'000};
  t.speed_m_s = 2500;
  t.flight_path_rad = 0.7;
  t.heading_rad = 3.1;
  t.sources = 0b101;
  t.nis = 2.5;
  t.nis_dof = 3;
  return t;
}

inline SlavingCommand some_slaving() {
  SlavingCommand s;
  s.antenna = "dish-1";
  s.target = "naro";
  s.tick = t0 + milliseconds(100);
  s.apply_at = t0 + milliseconds(150);
  s.valid_until = t0 + milliseconds(400);
  s.data_epoch = t0 + milliseconds(50);
  s.age_s = 0.1;
  s.azimuth_rad = 6.9;
  s.elevation_rad = 0.4;
  s.range_m = 98'765.4;
  s.azimuth_rate_rad_s = 0.01;
  s.elevation_rate_rad_s = -0.02;
  s.range_rate_m_s = 700;
  s.sigma_azimuth_rad = 1e-4;
  s.sigma_elevation_rad = 2e-4;
  s.source = SlavingSource::Nominal;
  s.limits = LimitElevation | LimitUnwrapped;
  return s;
}

inline SourceHealth some_health() {
  SourceHealth h;
  h.sensor = "goheung";
  h.target = "naro";
  h.time = t0 + milliseconds(1000);
  h.rate_hz = 19.5;
  h.latency_s = 0.045;
  for (std::size_t i = 0; i < reason_count; ++i) h.count[i] = 1000 * i + 1;
  h.residual_mean = -0.1;
  h.residual_sigma = 1.1;
  h.nis = 0.95;
  h.qualified = true;
  h.why = Disqualification::Rejected;
  h.rejected_for = Reason::Frozen;
  h.nis_inside_95 = 0.925;
  h.nis_count = 1000;
  h.mismatch = true;
  return h;
}

inline Truth some_truth() {
  return {"naro", t0 + milliseconds(25), {{1e6, 2e6, 3e6}}, {{10, 20, 30}}, {1, -2, 3}, true};
}

/// A sample, received a while after t0.
template <class Input>
Input sample_at(std::int64_t ms) {
  Input input = test::sample<Input>();
  input.epoch = t0 + milliseconds(ms - 1);
  input.received = t0 + milliseconds(ms);
  return input;
}

/// Every kind of record once, in a fixed order, with an attachment and metadata.
inline void write_all_kinds(Writer& writer) {
  writer.attach("config.toml", "application/toml", "[range]\nname = \"naro\"\n", t0);
  writer.metadata("downrange", {{"node", "centre-a"}, {"version", "0.1.0"}});
  writer.write(Event(some_mission()));
  writer.write(Event(some_radar(1)));
  writer.write(Event(some_gps()));
  writer.write(Event(some_observation()));
  writer.write(Result(some_observation()));
  writer.write(Result(some_bias()));
  writer.write(Result(some_trajectory()));
  writer.write(Result(some_slaving()));
  writer.write(Result(some_health()));
  writer.write_truth(some_truth());
  writer.write(Event(some_angles()));
  writer.write(Event(sample_at<OperatorCommand>(810)));
  writer.write(Event(sample_at<AntennaReport>(820)));
  writer.write(Event(sample_at<PlatformState>(830)));
  writer.write_last_tick(t0 + milliseconds(1000));
}
inline constexpr std::size_t all_kinds_count = 15;

inline std::vector<Entry> read_all(Reader& reader) {
  std::vector<Entry> entries;
  while (auto entry = reader.next()) entries.push_back(std::move(*entry));
  return entries;
}

}  // namespace downrange::archive
