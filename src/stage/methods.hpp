#pragma once
/// Stages 2 and 3, ALIGN and FUSE: the configured methods side by side, fed with accepted observations. The first runs
/// as the chains of INTEGRITY.

#include <downrange/est/method/method.hpp>
#include <downrange/stage/event.hpp>
#include <downrange/stage/range_config.hpp>
#include <downrange/stage/result.hpp>
#include <downrange/stage/source_table.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stage/followed.hpp"
#include "stage/integrity/integrity_stage.hpp"
#include "stage/residuals.hpp"

namespace downrange {

/// Radars and trackers behind them, as the methods are told of them.
[[nodiscard]] std::vector<RadarModel> radar_models(const RangeConfig& config);

class Methods {
 public:
  /// `make_judge`: empty, nobody is judged.
  explicit Methods(const RangeConfig& config, const JudgeMaker& make_judge = {});

  /// Brings one accepted observation into every method; a double of a fix (Reason::Duplicate) to INTEGRITY alone.
  /// `in_flight`: the vehicle is known to have left its pad. `noise_held`: as of Measurement.
  void process(const Observation& o, bool in_flight, bool noise_held = false);

  /// ALIGN's results: the bias of the observation's radar or tracker, for each method that accepted the observation.
  void emit_biases(const Observation& o, ResultSink& sink) const;
  /// FUSE's results: the trajectory of the observation's target, for each method that accepted the observation and
  /// whose estimate it changed.
  void emit_trajectories(const Observation& o, ResultSink& sink);
  /// FUSE's results on the tick: every target and method, predicted to `tick`.
  void emit_trajectories_at(Time tick, ResultSink& sink) const;

  /// An operator's order: the bias of a radar or tracker begins anew with what it measures from then on.
  void reset_bias(SourceId sensor, Time from);

  /// INTEGRITY, with every tick before anything is asked for it: verdicts, selection, bound; with fuse.publish_chains
  /// the chains' trajectories.
  void judge(Time tick, const OperatorWill& will, ResultSink& sink);

  /// How far the sources are from the primary method's track.
  [[nodiscard]] const Residuals& residuals() const { return residuals_; }

  [[nodiscard]] const IntegrityStage& integrity() const { return integrity_; }
  /// By target: what SLAVE points by.
  [[nodiscard]] std::span<const Followed> followed() const { return followed_; }
  /// The same of one chain, by its name or Orders::whole_chain; nothing where there is no such chain. No bound: an
  /// operator asked for that one.
  [[nodiscard]] std::optional<Followed> on_chain(int target, const Name& chain) const;
  /// The first method on all sources: health reports its residuals.
  [[nodiscard]] const Method& primary() const { return integrity_.all().method(); }

 private:
  /// Of one target: the sources that are believed, each by itself.
  struct Lone {
    SourceSet excluded = 0;  ///< by INTEGRITY's newest record
    std::vector<LoneSource> sources;
  };
  class VerdictTap;
  struct Published {
    Time epoch;
    Vec<9> mean = Vec<9>::Zero();
  };
  struct Runner {
    Name name;
    std::unique_ptr<Method> method;    ///< null: the first, which INTEGRITY has
    std::vector<Published> published;  ///< per target
    bool accepted = false;             ///< the last observation
  };
  /// Whose trajectory it is.
  struct Author {
    Name method;
    Name chain{};
    bool primary = false;
    std::optional<double> bound_m{};
  };

  /// Whether `m` is the first of its sensor and target since an order to begin its bias anew.
  [[nodiscard]] bool is_first_after_reset(const Measurement& m);
  [[nodiscard]] Author author(const Runner& runner, int target) const;
  [[nodiscard]] std::optional<TrackEstimate> estimate(const Runner& runner, int target, std::optional<Time> at) const;
  void emit_trajectory(const Author& author, const TrackEstimate& estimate, int target, Time received,
                       ResultSink& sink) const;
  void emit_chains(Time tick, ResultSink& sink) const;
  void update_followed(SourceSet inhibited);

  RangeConfig config_;
  SourceTable sources_;
  IntegrityStage integrity_;
  std::vector<Runner> runners_;
  std::vector<Name> chain_methods_;  ///< what fuse.publish_chains calls the chains, the same for every target
  std::vector<Time> newest_;         ///< per target: measurement that the methods were given, used or not
  std::vector<std::optional<Time>> bias_reset_;  ///< by source, then target: ordered, and not carried out yet
  Residuals residuals_;
  std::optional<Time> liftoff_;  ///< as of the last tick
  std::vector<Lone> lone_;       ///< by target
  std::vector<Followed> followed_;
};

}  // namespace downrange
