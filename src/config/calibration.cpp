#include "config/calibration.hpp"

#include <toml++/toml.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>

#include "config/section.hpp"

namespace downrange::config {
namespace {

constexpr const char* header =
    "# What a flight found of its sensors' biases: measured = true + bias. It becomes a sensor's prior with\n"
    "# calibration = \"FILE\" in its [[radar]] or [[angle_sensor]]. A single term is often not the error of the "
    "hardware,\n"
    "# for terms that act alike are not told apart: value and correlation hold together. The sigma of a term that "
    "could\n"
    "# not be observed is the one from before the flight.\n";

/// Suffix of a term's keys: its unit.
std::string suffix_of(BiasTerm term) {
  switch (term) {
    case BiasTerm::OffsetSouth:
    case BiasTerm::OffsetEast:
    case BiasTerm::OffsetZenith:
    case BiasTerm::OffsetRange:
      return "_m";
    case BiasTerm::OffsetAzimuth:
    case BiasTerm::OffsetElevation:
      return "_deg";
    case BiasTerm::TimeTag:
      return "_ms";
    default:
      return "";
  }
}

std::vector<std::pair<std::string_view, BiasTerm>> term_names() {
  std::vector<std::pair<std::string_view, BiasTerm>> names;
  for (int i = 0; i < bias_term_count; ++i) {
    const auto term = static_cast<BiasTerm>(i);
    names.emplace_back(to_string(term), term);
  }
  return names;
}

std::vector<std::pair<std::string_view, BiasState>> state_names() {
  std::vector<std::pair<std::string_view, BiasState>> names;
  for (const BiasState state :
       {BiasState::Estimating, BiasState::Converged, BiasState::NotObservable, BiasState::Frozen})
    names.emplace_back(to_string(state), state);
  return names;
}

std::string_view name_of(BiasReference reference) {
  static constexpr std::array<std::string_view, 3> names{"none", "gps", "cross_radar"};
  return names.at(static_cast<std::size_t>(reference));
}

/// Shortest digits that read back as the same number.
std::string exact(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

std::string date_time(Time t) {
  const std::chrono::sys_time<std::chrono::nanoseconds> instant{std::chrono::nanoseconds(t.ns)};
  const auto day = std::chrono::floor<std::chrono::days>(instant);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(instant - day);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%09dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                static_cast<int>(time.seconds().count()), static_cast<int>(time.subseconds().count()));
  return text.data();
}

Eigen::MatrixXd covariance_of(const SensorBias& bias) {
  Eigen::MatrixXd cov(bias.terms, bias.terms);
  std::size_t k = 0;
  for (int row = 0; row < bias.terms; ++row) {
    for (int column = row; column < bias.terms; ++column) cov(row, column) = cov(column, row) = bias.covariance[k++];
  }
  return cov;
}

std::string sensor_text(const CalibratedSensor& sensor) {
  const std::string list(to_string(sensor.kind));
  const SensorBias& bias = sensor.bias;
  const Eigen::MatrixXd cov = covariance_of(bias);
  const Eigen::VectorXd sigma = cov.diagonal().cwiseSqrt();
  std::string text = "\n[[" + list + "]]\nid = " + show_text(bias.sensor.view()) +
                     "\nepoch = " + date_time(bias.epoch) +
                     "  # newest plot behind it\nsamples = " + std::to_string(bias.samples) +
                     "\nreference = " + show_text(name_of(bias.reference)) + "\ncorrelation = [\n";
  for (int row = 0; row < bias.terms; ++row) {
    text += "  [";
    for (int column = 0; column < bias.terms; ++column) {
      const double r = row == column ? 1 : cov(row, column) / (sigma[row] * sigma[column]);
      text += (column == 0 ? "" : ", ") + exact(r);
    }
    text += "],\n";
  }
  text += "]\n";
  const std::string noise = learnt_noise(sensor.kind, sensor.sigma_ratio);
  if (!noise.empty()) text += "# Its noise, over the sigma configured: " + noise + '\n';
  for (int i = 0; i < bias.terms; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::string suffix = suffix_of(bias.term[k]);
    const double to_si = unit_of(suffix).to_si;
    text += "\n[[" + list + ".term]]\nterm = " + show_text(to_string(bias.term[k])) + "\nvalue" + suffix + " = " +
            exact(bias.value[k] / to_si) + "\nsigma" + suffix + " = " + exact(sigma[i] / to_si) +
            "\nstate = " + show_text(to_string(bias.state[k])) + '\n';
  }
  return text;
}

struct Term {
  BiasTerm term = BiasTerm::OffsetRange;
  BiasState state = BiasState::Estimating;
  double value = 0;
  double sigma = 0;
};

std::optional<Term> read_term(const toml::table& table, const std::string& path, const Report& report) {
  bool good = true;
  const Report watch = [&](const toml::node* node, const std::string& key, const std::string& message) {
    good = false;
    report(node, key, message);
  };
  Term term;
  std::vector<Key<Term>> keys{
      choice<Term, BiasTerm>("term", at(&Term::term), term_names(), required, "which term"),
      choice<Term, BiasState>("state", at(&Term::state), state_names(), optional, "what the flight showed of it")};
  // The unit, and with it the names of the other keys, is the term's.
  const toml::node* named = table.get("term");
  if (named != nullptr) {
    good = keys[0].read(term, *named);
    if (good) {
      const std::string suffix = suffix_of(term.term);
      keys.push_back(number("value" + suffix, at(&Term::value), {-1e9, 1e9}, required, "the bias"));
      keys.push_back(number("sigma" + suffix, at(&Term::sigma), {1e-12, 1e9}, required, "its 1-sigma"));
    }
  }
  std::vector<KeyInfo> infos;
  for (const Key<Term>& key : keys) infos.push_back(key.info);
  if (good) check_key_names(infos, table, path, watch);
  read_keys(keys, term, table, path, watch);
  if (!good) return std::nullopt;
  return term;
}

/// Nothing when it is no symmetric, positive definite n x n matrix with ones on its diagonal.
std::optional<Eigen::MatrixXd> read_correlation(const toml::node& node, Eigen::Index n) {
  const toml::array* rows = node.as_array();
  if (rows == nullptr || static_cast<Eigen::Index>(rows->size()) != n) return std::nullopt;
  Eigen::MatrixXd r(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const toml::array* row = rows->get(static_cast<std::size_t>(i))->as_array();
    if (row == nullptr || static_cast<Eigen::Index>(row->size()) != n) return std::nullopt;
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto value = read_number(*row->get(static_cast<std::size_t>(j)), {-1, 1});
      if (!value) return std::nullopt;
      r(i, j) = *value;
    }
  }
  const bool ones = (r.diagonal().array() == 1).all();
  if (!ones || r != r.transpose() || r.llt().info() != Eigen::Success) return std::nullopt;
  return r;
}

/// Where the bias comes from: told to people, not used.
void check_origin_of_bias(const toml::table& table, const std::string& path, const Report& report) {
  const auto require = [&](const char* key, bool good, const char* allowed) {
    if (table.contains(key) && !good)
      report(table.get(key), path + '.' + key,
             "found " + show_found(*table.get(key)) + ", allowed: " + std::string(allowed));
  };
  require("epoch", table["epoch"].is_date_time(), "a date and time such as 2026-03-01T08:00:00Z");
  require("samples", table["samples"].is_integer(), "a whole number");
  require("reference", table["reference"].is_string(), "text");
}

}  // namespace

