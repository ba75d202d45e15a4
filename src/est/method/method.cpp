#include <algorithm>
#include <deque>
#include <downrange/est/method/joint.hpp>
#include <downrange/est/method/method.hpp>
#include <downrange/est/method/method_table.hpp>
#include <downrange/est/method/quick_look.hpp>
#include <downrange/est/method/schmidt.hpp>
#include <downrange/est/method/song2015.hpp>
#include <downrange/est/method/track_level.hpp>
#include <downrange/est/method/ts.hpp>
#include <downrange/geo/name.hpp>
#include <stdexcept>
#include <string>

namespace downrange {
namespace {

struct NamedMethod {
  Name name;
  MethodMaker make;
  MethodCapabilities capabilities{};
};

constexpr unsigned every_kinematics = [] {
  unsigned bits = 0;
  for (const Kinematics k : all_kinematics) bits |= MethodCapabilities::bit_of(k);
  return bits;
}();
/// song2015: the range paper's biases and track.
constexpr MethodCapabilities cartesian{
    .smoothed_gps = true, .batch = true, .cartesian_bias = true, .cartesian_track = true};
constexpr MethodCapabilities track_level = [] {
  MethodCapabilities c = cartesian;
  c.most_radars = max_fused_tracks;
  return c;
}();
constexpr MethodCapabilities without_correction{.batch = true, .cartesian_track = true};
/// joint and schmidt but for their kinematics.
constexpr MethodCapabilities many_states{.kinematics = every_kinematics,
                                         .partial_plots = true,
                                         .bias_blocks = true,
                                         .wander = true,
                                         .range_rate = true,
                                         .adaptive_noise = true,
                                         .gps_regimes = true};
constexpr MethodCapabilities of_schmidt = [] {
  MethodCapabilities c = many_states;
  c.kinematics &= ~MethodCapabilities::bit_of(Kinematics::Vdie);
  c.smoothed_gps = true;
  c.white_jerk = true;
  return c;
}();

/// The methods of the house: a new one is a line here and a file beside song2015.cpp.
constexpr NamedMethod own_methods[] = {
    {"joint", [](const MethodSettings& s) { return rewound(Joint(s)); }, many_states},
    {"schmidt", [](const MethodSettings& s) { return rewound(Schmidt(s)); }, of_schmidt},
    {"ts",
     [](const MethodSettings& s) {
       return s.stations > 0 && s.gps.error.enabled ? rewound(Ts<12>(s)) : rewound(Ts<9>(s));
     },
     {.partial_plots = true,
      .bias_blocks = true,
      .range_rate = true,
      .adaptive_noise = true,
      .white_jerk = true,
      .gps_regimes = true}},
    {"song2015", [](const MethodSettings& s) { return rewound(Song2015(s, true)); }, cartesian},
    {"information", [](const MethodSettings& s) { return rewound(TrackLevel<InformationRule>(s)); }, track_level},
    {"federated", [](const MethodSettings& s) { return rewound(TrackLevel<FederatedRule>(s)); }, track_level},
    {"map", [](const MethodSettings& s) { return rewound(TrackLevel<MapRule>(s)); }, track_level},
    {"bar-shalom-campo", [](const MethodSettings& s) { return rewound(TrackLevel<CampoRule>(s)); }, track_level},
    {"convex", [](const MethodSettings& s) { return rewound(TrackLevel<ConvexRule>(s)); }, track_level},
    {"alpha-beta",
     [](const MethodSettings& s) -> std::unique_ptr<Method> { return std::make_unique<QuickLook>(s); },
     {.quick_look = true}},
    {"uncorrected", [](const MethodSettings& s) { return rewound(Song2015(s, false)); }, without_correction},
};

/// These, and behind them the registered ones. Neither reference nor view goes stale when one is added.
struct MethodTable {
  std::deque<NamedMethod> methods;
  std::vector<std::string_view> names;

  MethodTable() {
    for (const NamedMethod& m : own_methods) add(m);
  }
  void add(const NamedMethod& m) { names.push_back(methods.emplace_back(m).name.view()); }
};

MethodTable& table() {
  static MethodTable methods;
  return methods;
}

const NamedMethod& method_named(std::string_view name) {
  for (const NamedMethod& m : table().methods) {
    if (m.name.view() == name) return m;
  }
  throw std::invalid_argument("unknown method '" + std::string(name) + "'");
}

bool is_identifier(std::string_view text) {
  constexpr std::string_view allowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
  return !text.empty() && text.size() <= Name::max_size && text.find_first_not_of(allowed) == std::string_view::npos;
}

}  // namespace

const std::vector<std::string_view>& method_names() { return table().names; }

void register_method(std::string_view name, MethodMaker make, const MethodCapabilities& capabilities) {
  if (!is_identifier(name))
    throw std::invalid_argument("method '" + std::string(name) + "': a name is 1 to 31 of A-Z a-z 0-9 . _ -");
  const std::vector<std::string_view>& known = table().names;
  if (std::find(known.begin(), known.end(), name) != known.end())
    throw std::invalid_argument("there is a method '" + std::string(name) + "' already");
  table().add({.name = name, .make = make, .capabilities = capabilities});
}

const MethodCapabilities& capabilities_of(std::string_view method) { return method_named(method).capabilities; }

std::unique_ptr<Method> make_method(std::string_view name, const MethodSettings& settings) {
  return method_named(name).make(settings);
}

}  // namespace downrange
