#include <algorithm>
#include <archive/csv.hpp>
#include <archive/import_csv.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <downrange/geo/polar.hpp>
#include <downrange/geo/site.hpp>
#include <numbers>

namespace downrange::archive {
namespace {

/// Reading takes most of the time of an import.
constexpr double reading_share = 0.8;
/// Rows between two calls of the progress callback.
constexpr std::uint64_t progress_rows = 1024;

void note(Defects& defects, std::uint64_t line, std::string what) {
  ++defects.count;
  if (defects.first.size() < Defects::shown) defects.first.push_back({line, std::move(what)});
}

struct Imported {
  std::vector<Event> events;
  std::vector<Truth> truths;
};

/// Reads one CSV file row by row.
class FileImport {
 public:
  FileImport(const FileMapping& mapping, Time liftoff, Imported& out)
      : mapping_(mapping), liftoff_(liftoff), out_(out) {}

  template <class Progress>
  FileReport run(Progress&& progress) {
    report_.path = mapping_.path;
    report_.kind = mapping_.kind;
    report_.source = mapping_.kind == FileKind::Truth ? mapping_.target : mapping_.source;
    CsvFile csv(mapping_.path, mapping_.delimiter);
    find_columns(csv.columns());
    while (csv.next()) {
      ++report_.rows;
      line_ = csv.line();
      if (read_row(csv.fields(), csv.columns())) add_record();
      if (report_.rows % progress_rows == 0) progress(csv.bytes_read());
    }
    return std::move(report_);
  }

 private:
  [[nodiscard]] double value(Field field) const { return values_[static_cast<std::size_t>(field)]; }
  [[nodiscard]] Eigen::Vector3d vector(Field x, Field y, Field z) const { return {value(x), value(y), value(z)}; }

  /// Every declared column must be in the file, and every column of the file declared.
  void find_columns(const std::vector<std::string>& columns) {
    const auto place = [&](const std::string& name) {
      const auto found = std::find(columns.begin(), columns.end(), name);
      if (found == columns.end()) throw ImportError(mapping_.path.string() + ":1: no column '" + name + "'");
      return static_cast<std::size_t>(found - columns.begin());
    };
    std::vector<bool> declared(columns.size(), false);
    for (const ColumnMapping& column : mapping_.columns) {
      places_.push_back(place(column.column));
      declared[places_.back()] = true;
    }
    for (const std::string& column : mapping_.ignored) declared[place(column)] = true;
    const auto forgotten = std::find(declared.begin(), declared.end(), false);
    if (forgotten != declared.end()) {
      const std::string& name = columns[static_cast<std::size_t>(forgotten - declared.begin())];
      throw ImportError(mapping_.path.string() + ":1: column '" + name +
                        "' is not in the mapping; give it a field, or write: \"" + name + "\" = \"ignore\"");
    }
  }

  /// False: the row is no record, and counted.
  bool read_row(const std::vector<std::string_view>& fields, const std::vector<std::string>& columns) {
    if (fields.size() != columns.size()) {
      note(report_.malformed, line_,
           std::to_string(fields.size()) + " fields instead of " + std::to_string(columns.size()));
      return false;
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!read_field(mapping_.columns[i], fields[places_[i]])) return false;
    }
    if (mapping_.has(Field::Latitude) && std::abs(value(Field::Latitude)) > std::numbers::pi / 2) {
      note(report_.malformed, line_, "latitude beyond a pole");
      return false;
    }
    return true;
  }

  bool read_field(const ColumnMapping& column, std::string_view text) {
    const auto quoted = [&] { return column.column + ": '" + std::string(text.substr(0, 40)) + "'"; };
    if (text.empty()) {
      note(report_.not_finite, line_, column.column + ": empty");
      return false;
    }
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) {
      note(report_.malformed, line_, quoted() + " is not a number");
      return false;
    }
    if (!std::isfinite(number)) {
      note(report_.not_finite, line_, quoted() + " is not finite");
      return false;
    }
    if (column.field == Field::Epoch || column.field == Field::Received) return read_time(column, text);
    values_[static_cast<std::size_t>(column.field)] = number * column.factor + column.offset;
    return true;
  }

