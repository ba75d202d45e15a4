#include <algorithm>
#include <downrange/est/joint.hpp>
#include <downrange/est/method.hpp>
#include <downrange/est/motion.hpp>
#include <downrange/est/rewind.hpp>
#include <downrange/est/song2015.hpp>
#include <stdexcept>
#include <string>
#include <tuple>

namespace downrange {
namespace {

/// Bit i: radar i contributed within the last second before `now`.
std::uint64_t recent_sources(const std::array<Time, FusedTrack::max_radars>& contributed, std::size_t radars,
                             Time now) {
  std::uint64_t mask = 0;
  for (std::size_t radar = 0; radar < radars; ++radar) {
    if (now - contributed[radar] <= milliseconds(1000)) mask |= std::uint64_t{1} << radar;
  }
  return mask;
}

/// `Song2015` behind the contract of a method.
class Song2015Method final : public Method {
 public:
  Song2015Method(const MethodSettings& settings, bool correct)
      : rewinder_(Song2015(settings, correct), Song2015(settings, correct).initial(), settings.history) {}

  void start(int target, Time epoch, const Gaussian<9>& estimate) override { rewinder_.start(target, epoch, estimate); }
  Outcome process(const Measurement& m, Time now) override { return rewinder_.process(m, now); }

  std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const override {
    const FusedTrack& track = rewinder_.state().fused[static_cast<std::size_t>(target)];
    if (!track.started) return std::nullopt;
    TrackEstimate e = estimate(track.current, track.epoch, at.value_or(track.epoch), settings().q_m2_s3);
    e.sources = recent_sources(track.contributed, settings().radars.size(), track.epoch);
    e.nis = track.nis;
    e.nis_dof = 3;
    return e;
  }

  std::optional<TrackEstimate> gps_track(int target, Time at) const override {
    const GpsTrack& gps = rewinder_.state().gps[static_cast<std::size_t>(target)];
    if (!gps.confirmed || !rewinder_.core().corrects()) return std::nullopt;
    return estimate(gps.state, gps.epoch, at, settings().gps_q_m2_s3);
  }

  BiasEstimate bias(int radar) const override {
    if (!rewinder_.core().corrects()) return {};
    return describe(rewinder_.state().radars[static_cast<std::size_t>(radar)], settings());
  }

  const SourceAccount& account(int source) const override {
    return rewinder_.state().accounts[static_cast<std::size_t>(source)];
  }

 private:
  const MethodSettings& settings() const { return rewinder_.core().settings(); }

  static TrackEstimate estimate(const Gaussian<6>& state, Time data_epoch, Time at, double q) {
    const Gaussian<6> x = at == data_epoch ? state : cv::predict(state, (at - data_epoch).seconds(), q);
    TrackEstimate e;
    e.epoch = at;
    e.data_epoch = data_epoch;
    e.mean.head<6>() = x.mean;
    e.cov.topLeftCorner<6, 6>() = x.cov;
    return e;
  }

  Rewinder<Song2015> rewinder_;
};

/// `Joint` behind the contract of a method.
class JointMethod final : public Method {
 public:
  explicit JointMethod(const MethodSettings& settings)
      : rewinder_(Joint(settings), Joint(settings).initial(), settings.history) {}

  void start(int target, Time epoch, const Gaussian<9>& estimate) override { rewinder_.start(target, epoch, estimate); }
  Outcome process(const Measurement& m, Time now) override { return rewinder_.process(m, now); }

  std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const override {
    const Joint::State& state = rewinder_.state();
    const Joint::Target& track = state.targets[static_cast<std::size_t>(target)];
    if (!track.started) return std::nullopt;
    TrackEstimate e;
    e.epoch = at.value_or(track.data_epoch);
    e.data_epoch = track.data_epoch;
    e.size = 9;
    const Gaussian<9> x = joint().kinematics(state, target, (e.epoch - state.epoch).seconds());
    e.mean = x.mean;
    e.cov = x.cov;
    e.sources = recent_sources(track.contributed, joint().settings().radars.size(), track.data_epoch);
    e.nis = track.nis;
    e.nis_dof = track.nis_dof;
    return e;
  }

  /// GPS is part of the fused track: there is none beside it.
  std::optional<TrackEstimate> gps_track(int, Time) const override { return std::nullopt; }

  BiasEstimate bias(int radar) const override { return joint().describe(rewinder_.state(), radar); }

  const SourceAccount& account(int source) const override {
    return rewinder_.state().accounts[static_cast<std::size_t>(source)];
  }

 private:
  const Joint& joint() const { return rewinder_.core(); }

  Rewinder<Joint> rewinder_;
};

struct NamedMethod {
  std::string_view name;
  std::unique_ptr<Method> (*make)(const MethodSettings&);
};

/// The table of methods: a new one is a line here and a file beside song2015.cpp.
constexpr NamedMethod methods[] = {
    {"song2015",
     [](const MethodSettings& s) -> std::unique_ptr<Method> { return std::make_unique<Song2015Method>(s, true); }},
    {"uncorrected",
     [](const MethodSettings& s) -> std::unique_ptr<Method> { return std::make_unique<Song2015Method>(s, false); }},
    {"joint", [](const MethodSettings& s) -> std::unique_ptr<Method> { return std::make_unique<JointMethod>(s); }},
};

}  // namespace

bool processed_before(const Measurement& a, const Measurement& b) {
  return std::tie(a.epoch, a.kind, a.source, a.target, a.sequence) <
         std::tie(b.epoch, b.kind, b.source, b.target, b.sequence);
}

const std::vector<std::string_view>& method_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const NamedMethod& m : methods) all.push_back(m.name);
    return all;
  }();
  return names;
}

std::unique_ptr<Method> make_method(std::string_view name, const MethodSettings& settings) {
  for (const NamedMethod& m : methods) {
    if (m.name == name) return m.make(settings);
  }
  throw std::invalid_argument("unknown method '" + std::string(name) + "'");
}

}  // namespace downrange
