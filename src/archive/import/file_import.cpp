#include <algorithm>
#include <archive/import/file_import.hpp>
#include <archive/import/nmea.hpp>
#include <archive/import/order.hpp>
#include <archive/import/plausibility.hpp>
#include <archive/import/row_values.hpp>
#include <archive/import/table_reader.hpp>
#include <cmath>
#include <downrange/geo/site.hpp>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

/// Rows between two calls of the progress callback.
constexpr std::uint64_t progress_rows = 1024;

void note(Defects& defects, std::uint64_t line, std::string what) {
  ++defects.count;
  if (defects.first.size() < Defects::shown) defects.first.push_back({line, std::move(what)});
}

/// A row as a record, and where it stands.
struct ReadRow {
  std::variant<RadarTspi, GpsFix, AngleTspi, Truth> record;
  PlausibleRow values;
  std::uint64_t number = 0;  ///< of the row in the file
};

class FileImport {
 public:
  FileImport(const FileMapping& mapping, const FlightClock& clock) : mapping_(mapping), clock_(clock) {}

  FileReport run(Imported& out, const std::function<void(double)>& progress) {
    report_.path = mapping_.path;
    report_.kind = mapping_.kind;
    report_.source = mapping_.kind == FileKind::Truth ? mapping_.target : mapping_.source;
    SourceText source = read_source(mapping_.path);
    if (mapping_.nmea) {
      sentences_ = nmea_table(source.text);
      source.text = std::move(sentences_.text);
    }
    TableReader table(mapping_, source.text);
    const DecimalMark mark = decimal_mark(table);
    RowValues values(mapping_, {clock_.liftoff, scale_minus_utc(), mark});
    read_rows(table, values, source.text.size(), progress);
    tell_format(table, values, source, mark);
    if (rows_.empty()) fail(nothing_imported(table));
    put_in_order();
    judge_order();
    judge_values();
    append_to(out);
    return std::move(report_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw ImportError(mapping_.path.string() + ": " + what); }

  [[nodiscard]] Duration scale_minus_utc() const {
    if (mapping_.scale == TimeScale::Utc) return {};
    constexpr Time since_2017{1'483'228'800'000'000'000};
    constexpr int leap_seconds_since_2017 = 18;
    constexpr int tai_minus_gps = 19;
    if (!clock_.leap_seconds && clock_.liftoff < since_2017) {
      fail("time_scale: lift-off is before 2017; write leap_seconds, which GPS time was ahead of UTC then");
    }
    const int gps_minus_utc = clock_.leap_seconds.value_or(leap_seconds_since_2017);
    return milliseconds(std::int64_t{1000} * (gps_minus_utc + (mapping_.scale == TimeScale::Tai ? tai_minus_gps : 0)));
  }

  /// As the mapping says, or as the numbers of all rows show.
  [[nodiscard]] DecimalMark decimal_mark(TableReader& table) const {
    if (mapping_.decimal) return *mapping_.decimal;
    DecimalEvidence evidence;
    while (table.next()) {
      for (const std::size_t place : table.places()) {
        if (place < table.fields().size()) evidence.observe(table.fields()[place], table.line());
      }
    }
    table.rewind();
    const auto show = [](const DecimalEvidence::Cell& cell) {
      return text::in_quotes(cell.text) + " (line " + std::to_string(cell.line) + ")";
    };
    if (evidence.comma() && evidence.point()) {
      fail(show(*evidence.comma()) + " has a decimal comma and " + show(*evidence.point()) +
           " a decimal point: write decimal = \",\" or decimal = \".\"; rows of the other kind are left out");
    }
    if (evidence.comma()) return DecimalMark::Comma;
    if (!evidence.point() && evidence.either()) {
      fail(show(*evidence.either()) +
           " can have a decimal comma or thousands: write decimal = \",\" or decimal = \".\"");
    }
    return DecimalMark::Point;
  }

  void read_rows(TableReader& table, RowValues& values, std::size_t size, const std::function<void(double)>& progress) {
    while (table.next()) {
      ++report_.rows;
      if (report_.rows % progress_rows == 0) {
        progress(static_cast<double>(table.offset()) / static_cast<double>(size));
      }
      if (read_row(table, values)) rows_.push_back(row_of(table, values));
    }
    report_.passed_over = table.passed_over();
  }

  /// False: the row is no record, and counted.
  bool read_row(const TableReader& table, RowValues& values) {
    std::vector<std::string_view> fields = table.fields();
    // What a delimiter at the end of each row makes.
    while (fields.size() > table.width() && fields.back().empty()) fields.pop_back();
    if (table.text().find('\0') != std::string_view::npos) {
      note(report_.malformed, table.line(), "holds zero bytes");
      return false;
    }
    if (fields.size() != table.width()) {
      rows_too_wide_ += fields.size() > table.width() ? 1 : 0;
      rows_of_one_field_ += fields.size() == 1 ? 1 : 0;
      const bool doubled = fields.size() == 2 * table.width() && table.delimiter() == ',';
      note(report_.malformed, table.line(),
           std::to_string(fields.size()) + (fields.size() == 1 ? " field instead of " : " fields instead of ") +
               std::to_string(table.width()) +
               (doubled ? ": decimal commas beside a comma as delimiter cannot be told apart" : ""));
      return false;
    }
    CellProblem problem = CellProblem::None;
    try {
      problem = values.read(fields, table.places());
    } catch (const ImportError& error) {
      throw ImportError(mapping_.path.string() + ":" + std::to_string(table.line()) + ": " + error.what());
    }
    if (problem == CellProblem::Malformed) note(report_.malformed, table.line(), values.what());
    if (problem == CellProblem::NotFinite) note(report_.not_finite, table.line(), values.what());
    report_.left_empty += problem == CellProblem::None ? values.left_empty() : 0;
    return problem == CellProblem::None;
  }

  [[nodiscard]] ReadRow row_of(const TableReader& table, const RowValues& v) const {
    ReadRow row;
    row.values.line = table.line();
    row.number = table.row();
    row.values.epoch = v.epoch();
    row.values.clock = v.epoch_clock();
    row.values.received = mapping_.latency || mapping_.kind == FileKind::Truth ? v.epoch() : v.received();
    switch (mapping_.kind) {
      case FileKind::Radar:
        row.record = radar_of(v, row.values);
        break;
      case FileKind::Gps:
        row.record = gps_of(v, row.values);
        break;
      case FileKind::Angles:
        row.record = angles_of(v, row.values);
        break;
      case FileKind::Truth:
        row.record = truth_of(v, row.values);
        break;
    }
    return row;
  }

  static Eigen::Vector3d vector(const RowValues& v, Field x, Field y, Field z) {
    return {v.value(x), v.value(y), v.value(z)};
  }

  static bool has_all(const RowValues& v, std::initializer_list<Field> fields) {
    return std::all_of(fields.begin(), fields.end(), [&](Field f) { return v.has(f); });
  }

  static double or_zero(const RowValues& v, Field field) { return v.has(field) ? v.value(field) : 0; }

  [[nodiscard]] Position<Ecef> position_of(const RowValues& v) const {
    if (!mapping_.has(Field::Latitude)) return {vector(v, Field::X, Field::Y, Field::Z)};
    return ecef_from_geodetic({v.value(Field::Latitude), v.value(Field::Longitude), v.value(Field::Height)});
  }

  [[nodiscard]] TrackMode mode_of(const RowValues& v) const {
    return v.has(Field::Mode) ? static_cast<TrackMode>(v.value(Field::Mode)) : TrackMode::Track;
  }

  [[nodiscard]] RadarTspi radar_of(const RowValues& v, PlausibleRow& values) const {
    RadarTspi radar;
    radar.sensor = mapping_.source;
    radar.target = mapping_.target;
    radar.epoch = v.epoch();
    values.range_valid = radar.range_valid = v.has(Field::Range);
    values.angles_valid = radar.azimuth_valid = radar.elevation_valid = v.has_angles();
    if (values.range_valid) values.polar.range_m = v.value(Field::Range);
    if (values.angles_valid) {
      values.polar.azimuth_rad = v.value(Field::Azimuth);
      values.polar.elevation_rad = v.value(Field::Elevation);
    }
    radar.measured = values.polar;
    radar.measured.azimuth_rad = wrap_two_pi(values.polar.azimuth_rad);
    radar.range_rate_m_s = or_zero(v, Field::RangeRate);
    radar.range_rate_valid = v.has(Field::RangeRate);
    radar.snr_valid = v.has(Field::Snr);
    radar.snr_db = or_zero(v, Field::Snr);
    radar.mode = mode_of(v);
    return radar;
  }

  [[nodiscard]] GpsFix gps_of(const RowValues& v, PlausibleRow& values) const {
    GpsFix gps;
    gps.target = mapping_.target;
    gps.receiver = mapping_.receiver;
    gps.station = mapping_.source;
    gps.epoch = v.epoch();
    gps.position = position_of(v);
    gps.velocity_valid = has_all(v, {Field::Vx, Field::Vy, Field::Vz});
    if (gps.velocity_valid) {
      gps.velocity = {vector(v, Field::Vx, Field::Vy, Field::Vz)};
      values.speed_m_s = gps.velocity.m_s.norm();
    }
    gps.sigma_horizontal_m = or_zero(v, Field::SigmaHorizontal);
    gps.sigma_vertical_m = or_zero(v, Field::SigmaVertical);
    gps.sigma_velocity_m_s = or_zero(v, Field::SigmaVelocity);
    if (v.has(Field::FixType)) gps.fix = static_cast<FixType>(v.value(Field::FixType));
    gps.satellites_valid = v.has(Field::Satellites);
    if (gps.satellites_valid) gps.satellites = static_cast<std::uint8_t>(v.value(Field::Satellites));
    values.position = gps.position;
    return gps;
  }

  [[nodiscard]] AngleTspi angles_of(const RowValues& v, PlausibleRow& values) const {
    AngleTspi angles;
    angles.sensor = mapping_.source;
    angles.target = mapping_.target;
    angles.epoch = v.epoch();
    values.polar = {0, v.value(Field::Azimuth), v.value(Field::Elevation)};
    values.angles_valid = true;
    angles.azimuth_rad = wrap_two_pi(values.polar.azimuth_rad);
    angles.elevation_rad = values.polar.elevation_rad;
    angles.mode = mode_of(v);
    return angles;
  }

  [[nodiscard]] Truth truth_of(const RowValues& v, PlausibleRow& values) const {
    Truth truth;
    truth.target = mapping_.target;
    truth.epoch = v.epoch();
    truth.position = position_of(v);
    truth.velocity = {{or_zero(v, Field::Vx), or_zero(v, Field::Vy), or_zero(v, Field::Vz)}};
    truth.acceleration_valid = mapping_.has(Field::Ax);
    if (truth.acceleration_valid) truth.acceleration_m_s2 = vector(v, Field::Ax, Field::Ay, Field::Az);
    if (mapping_.has(Field::Vx)) values.speed_m_s = truth.velocity.m_s.norm();
    values.position = truth.position;
    return truth;
  }

  /// How the file was read, where the mapping does not say so.
  void tell_format(const TableReader& table, const RowValues& values, const SourceText& source, DecimalMark mark) {
    auto& notes = report_.notes;
    if (!source.encoding.empty()) notes.push_back("text in " + source.encoding);
    if (source.end_zeros > 0) notes.push_back(std::to_string(source.end_zeros) + " zero bytes at the end left off");
    if (mapping_.nmea) notes.push_back("NMEA sentences: " + show_sentences());
    if (sentences_.wrong_checksums > 0) notes.push_back(show_wrong_checksums());
    if (!mapping_.fixed.empty()) notes.emplace_back("columns by their places");
    if (!mapping_.delimiter && mapping_.fixed.empty() && table.delimiter() != ',') {
      notes.push_back("delimiter " + show_delimiter(table.delimiter()));
    }
    if (!mapping_.decimal && mark == DecimalMark::Comma) notes.emplace_back("decimal comma");
    if (table.header_line() > 1) notes.push_back("header on line " + std::to_string(table.header_line()));
    if (!values.clock_example().empty()) notes.push_back(values.clock_example());
    const PassedOver& passed = report_.passed_over;
    if (passed.comments > 0 && !mapping_.nmea) notes.push_back(std::to_string(passed.comments) + " comment lines");
    if (passed.headers > 0)
      notes.push_back("the header " + std::to_string(passed.headers) + " times again, or its units");
    if (passed.filtered > 0) notes.push_back(std::to_string(passed.filtered) + " rows not wanted by where");
    if (report_.left_empty > 0) notes.push_back(std::to_string(report_.left_empty) + " values not there or not finite");
    tell_parts();
    if (passed.others > 0) notes.push_back(std::to_string(passed.others) + " rows of others");
    if (mapping_.sort == true) notes.emplace_back("rows sorted by epoch");
  }

  /// How many of a radar's plots lack their range or their angles.
  void tell_parts() {
    if (mapping_.kind != FileKind::Radar) return;
    const auto lacking = [&](bool PlausibleRow::*part) {
      return std::ranges::count_if(rows_, [&](const ReadRow& row) { return !(row.values.*part); });
    };
    const auto tell = [&](std::ptrdiff_t count, const char* what) {
      if (count > 0) report_.notes.push_back(std::to_string(count) + " plots without " + what);
    };
    tell(lacking(&PlausibleRow::range_valid), "range");
    tell(lacking(&PlausibleRow::angles_valid), "angles");
  }

  [[nodiscard]] std::string show_sentences() const {
    std::string out;
    for (const auto& [type, count] : sentences_.sentences) {
      out += (out.empty() ? "" : ", ") + std::to_string(count) + ' ' + text::printable(type, false, 10);
    }
    return out.empty() ? "none" : out;
  }

  /// What rows that have another number of fields can be.
  [[nodiscard]] const char* why_another_width() const {
    if (rows_too_wide_ == report_.rows) {
      return "; numbers with thousands or decimal commas beside a comma as delimiter must stand in quotes";
    }
    if (rows_of_one_field_ == report_.rows) {
      return "; where nothing stands between the columns, write their places: at = [first, last]";
    }
    return "";
  }

  [[nodiscard]] std::string show_wrong_checksums() const {
    const std::uint64_t count = sentences_.wrong_checksums;
    return std::to_string(count) +
           (count == 1 ? " sentence with a wrong checksum, on " : " sentences with a wrong checksum, the first on ") +
           sentences_.first_wrong;
  }

  [[nodiscard]] std::string no_fix_sentence() const {
    const std::string found = "; sentences: " + show_sentences();
    if (sentences_.wrong_checksums == 0) return "no GGA and no GNS sentence" + found;
    return "no GGA and no GNS sentence with a right checksum; " + show_wrong_checksums() + found;
  }

  [[nodiscard]] std::string nothing_imported(const TableReader& table) const {
    if (mapping_.nmea && report_.rows == 0) return no_fix_sentence();
    if (report_.rows == 0 && report_.passed_over.filtered > 0) {
      std::string values;
      for (const auto& [value, count] : table.filtered_values()) values += (values.empty() ? "" : ", ") + value;
      return "no row passes where; values of rows that do not: " + values;
    }
    std::string columns;
    for (const std::string& name : table.names()) columns += (columns.empty() ? "" : ", ") + name;
    if (report_.rows == 0) return "no row behind the header (" + text::printable(columns, false, 300) + ")";
    std::string why;
    for (const Defects* defects : {&report_.malformed, &report_.not_finite}) {
      if (defects->count == 0) continue;
      why += (why.empty() ? "" : "; ") + std::to_string(defects->count) + (defects->count == 1 ? " row" : " rows") +
             ", the first on line " + std::to_string(defects->first.front().line) + ": " + defects->first.front().what;
    }
    return "none of its " + std::to_string(report_.rows) + " rows can be imported: " + why + why_another_width() +
           " (columns: " + text::printable(columns, false, 300) + ")";
  }

  /// Sorts where the mapping asks for it; refuses what cannot be in order.
  void put_in_order() {
    std::vector<RowTimes> times;
    times.reserve(rows_.size());
    for (const ReadRow& row : rows_) times.push_back({row.values.epoch, row.values.received, row.values.line});
    if (const std::string problem = order_problem(mapping_, times); !problem.empty()) fail(problem);
    if (mapping_.sort != true) return;
    std::stable_sort(rows_.begin(), rows_.end(),
                     [](const ReadRow& a, const ReadRow& b) { return a.values.epoch < b.values.epoch; });
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].number = i + 1;
  }