  /// With 64 bits of mantissa: a double of seconds since 1970 is good to a quarter of a microsecond only.
  bool read_time(const ColumnMapping& column, std::string_view text) {
    long double number = 0;
    static_cast<void>(std::from_chars(text.data(), text.data() + text.size(), number));
    const long double ns = number * column.factor + column.offset * 1e9L;
    constexpr long double century = 100.0L * 365.25L * 86400e9L;
    if (std::abs(ns) > century) {
      note(report_.malformed, line_, column.column + ": '" + std::string(text) + "' is no time of a flight");
      return false;
    }
    const Time since = column.since_unix ? Time{0} : liftoff_;
    (column.field == Field::Epoch ? epoch_ : received_) = since + Duration{std::llround(ns)};
    return true;
  }

  void add_record() {
    if (mapping_.latency) received_ = std::max(epoch_ + *mapping_.latency, last_received_.value_or(epoch_));
    switch (mapping_.kind) {
      case FileKind::Radar:
        add_radar();
        break;
      case FileKind::Gps:
        add_gps();
        break;
      case FileKind::Angles:
        add_angles();
        break;
      case FileKind::Truth:
        add_truth();
        break;
    }
    ++report_.imported;
  }

  void add_radar() {
    RadarTspi radar;
    radar.sensor = mapping_.source;
    radar.target = mapping_.target;
    radar.sequence = report_.rows;
    radar.epoch = epoch_;
    radar.received = received_;
    radar.measured = {value(Field::Range), wrap_two_pi(value(Field::Azimuth)), value(Field::Elevation)};
    radar.range_rate_m_s = value(Field::RangeRate);
    radar.range_rate_valid = mapping_.has(Field::RangeRate);
    radar.snr_db = value(Field::Snr);
    judge_order(vector(Field::Range, Field::Azimuth, Field::Elevation));
    out_.events.emplace_back(radar);
  }

  void add_gps() {
    GpsFix gps;
    gps.target = mapping_.target;
    gps.receiver = mapping_.receiver;
    gps.station = mapping_.source;
    gps.sequence = report_.rows;
    gps.epoch = epoch_;
    gps.received = received_;
    gps.position = position();
    gps.velocity = {vector(Field::Vx, Field::Vy, Field::Vz)};
    gps.velocity_valid = mapping_.has(Field::Vx);
    gps.sigma_horizontal_m = value(Field::SigmaHorizontal);
    gps.sigma_vertical_m = value(Field::SigmaVertical);
    gps.sigma_velocity_m_s = value(Field::SigmaVelocity);
    gps.satellites = static_cast<std::uint8_t>(std::clamp(value(Field::Satellites), 0.0, 255.0));
    judge_order(gps.position.m);
    out_.events.emplace_back(gps);
  }

  void add_angles() {
    AngleTspi angles;
    angles.sensor = mapping_.source;
    angles.target = mapping_.target;
    angles.sequence = report_.rows;
    angles.epoch = epoch_;
    angles.received = received_;
    angles.azimuth_rad = wrap_two_pi(value(Field::Azimuth));
    angles.elevation_rad = value(Field::Elevation);
    judge_order({0, angles.azimuth_rad, angles.elevation_rad});
    out_.events.emplace_back(angles);
  }

  void add_truth() {
    Truth truth;
    truth.target = mapping_.target;
    truth.epoch = epoch_;
    truth.position = position();
    truth.velocity = {vector(Field::Vx, Field::Vy, Field::Vz)};
    truth.acceleration_m_s2 = vector(Field::Ax, Field::Ay, Field::Az);
    truth.acceleration_valid = mapping_.has(Field::Ax);
    received_ = epoch_;
    judge_order(truth.position.m);
    out_.truths.push_back(truth);
  }

  [[nodiscard]] Position<Ecef> position() const {
    if (!mapping_.has(Field::Latitude)) return {vector(Field::X, Field::Y, Field::Z)};
    return ecef_from_geodetic({value(Field::Latitude), value(Field::Longitude), value(Field::Height)});
  }

  /// Notes what is odd about the order of time, beside the row before. Truth stands still on the pad: not odd.
  void judge_order(const Eigen::Vector3d& measured) {
    if (last_epoch_) {
      const double step_s = (epoch_ - *last_epoch_).seconds();
      if (step_s < 0) note(report_.epoch_backwards, line_, std::to_string(-step_s) + " s before the row before");
      if (step_s == 0) note(report_.epoch_repeated, line_, "same epoch as the row before");
      if (step_s > 0 && measured == last_measured_ && mapping_.kind != FileKind::Truth) {
        note(report_.value_repeated, line_, "same values " + std::to_string(step_s) + " s after the row before");
      }
    }
    if (mapping_.kind != FileKind::Truth && last_received_ && received_ < *last_received_) {
      note(report_.received_backwards, line_,
           "received " + std::to_string((*last_received_ - received_).seconds()) + " s before the row before");
    }
    last_epoch_ = epoch_;
    last_received_ = received_;
    last_measured_ = measured;
  }

