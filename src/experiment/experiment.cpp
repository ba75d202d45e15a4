#include "experiment/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace downrange::experiment {
namespace {

constexpr int digits_of_limit = 3;

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

std::string number_text(double value, int digits) {
  const double magnitude = std::abs(value);
  char buffer[40];
  if (value == 0) return "0";
  if (!std::isfinite(value)) return "-";
  if (magnitude >= 1e-3 && magnitude < 99999.5) {
    std::snprintf(buffer, sizeof buffer, "%#.*g", digits, value);
    std::string text = buffer;
    if (text.find('e') != std::string::npos) {  // more digits before the point than asked for
      std::snprintf(buffer, sizeof buffer, "%.0f", value);
      text = buffer;
    }
    if (text.back() == '.') text.pop_back();
    return text;
  }
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
  std::string text = buffer;
  const std::size_t exponent = text.find('e');
  if (exponent == std::string::npos) return text;
  std::size_t zeros = exponent + 2;  // behind the sign
  while (zeros + 1 < text.size() && text[zeros] == '0') text.erase(zeros, 1);
  if (text[exponent + 1] == '+') text.erase(exponent + 1, 1);
  return text;
}

// Comparisons are written so that a figure that is not a number is not reached.
Figure at_most(std::string what, double measured, double limit) {
  return {std::move(what), measured, "<= " + number_text(limit, digits_of_limit), measured <= limit};
}

Figure at_least(std::string what, double measured, double limit) {
  return {std::move(what), measured, ">= " + number_text(limit, digits_of_limit), measured >= limit};
}

Figure within(std::string what, double measured, double low, double high) {
  return {std::move(what), measured, number_text(low, digits_of_limit) + " .. " + number_text(high, digits_of_limit),
          low <= measured && measured <= high};
}

Figure shown(std::string what, double measured) { return {std::move(what), measured, "", true}; }

std::string runs_text(const ExperimentResult& result) {
  if (result.runs == 0) return "recorded data, nothing drawn";
  return std::to_string(result.runs) + (result.runs == 1 ? " run" : " runs") + ", seed " + std::to_string(result.seed);
}

bool all_reached(const ExperimentResult& result) {
  return std::all_of(result.figures.begin(), result.figures.end(), [](const Figure& f) { return f.reached; });
}

std::vector<std::string> chosen_methods(const std::vector<std::string>& asked,
                                        const std::vector<std::string>& compared) {
  if (asked.empty()) return compared;
  for (const std::string& name : asked) {
    if (std::find(compared.begin(), compared.end(), name) == compared.end())
      throw std::invalid_argument("method '" + name + "' is not compared here: allowed are " + joined(compared));
  }
  std::vector<std::string> chosen;
  std::copy_if(compared.begin(), compared.end(), std::back_inserter(chosen), [&asked](const std::string& name) {
    return std::find(asked.begin(), asked.end(), name) != asked.end();
  });
  return chosen;
}

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all{
      {"launch",
       "two radars and GPS on a launch (song2015): bias, position, consistency against the bound",
       300,
       {"joint-ca", "joint-launch", "schmidt", "song2015", "uncorrected"},
       run_launch},
      {"kim2011",
       "biases of two radars without GPS, from 32 targets",
       400,
       {"pm", "pm-scaled", "exx", "ts"},
       run_kim2011},
      {"federated",
       "a target that manoeuvres, two sensors: filters that share information and filters that notice",
       500,
       {"centralised", "federated", "information", "decentralised", "vdie", "imm"},
       run_federated},
      {"spatial",
       "bearings of displaced sensors: parallax and track fusion by rule",
       1000,
       {"reference", "convex", "bar-shalom-campo", "map", "information"},
       run_spatial},
      {"alphabeta",
       "alpha-beta gains: exact, linear about the nominal, fixed",
       500,
       {"exact", "linear", "fixed"},
       run_alphabeta},
      {"noise",
       "every sigma configured a third, right and three times: noise learnt in flight, and not",
       40,
       {"joint", "schmidt", "ts", "joint-fixed"},
       run_noise},
  };
  return all;
}

}  // namespace downrange::experiment