std::string calibration_text(const CalibrationOrigin& origin, std::span<const CalibratedSensor> sensors) {
  std::string text = header;
  text += "\n[origin]\narchive = " + show_text(origin.archive) +
          "\nconfiguration = " + show_text(origin.configuration) +
          "  # SHA-256\nmethod = " + show_text(sensors.empty() ? "" : sensors.front().bias.method.view()) + '\n';
  for (const CalibratedSensor& sensor : sensors) text += sensor_text(sensor);
  return text;
}

std::optional<BiasCalibration> read_calibration(const toml::table& table, const std::string& path,
                                                const Report& report) {
  bool good = true;
  const Report watch = [&](const toml::node* node, const std::string& key, const std::string& message) {
    good = false;
    report(node, key, message);
  };
  check_key_names({{"id", std::string(allowed_id), required, "the sensor"},
                   {"epoch", "a date and time", optional, ""},
                   {"samples", "a whole number", optional, ""},
                   {"reference", "text", optional, ""},
                   {"correlation", "a matrix as a list of rows", required, "of the terms, in their order"},
                   {"term", "one or more tables", required, "one per term of the bias"}},
                  table, path, watch);
  check_origin_of_bias(table, path, watch);

  std::vector<Term> terms;
  const toml::array* list = table["term"].as_array();
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const toml::node& node = *list->get(i);
    const std::string at_term = path + ".term[" + std::to_string(i) + ']';
    if (const toml::table* entry = node.as_table()) {
      if (const auto term = read_term(*entry, at_term, watch)) terms.push_back(*term);
    } else {
      watch(&node, at_term, "found " + show_found(node) + ", allowed: a table");
    }
    if (good && std::ranges::count(terms, terms.back().term, &Term::term) > 1)
      watch(&node, at_term + ".term", "found " + show_text(to_string(terms.back().term)) + " twice, allowed: once");
  }
  if (const toml::node* node = table.get("term"); node != nullptr && (list == nullptr || list->empty()))
    watch(node, path + ".term", "found " + show_found(*node) + ", allowed: one or more tables");
  if (!good) return std::nullopt;

  const auto n = static_cast<Eigen::Index>(terms.size());
  const auto correlation = read_correlation(*table.get("correlation"), n);
  if (!correlation) {
    watch(table.get("correlation"), path + ".correlation",
          "found " + show_found(*table.get("correlation")) + ", allowed: " + std::to_string(n) + " rows of " +
              std::to_string(n) + " numbers from -1 to 1, symmetric, positive definite, 1 on the diagonal");
    return std::nullopt;
  }
  BiasCalibration calibration;
  calibration.mean.resize(n);
  calibration.cov.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Term& term = terms[static_cast<std::size_t>(i)];
    calibration.terms.push_back(term.term);
    calibration.mean[i] = term.value;
    for (Eigen::Index j = 0; j < n; ++j)
      calibration.cov(i, j) = (*correlation)(i, j) * (term.sigma * terms[static_cast<std::size_t>(j)].sigma);
  }
  return calibration;
}

}  // namespace downrange::config
