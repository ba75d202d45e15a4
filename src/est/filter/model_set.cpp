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
      set.count = 3;
      set.model = {{{.noise = Noise::WhiteJerk, .q = 1e-6, .gravity_aware = true},   // ballistic
                    {.noise = Noise::WhiteJerk, .q = 0.3, .gravity_aware = true},    // thrust
                    {.noise = Noise::WhiteJerk, .q = 500, .gravity_aware = true}}};  // ignition, staging, cut-off
      set.rates << -.004, .002, .002, .002, -.004, .002, .25, .25, -.5;
      set.initial_probability << 0.05, 0.9, 0.05;
      set.ballistic = 0;
      break;
  }
  set.switching = switching_over(set, 0.2);
  return set;
}

}  // namespace downrange
