#include <toml++/toml.h>

#include <algorithm>
#include <archive/import_mapping.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <set>
#include <sstream>
#include <string_view>

namespace downrange::archive {
namespace {

enum class Quantity : std::uint8_t { Time, Length, Angle, Speed, Acceleration, Number };

struct Unit {
  std::string_view name;
  Quantity quantity;
  double size;  ///< SI; of times nanoseconds, so that the factor is exact
};
constexpr Unit units[] = {
    {"s", Quantity::Time, 1e9},
    {"ms", Quantity::Time, 1e6},
    {"us", Quantity::Time, 1e3},
    {"ns", Quantity::Time, 1},
    {"m", Quantity::Length, 1},
    {"km", Quantity::Length, 1000},
    {"ft", Quantity::Length, 0.3048},
    {"nmi", Quantity::Length, 1852},
    {"deg", Quantity::Angle, std::numbers::pi / 180},
    {"rad", Quantity::Angle, 1},
    {"mrad", Quantity::Angle, 1e-3},
    {"m/s", Quantity::Speed, 1},
    {"km/s", Quantity::Speed, 1000},
    {"ft/s", Quantity::Speed, 0.3048},
    {"km/h", Quantity::Speed, 1 / 3.6},
    {"kn", Quantity::Speed, 1852.0 / 3600},
    {"m/s2", Quantity::Acceleration, 1},
    {"g", Quantity::Acceleration, 9.80665},
    {"1", Quantity::Number, 1},
    {"dB", Quantity::Number, 1},
};

constexpr unsigned radar = 1;
constexpr unsigned gps = 2;
constexpr unsigned truth = 4;
constexpr unsigned angles = 8;

struct FieldInfo {
  std::string_view name;
  Field field;
  Quantity quantity;
  unsigned kinds;
};
constexpr FieldInfo fields[] = {
    {"epoch", Field::Epoch, Quantity::Time, radar | gps | truth | angles},
    {"received", Field::Received, Quantity::Time, radar | gps | angles},
    {"range", Field::Range, Quantity::Length, radar},
    {"azimuth", Field::Azimuth, Quantity::Angle, radar | angles},
    {"elevation", Field::Elevation, Quantity::Angle, radar | angles},
    {"range_rate", Field::RangeRate, Quantity::Speed, radar},
    {"snr", Field::Snr, Quantity::Number, radar},
    {"x", Field::X, Quantity::Length, gps | truth},
    {"y", Field::Y, Quantity::Length, gps | truth},
    {"z", Field::Z, Quantity::Length, gps | truth},
    {"vx", Field::Vx, Quantity::Speed, gps | truth},
    {"vy", Field::Vy, Quantity::Speed, gps | truth},
    {"vz", Field::Vz, Quantity::Speed, gps | truth},
    {"ax", Field::Ax, Quantity::Acceleration, truth},
    {"ay", Field::Ay, Quantity::Acceleration, truth},
    {"az", Field::Az, Quantity::Acceleration, truth},
    {"latitude", Field::Latitude, Quantity::Angle, gps | truth},
    {"longitude", Field::Longitude, Quantity::Angle, gps | truth},
    {"height", Field::Height, Quantity::Length, gps | truth},
    {"sigma_horizontal", Field::SigmaHorizontal, Quantity::Length, gps},
    {"sigma_vertical", Field::SigmaVertical, Quantity::Length, gps},
    {"sigma_velocity", Field::SigmaVelocity, Quantity::Speed, gps},
    {"satellites", Field::Satellites, Quantity::Number, gps},
};
static_assert(std::size(fields) == field_count);

struct KindInfo {
  std::string_view name;
  FileKind kind;
};
constexpr KindInfo kinds[] = {
    {"radar", FileKind::Radar}, {"angles", FileKind::Angles}, {"gps", FileKind::Gps}, {"truth", FileKind::Truth}};

unsigned mask(FileKind kind) { return 1U << static_cast<unsigned>(kind); }

/// "a, b, c" of what a condition lets through.
template <class Table, class Condition>
std::string names_of(const Table& table, Condition condition) {
  std::string out;
  for (const auto& entry : table) {
    if (condition(entry)) out += (out.empty() ? "" : ", ") + std::string(entry.name);
  }
  return out;
}

/// One table of the file while it is read: takes its keys one by one; what is left over is unknown.
class Section {
 public:
  Section(const std::filesystem::path& file, const toml::table& table, std::string prefix)
      : file_(file), table_(table), prefix_(std::move(prefix)) {}

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    const toml::node* node = table_.get(key);
    const auto line = (node != nullptr ? node->source() : table_.source()).begin.line;
    throw ImportError(file_.string() + ":" + std::to_string(line) + ": " + prefix_ + key + ": " + what);
  }

