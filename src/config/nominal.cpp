#include "config/nominal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <downrange/geo/site.hpp>
#include <numbers>

#include "text/printable.hpp"

namespace downrange::config {
namespace {

/// What a column says.
enum class Column : std::uint8_t { Time, X, Y, Z, Vx, Vy, Vz, Latitude, Longitude, Height, Object, Ignored };
constexpr std::size_t value_count = 10;

struct ColumnUnit {
  std::string_view name;
  Column column;
  double to_si;
};
constexpr double deg = std::numbers::pi / 180;
constexpr double ft = 0.3048;
constexpr std::array known{ColumnUnit{"t_s", Column::Time, 1},
                           ColumnUnit{"t_ms", Column::Time, 1e-3},
                           ColumnUnit{"t_min", Column::Time, 60},
                           ColumnUnit{"x_m", Column::X, 1},
                           ColumnUnit{"x_km", Column::X, 1e3},
                           ColumnUnit{"x_ft", Column::X, ft},
                           ColumnUnit{"y_m", Column::Y, 1},
                           ColumnUnit{"y_km", Column::Y, 1e3},
                           ColumnUnit{"y_ft", Column::Y, ft},
                           ColumnUnit{"z_m", Column::Z, 1},
                           ColumnUnit{"z_km", Column::Z, 1e3},
                           ColumnUnit{"z_ft", Column::Z, ft},
                           ColumnUnit{"vx_m_s", Column::Vx, 1},
                           ColumnUnit{"vx_km_s", Column::Vx, 1e3},
                           ColumnUnit{"vx_ft_s", Column::Vx, ft},
                           ColumnUnit{"vy_m_s", Column::Vy, 1},
                           ColumnUnit{"vy_km_s", Column::Vy, 1e3},
                           ColumnUnit{"vy_ft_s", Column::Vy, ft},
                           ColumnUnit{"vz_m_s", Column::Vz, 1},
                           ColumnUnit{"vz_km_s", Column::Vz, 1e3},
                           ColumnUnit{"vz_ft_s", Column::Vz, ft},
                           ColumnUnit{"latitude_deg", Column::Latitude, deg},
                           ColumnUnit{"latitude_rad", Column::Latitude, 1},
                           ColumnUnit{"longitude_deg", Column::Longitude, deg},
                           ColumnUnit{"longitude_rad", Column::Longitude, 1},
                           ColumnUnit{"height_m", Column::Height, 1},
                           ColumnUnit{"height_km", Column::Height, 1e3},
                           ColumnUnit{"height_ft", Column::Height, ft},
                           ColumnUnit{"object", Column::Object, 1},
                           ColumnUnit{"-", Column::Ignored, 1}};

/// A plan is on or above the Earth, and no plan leaves it at twice the speed that this takes.
constexpr double least_radius_m = 6.3e6;
constexpr double most_radius_m = 1e9;
constexpr double most_speed_m_s = 22'000;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::vector<std::string_view> split(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(delimiter, at), line.size());
    fields.push_back(trimmed(line.substr(at, end - at)));
    at = end + 1;
  }
  return fields;
}

std::optional<double> number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

class Reader {
 public:
  Reader(const NominalFormat& format, const NominalProblem& problem) : format_(format), problem_(problem) {}

  std::optional<NominalTrajectory> run(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    for (std::size_t at = 0; at < text.size() && good_;) {
      const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
      ++line_;
      take_line(text.substr(at, end - at));
      at = end + (text.substr(end).starts_with("\r\n") ? 2 : 1);
    }
    line_ = 0;
    if (good_ && columns_.empty()) fail("no line of column names; " + nominal_columns_help());
    if (good_) check_samples();
    if (!good_) return std::nullopt;
    return NominalTrajectory(has(Column::Vx) ? std::move(samples_) : with_velocities(std::move(samples_)));
  }

