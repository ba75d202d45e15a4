#pragma once
/// Kinematics: one motion model, or several and how a vehicle changes between them.

#include <array>
#include <cstdint>
#include <downrange/est/model/motion_model.hpp>
#include <string_view>

namespace downrange {

/// How a vehicle moves between two measurements (est/THEORY.md section 2).
enum class Kinematics : std::uint8_t {
  Cv,      ///< white acceleration
  Ca,      ///< white jerk
  Launch,  ///< interacting models: ballistic, thrust, event; gravity and rotation of the Earth known
  Vdie,    ///< cv that opens an acceleration when input estimation detects a manoeuvre
};

inline constexpr std::array all_kinematics{Kinematics::Cv, Kinematics::Ca, Kinematics::Launch, Kinematics::Vdie};
/// As the configuration names it.
[[nodiscard]] constexpr std::string_view to_string(Kinematics kinematics) {
  constexpr std::array<std::string_view, all_kinematics.size()> names{"cv", "ca", "launch", "vdie"};
  static_assert(!names.back().empty(), "a name for each");
  return names.at(static_cast<std::size_t>(kinematics));
}

/// Of kinematics launch: its three models and how a flight changes between them (est/THEORY.md section 2).
struct LaunchSettings {
  double q_ballistic_m2_s5 = 1e-6;     ///< white jerk of a ballistic flight
  double ballistic_sigma_m_s2 = 0.01;  ///< its specific force, 1-sigma per axis about zero
  double q_thrust_m2_s5 = 0.3;         ///< white jerk under thrust
  double q_event_m2_s5 = 1000;         ///< white jerk during ignition, staging and cut-off
  double phase_s = 250;                ///< mean duration of a ballistic phase, and of thrust
  double event_s = 2;                  ///< mean duration of an event
  double initial_ballistic = 0.05;     ///< probability that a target is ballistic when its track starts
  double initial_event = 0.05;         ///< likewise in an event; else it is under thrust
};

struct KinematicsSettings {
  Kinematics kinematics = Kinematics::Launch;  ///< of joint and schmidt
  double q_cv_m2_s3 = 1000;                    ///< white acceleration of cv and vdie
  double q_ca_m2_s5 = 10;                      ///< white jerk of ca
  LaunchSettings launch;
};

/// The models of one kind of kinematics and how a vehicle changes between them.
struct ModelSet {
  static constexpr int max_models = 3;

  int count = 1;
  std::array<MotionModel, max_models> model{};
  /// Rates per second; row: from, column: to; rows sum to zero.
  Mat<max_models, max_models> rates = Mat<max_models, max_models>::Zero();
  /// Probabilities of these changes within 0.2 s, the interval of the models' interaction.
  Mat<max_models, max_models> switching = Mat<max_models, max_models>::Identity();
  Vec<max_models> initial_probability = Vec<max_models>::UnitX();
  /// A model whose specific force is 0 +- ballistic_sigma_m_s2; -1: none.
  int ballistic = -1;
  double ballistic_sigma_m_s2 = LaunchSettings{}.ballistic_sigma_m_s2;
};

[[nodiscard]] Mat<ModelSet::max_models, ModelSet::max_models> switching_over(const ModelSet& set, double dt);
[[nodiscard]] ModelSet model_set(const KinematicsSettings& settings);
/// The one model of constant acceleration: of kinematics ca, and of vdie while a manoeuvre lasts.
[[nodiscard]] ModelSet constant_acceleration(const KinematicsSettings& settings);

}  // namespace downrange