  [[nodiscard]] const toml::node* find(const std::string& key) {
    known_.insert(key);
    return table_.get(key);
  }

  [[nodiscard]] std::optional<std::string> text(const std::string& key) {
    const toml::node* node = find(key);
    if (node == nullptr) return std::nullopt;
    if (const auto* value = node->as_string()) return value->get();
    fail(key, "must be a text in quotes");
  }
  [[nodiscard]] std::string required_text(const std::string& key, const std::string& meaning) {
    const auto found = text(key);
    if (!found) fail(key, "missing: " + meaning);
    return *found;
  }
  [[nodiscard]] std::optional<double> number(const std::string& key) {
    const toml::node* node = find(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->is_number() ? node->value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) fail(key, "must be a finite number");
    return value;
  }
  [[nodiscard]] std::optional<Name> name(const std::string& key) {
    const auto found = text(key);
    if (!found) return std::nullopt;
    const auto parsed = Name::parse(*found);
    if (!parsed || parsed->empty()) fail(key, "must be a name of 1 to 31 characters");
    return parsed;
  }
  [[nodiscard]] Name required_name(const std::string& key, const std::string& meaning) {
    const auto found = name(key);
    if (!found) fail(key, "missing: " + meaning);
    return *found;
  }

  void no_other_keys() const {
    for (const auto& [key, node] : table_) {
      const std::string name(key.str());
      if (known_.contains(name)) continue;
      std::string known;
      for (const std::string& k : known_) known += (known.empty() ? "" : ", ") + k;
      fail(name, "unknown key; allowed: " + known);
    }
  }