 private:
  void fail(const std::string& message) {
    good_ = false;
    problem_(line_, message);
  }
  [[nodiscard]] bool has(Column column) const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const ColumnUnit* c) { return c->column == column; });
  }

  void take_line(std::string_view line) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) return;
    if (columns_.empty()) {
      const std::size_t mark = line.find_first_of(",;\t");
      delimiter_ = mark == std::string_view::npos ? ',' : line[mark];
      const auto fields = split(line, delimiter_);
      if (format_.columns.empty()) return take_columns({fields.begin(), fields.end()});
      take_columns(format_.columns);
      // A line of the file's own names is passed over.
      if (good_ && std::none_of(fields.begin(), fields.end(), [](std::string_view f) { return number(f).has_value(); }))
        return;
    }
    if (good_) take_row(split(line, delimiter_));
  }

  void take_columns(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      const auto* found = std::find_if(known.begin(), known.end(), [&](const ColumnUnit& k) { return k.name == name; });
      if (found == known.end()) {
        return fail("column " + text::in_quotes(name) + " is not known; " + nominal_columns_help() +
                    "; or nominal_columns names the columns in their order, \"-\" for what is not read");
      }
      if (found->column != Column::Ignored && has(found->column))
        return fail("column " + text::in_quotes(name) + " is there twice");
      columns_.push_back(found);
    }
    const auto all = [&](std::initializer_list<Column> group) {
      return std::all_of(group.begin(), group.end(), [&](Column c) { return has(c); });
    };
    const bool ecef = all({Column::X, Column::Y, Column::Z});
    const bool any_velocity = has(Column::Vx) || has(Column::Vy) || has(Column::Vz);
    if (!has(Column::Time) || ecef == all({Column::Latitude, Column::Longitude, Column::Height}))
      return fail("needs a column of time, and either three of Earth-fixed or three of geodetic position; " +
                  nominal_columns_help());
    if (any_velocity && !all({Column::Vx, Column::Vy, Column::Vz})) fail("has only some of vx, vy, vz");
  }

  void take_row(const std::vector<std::string_view>& fields) {
    if (fields.size() < columns_.size())
      return fail(std::to_string(fields.size()) + " fields instead of " + std::to_string(columns_.size()));
    std::array<double, value_count> value{};
    std::string_view object;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i]->column == Column::Object) object = fields[i];
      if (columns_[i]->column >= Column::Object) continue;
      const auto found = number(fields[i]);
      if (!found) return fail(std::string(columns_[i]->name) + ": " + text::in_quotes(fields[i]) + " is not a number");
      value[static_cast<std::size_t>(columns_[i]->column)] = *found * columns_[i]->to_si;
    }
    if (!wanted(object)) return;
    if (samples_.size() == max_nominal_samples)
      return fail("more than " + std::to_string(max_nominal_samples) +
                  " samples: fewer will do, the motion between them is interpolated");
    add_sample(value);
  }

  bool wanted(std::string_view object) {
    if (!has(Column::Object)) return true;
    if (std::find(objects_.begin(), objects_.end(), object) == objects_.end() && objects_.size() < 20)
      objects_.emplace_back(object);
    return object == format_.object;
  }

  void add_sample(const std::array<double, value_count>& value) {
    const auto of = [&](Column c) { return value[static_cast<std::size_t>(c)]; };
    NominalSample sample;
    sample.t_s = of(Column::Time);
    if (has(Column::Latitude)) {
      if (std::abs(of(Column::Latitude)) > std::numbers::pi / 2) return fail("latitude beyond a pole");
      sample.state.position = ecef_from_geodetic({of(Column::Latitude), of(Column::Longitude), of(Column::Height)});
    } else {
      sample.state.position.m = {of(Column::X), of(Column::Y), of(Column::Z)};
    }
    sample.state.velocity.m_s = {of(Column::Vx), of(Column::Vy), of(Column::Vz)};
    const double radius = sample.state.position.m.norm();
    if (!(radius > least_radius_m && radius < most_radius_m)) {
      return fail("a position " + std::to_string(radius / 1000) +
                  " km from the Earth's centre: another unit, or not Earth-fixed?");
    }
    if (!samples_.empty()) {
      const double step_s = sample.t_s - samples_.back().t_s;
      if (!(step_s > 0)) return fail("its time is not after that of the row before");
      const double speed = (sample.state.position - samples_.back().state.position).m.norm() / step_s;
      if (speed > most_speed_m_s) {
        return fail("moves by " + std::to_string(speed / 1000) + " km/s from the row before: another unit?");
      }
    }
    samples_.push_back(sample);
  }

  void check_samples() {
    if (samples_.size() >= 2) return;
    std::string objects;
    for (const std::string& object : objects_)
      objects += (objects.empty() ? "" : ", ") + text::printable(object, false, 40);
    fail(samples_.empty() && !objects_.empty()
             ? "no row of object " + text::in_quotes(format_.object) + "; there are: " + objects +
                   " (nominal_object says which; default: the target's id)"
             : "fewer than two samples");
  }

  const NominalFormat& format_;
  const NominalProblem& problem_;
  std::vector<const ColumnUnit*> columns_;
  char delimiter_ = ',';
  std::vector<NominalSample> samples_;
  std::vector<std::string> objects_;  ///< that the file has, some of them
  int line_ = 0;
  bool good_ = true;
};

}  // namespace