  const FileMapping& mapping_;
  Time liftoff_;
  Imported& out_;
  FileReport report_;
  std::vector<std::size_t> places_;  ///< in a row, of each mapped column
  std::uint64_t line_ = 0;
  std::array<double, field_count> values_{};
  Time epoch_;
  Time received_;
  std::optional<Time> last_epoch_;
  std::optional<Time> last_received_;
  Eigen::Vector3d last_measured_ = Eigen::Vector3d::Zero();
};

MissionEvent liftoff_event(const ImportMapping& mapping) {
  MissionEvent event;
  event.mission = mapping.mission;
  event.label = "lift-off";
  event.kind = MissionEventKind::Liftoff;
  event.sequence = 1;
  event.epoch = mapping.liftoff;
  event.received = mapping.liftoff;
  return event;
}

bool received_before(const Event& a, const Event& b) {
  const Time received_a = received_of(a);
  const Time received_b = received_of(b);
  return received_a != received_b ? received_a < received_b : step_order_less(a, b);
}

void write_archive(const Imported& imported, const ImportMapping& mapping, const std::filesystem::path& archive,
                   const ImportOptions& options, ImportReport& report) {
  Writer writer(archive, options.writer);
  writer.attach("import.toml", "application/toml", mapping.text, mapping.liftoff);
  for (const FileReport& file : report.files) {
    writer.metadata("downrange.import." + file.path.filename().string(),
                    {{"rows", std::to_string(file.rows)},
                     {"imported", std::to_string(file.imported)},
                     {"malformed", std::to_string(file.malformed.count)},
                     {"not_finite", std::to_string(file.not_finite.count)},
                     {"epoch_backwards", std::to_string(file.epoch_backwards.count)},
                     {"epoch_repeated", std::to_string(file.epoch_repeated.count)},
                     {"value_repeated", std::to_string(file.value_repeated.count)},
                     {"received_backwards", std::to_string(file.received_backwards.count)}});
  }
  auto truth = imported.truths.begin();
  for (std::size_t i = 0; i < imported.events.size(); ++i) {
    for (; truth != imported.truths.end() && truth->epoch <= received_of(imported.events[i]); ++truth) {
      writer.write_truth(*truth);
    }
    writer.write(imported.events[i]);
    if (options.progress && i % progress_rows == 0) {
      const double written = static_cast<double>(i) / static_cast<double>(imported.events.size());
      options.progress(reading_share + (1 - reading_share) * written);
    }
  }
  for (; truth != imported.truths.end(); ++truth) writer.write_truth(*truth);
  report.archive = writer.close();
  if (!report.archive.ok()) throw ArchiveError(report.archive.failure);
}

}  // namespace

ImportReport import_csv(const std::filesystem::path& mapping_file, const std::filesystem::path& archive,
                        const ImportOptions& options) {
  const ImportMapping mapping = load_mapping(mapping_file, options.folder);
  double bytes_total = 1;
  for (const FileMapping& file : mapping.files) {
    std::error_code absent;  // the reader of the file says so better
    const auto size = std::filesystem::file_size(file.path, absent);
    if (!absent) bytes_total += static_cast<double>(size);
  }

  ImportReport report;
  report.liftoff = mapping.liftoff;
  Imported imported;
  imported.events.emplace_back(liftoff_event(mapping));
  double bytes_before = 0;
  for (const FileMapping& file : mapping.files) {
    const auto progress = [&](std::uint64_t bytes) {
      if (options.progress) options.progress(reading_share * (bytes_before + static_cast<double>(bytes)) / bytes_total);
    };
    try {
      report.files.push_back(FileImport(file, mapping.liftoff, imported).run(progress));
    } catch (const ImportError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw ImportError(error.what());
    }
    bytes_before += static_cast<double>(std::filesystem::file_size(file.path));
  }
  std::stable_sort(imported.events.begin(), imported.events.end(), received_before);
  std::stable_sort(imported.truths.begin(), imported.truths.end(),
                   [](const Truth& a, const Truth& b) { return a.epoch < b.epoch; });
  report.events = imported.events.size();
  report.truths = imported.truths.size();
  report.first_received = received_of(imported.events.front());
  report.last_received = received_of(imported.events.back());

  write_archive(imported, mapping, archive, options, report);
  if (options.progress) options.progress(1.0);
  return report;
}

}  // namespace downrange::archive
