#pragma once
/// How a method of one's own gets into the table that `make_method` and the configuration read: its program registers
/// it, nothing here needs to know it (tools/examples/own_method.cpp).

#include <downrange/est/method/method.hpp>
#include <downrange/est/method/method_state.hpp>
#include <downrange/est/method/rewind.hpp>
#include <memory>
#include <optional>
#include <string_view>

namespace downrange {

/// An estimator behind the contract of a method: its state is kept in order whatever the order of arrival. `Core` is
/// what Rewinder asks for, and answers fused and bias of a state as Method does; gps_track where it has a track by GPS
/// alone; account where its state does not hold `accounts`, one per source.
template <class Core>
class RewoundMethod final : public Method, public RestorableMethod {
 public:
  explicit RewoundMethod(const Core& core) : rewinder_(core, core.initial(), core.settings().arbitration.history) {}

  void start(int target, Time epoch, const Gaussian<9>& estimate) override { rewinder_.start(target, epoch, estimate); }
  Outcome process(const Measurement& m, Time now) override { return rewinder_.process(m, now); }
  std::optional<TrackEstimate> fused(int target, std::optional<Time> at) const override {
    return core().fused(state(), target, at);
  }
  std::optional<TrackEstimate> gps_track(int target, Time at) const override {
    if constexpr (requires { core().gps_track(state(), target, at); }) return core().gps_track(state(), target, at);
    return std::nullopt;
  }
  BiasEstimate bias(int radar) const override { return core().bias(state(), radar); }
  const SourceAccount& account(int source) const override {
    if constexpr (requires { core().account(state(), source); }) {
      return core().account(state(), source);
    } else {
      return state().accounts[static_cast<std::size_t>(source)];
    }
  }

  std::unique_ptr<MethodState> make_state() const override { return std::make_unique<Held>(rewinder_.roomy_state()); }
  void save(Time before, MethodState& state) const override {
    rewinder_.state_before(before, dynamic_cast<Held&>(state).value);
  }
  void restore(const MethodState& state) override { rewinder_.restart(dynamic_cast<const Held&>(state).value); }

 private:
  using Held = HeldState<typename Core::State>;

  const Core& core() const { return rewinder_.core(); }
  const typename Core::State& state() const { return rewinder_.state(); }

  Rewinder<Core> rewinder_;
};

template <class Core>
std::unique_ptr<Method> rewound(const Core& core) {
  return std::make_unique<RewoundMethod<Core>>(core);
}

/// Makes a method for one engine. Same settings, same method.
using MethodMaker = std::unique_ptr<Method> (*)(const MethodSettings& settings);

/// What a method takes. A configuration that asks it for more radars or other kinematics is refused, as is one that
/// asks for kinematics or smoothed GPS where no method takes them; of keys for what none does (below) `check` warns.
struct MethodCapabilities {
  int most_radars = 64;
  unsigned kinematics = 0;       ///< `bit_of` each that fuse.kinematics may name; 0: it has its own
  bool smoothed_gps = false;     ///< align.gps_reference = "smooth" means something to it
  bool partial_plots = false;    ///< uses range alone, angles alone (of trackers too), a receiver alone; else not
  bool bias_blocks = false;      ///< finds the biases that a radar's bias_blocks name; else it has its own
  bool wander = false;           ///< has states for a mount's wander
  bool range_rate = false;       ///< uses it
  bool adaptive_noise = false;   ///< learns the scale of each source's noise
  bool white_jerk = false;       ///< moves its targets or its GPS track with white jerk, whatever fuse.kinematics names
  bool batch = false;            ///< fuses the plots of fuse.batch_ms at once
  bool cartesian_bias = false;   ///< finds biases of its own in Cartesian axes: AlignConfig::cartesian_bias
  bool cartesian_track = false;  ///< its track and the one of its fixes move by fuse.q_m2_s3 and align.gps_q_m2_s3
  bool quick_look = false;       ///< tracks by fuse.alpha_beta_acceleration_m_s2
  bool gps_regimes = false;      ///< estimates a receiver's slow error; has a regime until the first fixes (no_gps)

  [[nodiscard]] static constexpr unsigned bit_of(Kinematics kinematics) {
    return 1U << static_cast<unsigned>(kinematics);
  }
  [[nodiscard]] constexpr bool allows(Kinematics wanted) const {
    return kinematics == 0 || (kinematics & bit_of(wanted)) != 0;
  }
};

/// Of a method in `method_names`; throws std::invalid_argument for another.
[[nodiscard]] const MethodCapabilities& capabilities_of(std::string_view method);

/// Adds a method behind those that are known, in the order of the calls. Call it from main(), before a configuration is
/// read or an engine made, and from one thread: the table is the same for all engines of the process.
///
/// `name` is what fuse.methods says: 1 to 31 of A-Z a-z 0-9 . _ -. Throws std::invalid_argument for another, and for
/// one that is taken.
void register_method(std::string_view name, MethodMaker make, const MethodCapabilities& capabilities = {});

}  // namespace downrange