  /// Counts what is odd about the order of time, beside the row before. Truth stands still on the pad: not odd.
  void judge_order() {
    const PlausibleRow* last = nullptr;
    for (ReadRow& row : rows_) {
      PlausibleRow& values = row.values;
      if (mapping_.latency) {
        const Time earliest = last != nullptr ? last->received : values.epoch;
        values.received = std::max(values.epoch + *mapping_.latency, earliest);
      }
      if (last != nullptr) judge_step(row, *last);
      last = &values;
    }
  }

  void judge_step(const ReadRow& row, const PlausibleRow& last) {
    const PlausibleRow& values = row.values;
    const double step_s = (values.epoch - last.epoch).seconds();
    if (step_s < 0) note(report_.epoch_backwards, values.line, std::to_string(-step_s) + " s before the row before");
    if (step_s == 0) note(report_.epoch_repeated, values.line, "same epoch as the row before");
    if (mapping_.kind == FileKind::Truth) return;
    const bool same = values.polar.range_m == last.polar.range_m &&
                      values.polar.azimuth_rad == last.polar.azimuth_rad &&
                      values.polar.elevation_rad == last.polar.elevation_rad && values.position.m == last.position.m;
    if (step_s > 0 && same) {
      note(report_.value_repeated, values.line, "same values " + std::to_string(step_s) + " s after the row before");
    }
    if (values.received < last.received) {
      note(report_.received_backwards, values.line,
           "received " + std::to_string((last.received - values.received).seconds()) + " s before the row before");
    }
  }