std::optional<NominalTrajectory> read_nominal_csv(std::string_view text, const NominalFormat& format,
                                                  const NominalProblem& problem) {
  return Reader(format, problem).run(text);
}

std::string nominal_columns_help() {
  std::string names;
  for (const ColumnUnit& column : known) names += (names.empty() ? "columns: " : ", ") + std::string(column.name);
  return names;
}

std::optional<NominalTrajectory> nominal_from(const toml::array& rows) {
  if (rows.size() < 2 || rows.size() > max_nominal_samples) return std::nullopt;
  std::vector<NominalSample> samples;
  for (const toml::node& node : rows) {
    const toml::array* row = node.as_array();
    if (row == nullptr || row->size() != 7) return std::nullopt;
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
      const toml::node* cell = row->get(i);
      if (!cell->is_number()) return std::nullopt;
      v[i] = cell->value<double>().value_or(0);
      if (!std::isfinite(v[i])) return std::nullopt;
    }
    if (!samples.empty() && !(v[0] > samples.back().t_s)) return std::nullopt;
    samples.push_back({v[0], {{{v[1], v[2], v[3]}}, {{v[4], v[5], v[6]}}}});
  }
  return NominalTrajectory(std::move(samples));
}

toml::array rows_of(const NominalTrajectory& nominal) {
  toml::array rows;
  for (const NominalSample& s : nominal.samples()) {
    const Eigen::Vector3d& p = s.state.position.m;
    const Eigen::Vector3d& v = s.state.velocity.m_s;
    rows.push_back(toml::array{s.t_s, p.x(), p.y(), p.z(), v.x(), v.y(), v.z()});
  }
  return rows;
}

std::string show_nominal(const NominalTrajectory& nominal) {
  if (nominal.empty()) return "";
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  const auto mix = [&](double value) {
    std::array<unsigned char, sizeof value> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  };
  for (const NominalSample& s : nominal.samples()) {
    mix(s.t_s);
    for (int i = 0; i < 3; ++i) mix(s.state.position.m[i]);
    for (int i = 0; i < 3; ++i) mix(s.state.velocity.m_s[i]);
  }
  std::array<char, 100> text{};
  std::snprintf(text.data(), text.size(), "%zu samples, T%+g to T%+g s (%016llx)", nominal.samples().size(),
                nominal.samples().front().t_s, nominal.samples().back().t_s, static_cast<unsigned long long>(hash));
  return text.data();
}

}  // namespace downrange::config
