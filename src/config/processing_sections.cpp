#include "config/sections.hpp"

#include <downrange/est/method/method.hpp>

#include "config/section.hpp"

namespace downrange::config {
namespace {

std::vector<std::pair<std::string_view, Kinematics>> kinematics_names() {
  std::vector<std::pair<std::string_view, Kinematics>> names;
  names.reserve(std::size(all_kinematics));
  for (const Kinematics kinematics : all_kinematics) names.emplace_back(to_string(kinematics), kinematics);
  return names;
}

std::string methods_help() {
  return "methods that run side by side, antennas are pointed by the first; known: " +
         show_texts({method_names().begin(), method_names().end()});
}

}  // namespace

Section ingest_section() {
  using I = IngestConfig;
  return single<I>("ingest", "Which input is let in.", [](ServiceConfig& c) -> I& { return c.range.ingest; },
                   {
                       span("max_future_ms", at(&I::max_future), {0, 60'000}, optional,
                            "an epoch later than its reception by more than this is rejected"),
                       flag("expect_simulated", at(&I::expect_simulated), optional,
                            "the 'simulated' flag that every input must carry: false in operations"),
                   });
}

Section align_section() {
  using A = AlignConfig;
  return single<A>(
      "align", "Estimation of the radars' biases.", [](ServiceConfig& c) -> A& { return c.range.align; },
      {
          flag("gps_error_states", at(&A::gps, &GpsSettings::error, &GpsErrorModel::enabled), optional,
               "the receiver's position has a slowly varying error that is estimated (joint, schmidt, ts)"),
          number("gps_error_sigma_m", at(&A::gps, &GpsSettings::error, &GpsErrorModel::sigma_m), {1e-3, 1e4}, optional,
                 "size of that error, 1-sigma per axis; rather too large than too small"),
          number("gps_error_tau_s", at(&A::gps, &GpsSettings::error, &GpsErrorModel::tau_s), {0.1, 1e5}, optional,
                 "correlation time of that error"),
          choice<A, bool>("gps_reference", at(&A::gps, &GpsSettings::alignment, &GpsAlignment::smooth),
                          {{"predict", false}, {"smooth", true}}, optional,
                          "GPS at a plot's epoch: predicted from the fixes before it, or smoothed by later ones, which "
                          "the plot waits for (schmidt, song2015, track-level rules)"),
          integer("smooth_fixes", at(&A::gps, &GpsSettings::alignment, &GpsAlignment::fixes), {1, 9}, optional,
                  "later fixes that a smoothed plot waits for"),
          flag("no_gps", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::enabled), optional,
               "until a target's first fix: smaller biases, wandering pointing (joint, schmidt, ts)"),
          number("no_gps_offset_prior_m", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::offset_prior_m), {1e-3, 1e5},
                 optional, "what an offset of range may be in that regime, 1-sigma"),
          number("no_gps_angle_prior_deg", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::angle_prior_rad), {1e-6, 20},
                 optional, "what an offset of an angle may be in that regime, 1-sigma"),
          number("no_gps_wander_deg",
                 at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::wander, &PointingWander::sigma_rad), {1e-6, 20},
                 optional, "slowly varying pointing error in that regime, 1-sigma"),
          number("no_gps_wander_tau_s", at(&A::gps, &GpsSettings::no_gps, &NoGpsRegime::wander, &PointingWander::tau_s),
                 {0.1, 1e5}, optional, "correlation time of that error"),
          number("offset_prior_m", at(&A::cartesian_bias, &CartesianBiasSettings::offset_prior_m), {0, 1e5}, optional,
                 "what an offset may be before any data, 1-sigma per axis (song2015, track-level rules)"),
          number("scale_prior", at(&A::cartesian_bias, &CartesianBiasSettings::scale_prior), {0, 1}, optional,
                 "what a scale error may be before any data, 1-sigma per axis (song2015, track-level rules)"),
          integer("window", at(&A::cartesian_bias, &CartesianBiasSettings::window), {0, 64}, optional,
                  "samples of the paper's windowed process noise; 0: none, drift only (song2015, track-level rules)"),
          number("offset_drift_m_sqrt_s", at(&A::cartesian_bias, &CartesianBiasSettings::offset_drift_m_sqrt_s),
                 {0, 1e4}, optional, "random walk of the offsets (song2015, track-level rules)"),
          number("scale_drift_sqrt_s", at(&A::cartesian_bias, &CartesianBiasSettings::scale_drift_sqrt_s), {0, 1},
                 optional, "random walk of the scales (song2015, track-level rules)"),
          number("gps_q_m2_s3", at(&A::cartesian_bias, &CartesianBiasSettings::gps_q_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of the GPS track (song2015, track-level rules)"),
          span("gps_max_age_ms", at(&A::gps, &GpsSettings::max_age), {1, 600'000}, optional,
               "with GPS older than this, biases are kept, not updated"),
      });
}

Section fuse_section() {
  using F = FuseConfig;
  const auto launch = [](const std::string& name, double LaunchSettings::*member, Limits limits, const char* help) {
    return number("launch_" + name, at(&F::motion, &KinematicsSettings::launch, member), limits, optional,
                  std::string(help) + " (kinematics launch)");
  };
  return single<F>(
      "fuse", "The trajectory.", [](ServiceConfig& c) -> F& { return c.range.fuse; },
      {
          ids("methods", at(&F::methods), optional, methods_help()),
          span("history_s", at(&F::arbitration, &ArbitrationSettings::history), {0, 600}, optional,
               "how late a measurement may come"),
          choice<F, Kinematics>("kinematics", at(&F::motion, &KinematicsSettings::kinematics), kinematics_names(),
                                optional, "how a vehicle moves (joint, schmidt)"),
          number("q_cv_m2_s3", at(&F::motion, &KinematicsSettings::q_cv_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of cv and vdie"),
          number("q_ca_m2_s5", at(&F::motion, &KinematicsSettings::q_ca_m2_s5), {1e-6, 1e9}, optional,
                 "white jerk density of ca, of vdie while a manoeuvre lasts, of the targets of ts and of schmidt's GPS "
                 "track"),
          launch("q_ballistic_m2_s5", &LaunchSettings::q_ballistic_m2_s5, {1e-12, 1e9},
                 "white jerk density of a ballistic flight"),
          launch("ballistic_sigma_m_s2", &LaunchSettings::ballistic_sigma_m_s2, {1e-6, 100},
                 "specific force of a ballistic flight, 1-sigma per axis"),
          launch("q_thrust_m2_s5", &LaunchSettings::q_thrust_m2_s5, {1e-12, 1e9}, "white jerk density under thrust"),
          launch("q_event_m2_s5", &LaunchSettings::q_event_m2_s5, {1e-12, 1e9},
                 "white jerk density during ignition, staging and cut-off"),
          launch("phase_s", &LaunchSettings::phase_s, {1, 1e5}, "mean duration of ballistic flight, and of thrust"),
          launch("event_s", &LaunchSettings::event_s, {0.1, 1000}, "mean duration of ignition, staging or cut-off"),
          launch("initial_ballistic", &LaunchSettings::initial_ballistic, {0.001, 0.49},
                 "probability that a target is ballistic when its track starts"),
          launch("initial_event", &LaunchSettings::initial_event, {0.001, 0.49},
                 "probability that a target is in such an event when its track starts; else it is under thrust"),
          span("batch_ms", at(&F::cartesian_fusion, &CartesianFusionSettings::batch), {1, 10'000}, optional,
               "fusion interval of song2015 and federated on the UTC grid; a multiple of range.tick_ms"),
          number("q_m2_s3", at(&F::cartesian_fusion, &CartesianFusionSettings::q_m2_s3), {1e-6, 1e9}, optional,
                 "white acceleration density of the track (song2015, track-level rules)"),
          number("alpha_beta_acceleration_m_s2", at(&F::quick_look, &QuickLookSettings::acceleration_m_s2), {1e-3, 1e5},
                 optional, "acceleration between two plots of a radar, 1-sigma per axis (alpha-beta)"),
          number("gate_probability", at(&F::arbitration, &ArbitrationSettings::gate_probability), {0.5, 0.999999999},
                 optional, "share of good measurements that pass the gate"),
          flag("adaptive_noise", at(&F::noise, &AdaptiveNoiseSettings::enabled), optional,
               "the noise of each source is learnt in flight, from the sigma configured to a fifth and ten times of it "
               "(joint, schmidt, ts)"),
          span("restart_after_s", at(&F::arbitration, &ArbitrationSettings::restart_after), {0.1, 600}, optional,
               "a track of which no source's measurement was accepted for so long starts anew"),
          integer("reopen_after", at(&F::arbitration, &ArbitrationSettings::reopen_after), {1, 1'000'000}, optional,
                  "rejections in a row after which a radar's bias is opened again, while other sources are accepted"),
          number("initial_sigma_velocity_m_s", at(&F::start, &StartSettings::sigma_velocity_m_s), {0.1, 1e5}, optional,
                 "velocity 1-sigma per axis of a track's first estimate"),
          number("initial_sigma_acceleration_m_s2", at(&F::start, &StartSettings::sigma_acceleration_m_s2), {0.01, 1e4},
                 optional, "acceleration 1-sigma per axis of a track's first estimate (ca, launch)"),
          flag("publish_on_data", at(&F::publish_on_data), optional,
               "true: a trajectory with each measurement; false: on the tick"),
          span("stale_ms", at(&F::stale), {1, 600'000}, optional,
               "with the newest measurement older than this, a trajectory is coasting"),
          span("coast_ms", at(&F::coast), {1, 600'000}, optional,
               "with the newest measurement older than this, there is no trajectory on the tick"),
          flag("publish_chains", at(&F::publish_chains), optional,
               "the trajectories of INTEGRITY's chains as well, ten times a second: METHOD/without-NAME, "
               "METHOD/only-NAME"),
      });
}

Section integrity_section() {
  using I = IntegrityConfig;
  return single<I>(
      "integrity", "Which sources are believed.", [](ServiceConfig& c) -> I& { return c.range.integrity; },
      {
          flag("enabled", at(&I::enabled), optional,
               "judge the sources of a target against each other, where there are two or more"),
          integer("rerun_per_tick", at(&I::rerun_per_tick), {1, 100'000}, optional,
                  "measurements with each tick by which a run without a liar catches up"),
          ids("trust", at(&I::trust), optional,
              "whom to believe where two sources contradict each other and nothing tells who lies: ids of "
              "radars, trackers, stations or receivers, the most trusted first; empty: neither is excluded"),
          number("copy_position_m", at(&I::copy_position_m), {1e-6, 1e5}, optional,
                 "copies of one fix by several stations differ by no more than what the wire rounds"),
          number("copy_velocity_m_s", at(&I::copy_velocity_m_s), {1e-6, 1e4}, optional, "likewise"),
          span("readmit_after_s", at(&I::readmit_after), {0.1, 3600}, optional,
               "an excluded source is believed again when it has agreed for so long"),
      });
}

Section slave_section() {
  using S = SlaveConfig;
  return single<S>(
      "slave", "Pointing of the antennas.", [](ServiceConfig& c) -> S& { return c.range.slave; },
      {
          span("stale_ms", at(&S::stale), {1, 600'000}, optional,
               "with the newest measurement older than this, a command is made of a coasting track"),
          span("coast_ms", at(&S::coast), {1, 600'000}, optional, "coasting longer than this ends the commands"),
          number("coast_sigma_max_m", at(&S::coast_sigma_max_m), {1, 1e7}, optional,
                 "position 1-sigma above which coasting ends as well"),
          span("validity_ms", at(&S::validity), {1, 60'000}, optional, "how long a command holds after its instant"),
          number("blend_rate_deg_s", at(&S::blend_rate_rad_s), {1e-3, 360}, optional,
                 "how fast commands go over to another chain of sources, on the sky, beside the target's own motion"),
          number("beam_probability_min", at(&S::beam_probability_min), {0, 0.99}, optional,
                 "coasting ends where the target is in the beam with less than this probability; of antennas with "
                 "beamwidth_deg, which may coast for up to a minute beyond coast_ms where no other source is left"),
          number("coast_bound_max_deg", at(&S::coast_bound_max_rad), {1e-3, 180}, optional,
                 "likewise beyond coast_ms, where one lying source can have moved the pointing by more than this"),
          number("nominal_sigma_m", at(&S::nominal_sigma_m), {1, 1e6}, optional,
                 "how far a vehicle may be from its nominal trajectory, 1-sigma per axis, at its begin"),
          number("nominal_sigma_share", at(&S::nominal_sigma_share), {0, 1}, optional,
                 "and what is added to that, as a share of the way from there"),
      });
}

}  // namespace downrange::config