 private:
  const std::filesystem::path& file_;
  const toml::table& table_;
  std::string prefix_;
  std::set<std::string> known_;
};

Time liftoff_of(Section& section) {
  const toml::node* node = section.find("liftoff");
  constexpr std::int64_t latest_ns = 6'000'000'000'000'000'000;  // room for a century after it
  constexpr const char* allowed =
      "must be a date and time with offset, e.g. 2018-02-06T20:45:00Z, or an integer: nanoseconds since 1970 UTC";
  if (node == nullptr) section.fail("liftoff", std::string("missing: ") + allowed);
  if (const auto ns = node->value_exact<std::int64_t>()) {
    if (*ns < 0 || *ns > latest_ns) section.fail("liftoff", "outside the years 1970 to 2160");
    return {*ns};
  }
  const auto moment = node->value_exact<toml::date_time>();
  if (!moment || !moment->offset) section.fail("liftoff", allowed);
  const std::chrono::year_month_day day(std::chrono::year(moment->date.year), std::chrono::month(moment->date.month),
                                        std::chrono::day(moment->date.day));
  const std::int64_t days = std::chrono::sys_days(day).time_since_epoch().count();
  const std::int64_t minutes =
      days * 1440 + moment->time.hour * std::int64_t{60} + moment->time.minute - moment->offset->minutes;
  const std::int64_t whole_seconds = minutes * 60 + moment->time.second;
  if (whole_seconds < 0 || whole_seconds > latest_ns / 1'000'000'000) {
    section.fail("liftoff", "outside the years 1970 to 2160");
  }
  return {whole_seconds * 1'000'000'000 + moment->time.nanosecond};
}

ColumnMapping read_column(Section section, const std::string& column, FileKind kind) {
  ColumnMapping mapping;
  mapping.column = column;
  const std::string field_name = section.required_text("field", "what the column means, or the column = \"ignore\"");
  const auto* field = std::find_if(std::begin(fields), std::end(fields), [&](const FieldInfo& f) {
    return f.name == field_name && (f.kinds & mask(kind)) != 0;
  });
  if (field == std::end(fields)) {
    section.fail("field", "'" + field_name + "' is no field of such a file; allowed: " +
                              names_of(fields, [&](const FieldInfo& f) { return (f.kinds & mask(kind)) != 0; }));
  }
  mapping.field = field->field;

  const auto of_field = [&](const Unit& u) { return u.quantity == field->quantity; };
  const auto unit_name = section.text("unit");
  const auto* unit = std::find_if(std::begin(units), std::end(units),
                                  [&](const Unit& u) { return of_field(u) && u.name == unit_name; });
  if (unit == std::end(units) && (unit_name || field->quantity != Quantity::Number)) {
    section.fail("unit", (unit_name ? "'" + *unit_name + "' is no unit of " + field_name : "missing") +
                             "; allowed: " + names_of(units, of_field));
  }
  mapping.factor = section.number("scale").value_or(1.0) * (unit == std::end(units) ? 1.0 : unit->size);
  mapping.offset = section.number("offset").value_or(0.0);
  if (mapping.factor == 0) section.fail("scale", "must not be 0");
  if (field->quantity == Quantity::Time) {
    const std::string since = section.text("since").value_or("liftoff");
    if (since != "liftoff" && since != "unix") section.fail("since", "'" + since + "'; allowed: liftoff, unix");
    mapping.since_unix = since == "unix";
  }
  section.no_other_keys();
  return mapping;
}

/// Fields that only make sense together are all there or none is.
bool has_group(Section& section, const FileMapping& file, std::initializer_list<Field> group, const char* names) {
  const auto count = std::count_if(group.begin(), group.end(), [&](Field f) { return file.has(f); });
  if (count != 0 && count != std::ssize(group)) section.fail("columns", std::string("only some of ") + names);
  return count != 0;
}

void check_fields(Section& section, const FileMapping& file) {
  std::set<Field> seen;
  for (const ColumnMapping& column : file.columns) {
    if (!seen.insert(column.field).second) {
      section.fail("columns", "two columns for one field, the second is '" + column.column + "'");
    }
  }
  if (!file.has(Field::Epoch)) section.fail("columns", "no column for epoch");
  if (file.kind == FileKind::Radar) {
    if (!has_group(section, file, {Field::Range, Field::Azimuth, Field::Elevation}, "range, azimuth, elevation")) {
      section.fail("columns", "a radar file needs range, azimuth and elevation");
    }
    return;
  }
  if (file.kind == FileKind::Angles) {
    if (!has_group(section, file, {Field::Azimuth, Field::Elevation}, "azimuth, elevation")) {
      section.fail("columns", "an angles file needs azimuth and elevation");
    }
    return;
  }
  const bool ecef = has_group(section, file, {Field::X, Field::Y, Field::Z}, "x, y, z");
  const bool geodetic =
      has_group(section, file, {Field::Latitude, Field::Longitude, Field::Height}, "latitude, longitude, height");
  if (ecef == geodetic) section.fail("columns", "needs either x, y, z or latitude, longitude, height");
  has_group(section, file, {Field::Vx, Field::Vy, Field::Vz}, "vx, vy, vz");
  has_group(section, file, {Field::Ax, Field::Ay, Field::Az}, "ax, ay, az");
}

FileMapping read_file(const std::filesystem::path& mapping_file, const toml::table& table, std::size_t index,
                      const std::filesystem::path& folder, const std::optional<Name>& target) {
  const std::string prefix = "file[" + std::to_string(index) + "].";
  Section section(mapping_file, table, prefix);
  FileMapping file;
  file.path = (folder / section.required_text("path", "the CSV file")).lexically_normal();

  const std::string kind = section.required_text("kind", "radar, angles, gps or truth");
  const auto* known =
      std::find_if(std::begin(kinds), std::end(kinds), [&](const KindInfo& k) { return k.name == kind; });
  if (known == std::end(kinds)) section.fail("kind", "'" + kind + "'; allowed: radar, angles, gps, truth");
  file.kind = known->kind;
  if (file.kind == FileKind::Radar) file.source = section.required_name("sensor", "the radar's name");
  if (file.kind == FileKind::Angles) file.source = section.required_name("sensor", "the tracker's name");
  if (file.kind == FileKind::Gps) {
    file.source = section.required_name("station", "the telemetry station's name");
    file.receiver = section.name("receiver").value_or(Name());
  }
  file.target = section.name("target").value_or(target.value_or(Name()));
  if (file.target.empty()) section.fail("target", "missing here and at the top of the file");

  if (const auto latency = section.number("latency_s")) {
    if (*latency < 0 || *latency > 3600) section.fail("latency_s", "must be 0 to 3600");
    file.latency = seconds(*latency);
  }
  const std::string delimiter = section.text("delimiter").value_or(",");
  if (delimiter.size() != 1) section.fail("delimiter", "must be one character");
  file.delimiter = delimiter[0];

  const toml::node* columns = section.find("columns");
  if (columns == nullptr || !columns->is_table()) section.fail("columns", "missing: a table of the file's columns");
  const std::string columns_prefix = prefix + "columns.";
  for (const auto& [key, node] : *columns->as_table()) {
    const std::string column(key.str());
    if (const auto* table_of_column = node.as_table()) {
      file.columns.push_back(
          read_column(Section(mapping_file, *table_of_column, columns_prefix + column + '.'), column, file.kind));
    } else if (node.value<std::string>() == "ignore") {
      file.ignored.push_back(column);
    } else {
      Section(mapping_file, *columns->as_table(), columns_prefix)
          .fail(column, "must be \"ignore\" or {field = ..., unit = ...}");
    }
  }
  check_fields(section, file);
  if (file.kind != FileKind::Truth && file.latency.has_value() == file.has(Field::Received)) {
    section.fail("latency_s", "needed where no column is 'received', and only there");
  }
  section.no_other_keys();
  return file;
}

}  // namespace

bool FileMapping::has(Field field) const {
  return std::any_of(columns.begin(), columns.end(), [&](const ColumnMapping& c) { return c.field == field; });
}

ImportMapping load_mapping(const std::filesystem::path& file, const std::optional<std::filesystem::path>& folder) {
  std::ifstream in(file);
  if (!in || !std::filesystem::is_regular_file(file)) throw ImportError(file.string() + ": cannot open the mapping");
  ImportMapping mapping;
  mapping.text.assign(std::istreambuf_iterator<char>(in), {});

  toml::table table;
  try {
    table = toml::parse(mapping.text);
  } catch (const toml::parse_error& error) {
    throw ImportError(file.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                      std::string(error.description()));
  }

  Section section(file, table, "");
  mapping.mission = section.required_name("mission", "the flight's name");
  mapping.liftoff = liftoff_of(section);
  const auto target = section.name("target");
  const auto own_folder = file.parent_path() / section.text("folder").value_or("");
  const toml::node* files = section.find("file");
  const toml::array* list = files == nullptr ? nullptr : files->as_array();
  if (list == nullptr || list->empty()) section.fail("file", "missing: at least one [[file]]");
  for (std::size_t i = 0; i < list->size(); ++i) {
    const toml::table* entry = (*list)[i].as_table();
    if (entry == nullptr) section.fail("file", "must be [[file]] tables");
    mapping.files.push_back(read_file(file, *entry, i, folder.value_or(own_folder), target));
  }
  section.no_other_keys();
  return mapping;
}

}  // namespace downrange::archive
