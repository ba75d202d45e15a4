#pragma once
/// Every method of the table with every setting that changes what it runs: what the suites of all methods run over.

#include <downrange/est/method/method_table.hpp>
#include <string>
#include <vector>

namespace downrange::test {

struct MethodCase {
  std::string label;  ///< letters, digits and underscores, as GoogleTest wants it
  std::string method;
  Kinematics kinematics = Kinematics::Launch;
  bool smooth = false;         ///< GPS smoothed by later fixes
  bool partial_plots = false;  ///< it uses plots that lack range or angles
  bool range_rate = false;     ///< it uses that
};

inline std::vector<MethodCase> method_cases() {
  std::vector<MethodCase> cases;
  for (const std::string_view name : method_names()) {
    const MethodCapabilities& capabilities = capabilities_of(name);
    for (const Kinematics kinematics : all_kinematics) {
      const bool own = capabilities.kinematics == 0;
      if (own ? kinematics != Kinematics::Launch : !capabilities.allows(kinematics)) continue;
      for (const bool smooth : {false, true}) {
        if (smooth && !capabilities.smoothed_gps) continue;
        std::string label(name);
        for (char& c : label) c = c == '-' ? '_' : c;
        if (!own) label += "_" + std::string(to_string(kinematics));
        if (smooth) label += "_smooth";
        cases.push_back(
            {label, std::string(name), kinematics, smooth, capabilities.partial_plots, capabilities.range_rate});
      }
    }
  }
  return cases;
}

}  // namespace downrange::test
