#include <downrange/est/filter/imm.hpp>
#include <downrange/est/filter/model_set.hpp>

namespace downrange {

Mat<ModelSet::max_models, ModelSet::max_models> switching_over(const ModelSet& set, double dt) {
  return imm::switching_over<ModelSet::max_models>(set.rates, dt);
}

ModelSet constant_acceleration(const KinematicsSettings& settings) {
  ModelSet set;
  set.model[0] = {.noise = MotionModel::Noise::WhiteJerk, .q = settings.q_ca_m2_s5, .gravity_aware = false};
  return set;
}

namespace {

/// Of what a phase changes to, each of the two others is as likely.
ModelSet launch(const LaunchSettings& settings) {
  const auto white_jerk = [](double q) {
    return MotionModel{.noise = MotionModel::Noise::WhiteJerk, .q = q, .gravity_aware = true};
  };
  const double change = 1 / settings.phase_s;
  const double end = 1 / settings.event_s;
  ModelSet set;
  set.count = 3;
  set.model = {white_jerk(settings.q_ballistic_m2_s5), white_jerk(settings.q_thrust_m2_s5),
               white_jerk(settings.q_event_m2_s5)};
  set.rates << -change, change / 2, change / 2,  //
      change / 2, -change, change / 2,           //
      end / 2, end / 2, -end;
  set.initial_probability << settings.initial_ballistic, 1 - (settings.initial_ballistic + settings.initial_event),
      settings.initial_event;
  set.ballistic = 0;
  set.ballistic_sigma_m_s2 = settings.ballistic_sigma_m_s2;
  return set;
}

}  // namespace

ModelSet model_set(const KinematicsSettings& settings) {
  using Noise = MotionModel::Noise;
  ModelSet set;
  switch (settings.kinematics) {
    case Kinematics::Cv:
      set.model[0] = {.noise = Noise::WhiteAcceleration, .q = settings.q_cv_m2_s3, .gravity_aware = false};
      break;
    case Kinematics::Vdie:
      // Quiet: what accelerates more is to be detected, not to be taken for noise.
      set.model[0] = {.noise = Noise::WhiteAcceleration, .q = settings.q_cv_m2_s3 / 100, .gravity_aware = false};
      break;
    case Kinematics::Ca:
      return constant_acceleration(settings);
    case Kinematics::Launch:
      set = launch(settings.launch);
      break;
  }
  set.switching = switching_over(set, 0.2);
  return set;
}

}  // namespace downrange
