#include <algorithm>
#include <downrange/est/joint.hpp>
#include <downrange/est/method.hpp>
#include <downrange/est/quick_look.hpp>
#include <downrange/est/rewind.hpp>
#include <downrange/est/schmidt.hpp>
#include <downrange/est/song2015.hpp>
#include <downrange/est/track_level.hpp>
#include <downrange/est/ts.hpp>
#include <stdexcept>
#include <string>
#include <tuple>

namespace downrange {
namespace {

/// An estimator behind the contract of a method: its state is kept in order whatever the order of arrival.
template <class Core>
class RewoundMethod final : public Method {
 public:
  explicit RewoundMethod(const Core& core) : rewinder_(core, core.initial(), core.settings().history) {}

  void start(int target, Time epoch, const Gaussian<9>& estimate) override { rewinder_.start(target, epoch, estimate); }
  Outcome process(const Measurement& m, Time now) override { return rewinder_.process(m, now); }
  std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const override {
    return core().fused(state(), target, at);
  }
  std::optional<TrackEstimate> gps_track(int target, Time at) const override {
    return core().gps_track(state(), target, at);
  }
  BiasEstimate bias(int radar) const override { return core().bias(state(), radar); }
  const SourceAccount& account(int source) const override { return core().account(state(), source); }

 private:
  const Core& core() const { return rewinder_.core(); }
  const typename Core::State& state() const { return rewinder_.state(); }

  Rewinder<Core> rewinder_;
};

template <class Core>
std::unique_ptr<Method> rewound(const Core& core) {
  return std::make_unique<RewoundMethod<Core>>(core);
}

struct NamedMethod {
  std::string_view name;
  std::unique_ptr<Method> (*make)(const MethodSettings&);
  int most_radars = 64;
};

/// The table of methods: a new one is a line here and a file beside song2015.cpp.
constexpr NamedMethod methods[] = {
    {"joint", [](const MethodSettings& s) { return rewound(Joint(s)); }},
    {"schmidt", [](const MethodSettings& s) { return rewound(Schmidt(s)); }},
    {"ts",
     [](const MethodSettings& s) {
       return s.stations > 0 && s.gps_error.enabled ? rewound(Ts<12>(s)) : rewound(Ts<9>(s));
     }},
    {"song2015", [](const MethodSettings& s) { return rewound(Song2015(s, true)); }},
    {"information", [](const MethodSettings& s) { return rewound(TrackLevel<InformationRule>(s)); }, max_fused_tracks},
    {"federated", [](const MethodSettings& s) { return rewound(TrackLevel<FederatedRule>(s)); }, max_fused_tracks},
    {"map", [](const MethodSettings& s) { return rewound(TrackLevel<MapRule>(s)); }, max_fused_tracks},
    {"bar-shalom-campo", [](const MethodSettings& s) { return rewound(TrackLevel<CampoRule>(s)); }, max_fused_tracks},
    {"convex", [](const MethodSettings& s) { return rewound(TrackLevel<ConvexRule>(s)); }, max_fused_tracks},
    {"alpha-beta", [](const MethodSettings& s) -> std::unique_ptr<Method> { return std::make_unique<QuickLook>(s); }},
    {"uncorrected", [](const MethodSettings& s) { return rewound(Song2015(s, false)); }},
};

const NamedMethod& method_named(std::string_view name) {
  for (const NamedMethod& m : methods) {
    if (m.name == name) return m;
  }
  throw std::invalid_argument("unknown method '" + std::string(name) + "'");
}

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

int most_radars(std::string_view method) { return method_named(method).most_radars; }

std::unique_ptr<Method> make_method(std::string_view name, const MethodSettings& settings) {
  return method_named(name).make(settings);
}

}  // namespace downrange