  void judge_values() {
    std::vector<PlausibleRow> values;
    values.reserve(rows_.size());
    for (const ReadRow& row : rows_) values.push_back(row.values);
    Plausibility found = judge_plausibility(mapping_, clock_.liftoff, values);
    report_.plausibility = std::move(found.line);
    report_.doubts = std::move(found.doubts);
    if (found.impossible.empty()) return;
    if (!mapping_.accept_implausible) {
      fail(found.impossible + " (line " + std::to_string(rows_.front().values.line) +
           " on; accept_implausible = true imports it all the same)");
    }
    report_.doubts.insert(report_.doubts.begin(), found.impossible);
  }

  void append_to(Imported& out) {
    for (ReadRow& row : rows_) {
      std::visit(
          [&](auto& record) {
            if constexpr (std::is_same_v<std::decay_t<decltype(record)>, Truth>) {
              out.truths.push_back(record);
            } else {
              record.sequence = row.number;
              record.received = row.values.received;
              out.events.emplace_back(record);
            }
          },
          row.record);
    }
    report_.imported = rows_.size();
  }

  const FileMapping& mapping_;
  const FlightClock& clock_;
  FileReport report_;
  std::vector<ReadRow> rows_;
  NmeaTable sentences_;  ///< of an NMEA file; its text is the source's
  std::uint64_t rows_too_wide_ = 0;
  std::uint64_t rows_of_one_field_ = 0;
};

}  // namespace

FileReport import_file(const FileMapping& mapping, const FlightClock& clock, Imported& out,
                       const std::function<void(double)>& progress) {
  return FileImport(mapping, clock).run(out, progress);
}

}  // namespace downrange::archive
