#include <algorithm>
#include <archive/import/mapping.hpp>
#include <archive/import/mapping_section.hpp>
#include <archive/import/nmea.hpp>
#include <array>
#include <cmath>
#include <set>
#include <text/file.hpp>
#include <text/parse_toml.hpp>

namespace downrange::archive {
namespace {

Time liftoff_of(MappingSection& section) {
  const toml::node* node = section.find("liftoff");
  constexpr std::int64_t latest_ns = 6'000'000'000'000'000'000;  // room for a century after it
  constexpr const char* allowed =
      "must be a date and time with offset, e.g. 2018-02-06T20:45:00Z, or an integer: nanoseconds since 1970 UTC";
  if (node == nullptr) section.fail("liftoff", std::string("missing: ") + allowed);
  std::optional<Time> time;
  if (const auto ns = node->value_exact<std::int64_t>()) {
    time = Time{*ns};
  } else {
    const auto moment = node->value_exact<toml::date_time>();
    if (!moment || !moment->offset) section.fail("liftoff", allowed);
    time = time_of(*moment);
  }
  if (!time || time->ns < 0 || time->ns > latest_ns) section.fail("liftoff", "outside the years 1970 to 2160");
  return *time;
}

void read_since(MappingSection& section, ColumnMapping& mapping) {
  constexpr const char* allowed = "allowed: liftoff, unix, midnight, gps, or a date and time with offset";
  const toml::node* node = section.find("since");
  if (node == nullptr) return;
  if (const auto moment = node->value_exact<toml::date_time>()) {
    const auto time = time_of(*moment);
    if (!time) section.fail("since", std::string("a date without offset, or before 1800; ") + allowed);
    mapping.since = Since::Instant;
    mapping.instant = *time;
    return;
  }
  const std::string since = node->value_exact<std::string>().value_or("?");
  constexpr std::array<std::pair<std::string_view, Since>, 3> names{
      {{"liftoff", Since::Liftoff}, {"unix", Since::Unix}, {"midnight", Since::Midnight}}};
  for (const auto& [name, value] : names) {
    if (since == name) mapping.since = value;
  }
  if (since == "gps") {
    mapping.since = Since::Instant;
    mapping.instant = Time{315'964'800'000'000'000};  // 1980-01-06, where GPS time starts
  }
  if (!mapping.since) section.fail("since", "'" + since + "'; " + allowed);
}

/// What the cells of a choice say. Without the table: the names of the values themselves.
void read_values(MappingSection& section, ColumnMapping& mapping) {
  const auto names = choices_of(mapping.field);
  const auto place = [&](std::string_view name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  };
  const toml::table* table = section.table("values");
  if (table == nullptr) {
    for (std::size_t i = 0; i < names.size(); ++i) mapping.values.emplace_back(names[i], static_cast<int>(i));
    return;
  }
  std::string allowed;
  for (const std::string_view name : names) allowed += (allowed.empty() ? "" : ", ") + std::string(name);
  for (const auto& [key, node] : *table) {
    const int value = place(node.value_exact<std::string>().value_or(""));
    if (value < 0) section.fail("values", "\"" + std::string(key.str()) + "\": allowed: " + allowed);
    mapping.values.emplace_back(key.str(), value);
  }
}

void read_unit(MappingSection& section, const FieldInfo& field, ColumnMapping& mapping) {
  const auto of_field = [&](const UnitInfo& u) { return u.quantity == field.quantity; };
  const auto name = section.text("unit");
  mapping.text = field.quantity == Quantity::Time && name == "text";
  mapping.packed = field.quantity == Quantity::Time && name == "hhmmss";
  const auto units = all_units();
  const auto unit =
      std::find_if(units.begin(), units.end(), [&](const UnitInfo& u) { return of_field(u) && u.name == name; });
  const bool needed = name || field.quantity != Quantity::Number;
  if (unit == units.end() && needed && !mapping.text && !mapping.packed) {
    section.fail("unit", (name ? "'" + *name + "' is no unit of " + std::string(field.name) : "missing") +
                             "; allowed: " + names_of(units, of_field) +
                             (field.quantity == Quantity::Time ? ", text, hhmmss" : ""));
  }
  const double scale = section.number("scale").value_or(1.0);
  mapping.unit = name.value_or("");
  mapping.scaled = scale != 1;
  mapping.factor = scale * (unit == units.end() ? 1.0 : unit->size);
  mapping.offset = section.number("offset").value_or(0.0);
  if (mapping.factor == 0 || !std::isfinite(mapping.factor)) section.fail("scale", "must not be 0 or beyond numbers");
}

ColumnMapping read_column(MappingSection& section, const std::string& column, FileKind kind) {
  ColumnMapping mapping;
  mapping.column = column;
  const std::string name = section.required_text("field", "what the column means, or the column = \"ignore\"");
  const auto fields = all_fields();
  const auto fits = [&](const FieldInfo& f) { return (f.kinds & kind_mask(kind)) != 0; };
  const auto field =
      std::find_if(fields.begin(), fields.end(), [&](const FieldInfo& f) { return f.name == name && fits(f); });
  if (field == fields.end()) {
    section.fail("field", "'" + name + "' is no field of such a file; allowed: " + names_of(fields, fits));
  }
  mapping.field = field->field;
  if (field->quantity == Quantity::Choice) {
    read_values(section, mapping);
  } else if (field->quantity != Quantity::Date) {
    read_unit(section, *field, mapping);
  }
  if (field->quantity == Quantity::Time) read_since(section, mapping);
  return mapping;
}

/// at = [first, last]: characters of a line, from 1; nothing where the key is absent.
std::optional<FixedPlace> read_place(MappingSection& section) {
  const toml::node* node = section.find("at");
  if (node == nullptr) return std::nullopt;
  constexpr std::int64_t longest_line = 100'000;
  const toml::array* list = node->as_array();
  const bool pair = list != nullptr && list->size() == 2;
  const auto first = pair ? list->get(0)->value_exact<std::int64_t>() : std::nullopt;
  const auto last = pair ? list->get(1)->value_exact<std::int64_t>() : std::nullopt;
  if (!first || !last || *first < 1 || *last < *first || *last > longest_line) {
    section.fail("at", "must be [first, last]: the column's characters in a line, from 1");
  }
  return FixedPlace{static_cast<std::size_t>(*first), static_cast<std::size_t>(*last)};
}

/// Fields that only make sense together are all there or none is.
bool has_group(MappingSection& section, const FileMapping& file, std::initializer_list<Field> group,
               const char* names) {
  const auto count = std::count_if(group.begin(), group.end(), [&](Field f) { return file.has(f); });
  if (count != 0 && count != std::ssize(group)) section.fail("columns", std::string("only some of ") + names);
  return count != 0;
}

void check_fields(MappingSection& section, const FileMapping& file) {
  std::set<Field> seen;
  for (const ColumnMapping& column : file.columns) {
    if (!seen.insert(column.field).second) {
      section.fail("columns", "two columns for one field, the second is '" + column.column + "'");
    }
  }
  if (!file.has(Field::Epoch)) section.fail("columns", "no column for epoch");
  if (file.kind == FileKind::Radar) {
    if (!has_group(section, file, {Field::Azimuth, Field::Elevation}, "azimuth, elevation") &&
        !file.has(Field::Range)) {
      section.fail("columns", "a radar file needs range, or azimuth and elevation, or all of them");
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

/// A name, or {column = ..., names = {...}}: the column that says it.
struct NameOrColumn {
  Name name;
  std::optional<NameColumn> column;
};

NameOrColumn read_name(MappingSection& section, const std::string& key) {
  NameOrColumn found;
  const toml::node* node = section.find(key);
  const toml::table* table = node == nullptr ? nullptr : node->as_table();
  if (table == nullptr) {
    found.name = section.name(key).value_or(Name());
    return found;
  }
  MappingSection inner(section.file(), *table, section.prefix() + key + '.');
  NameColumn column{inner.required_text("column", "the column that says the name"), {}};
  if (const toml::table* names = inner.table("names")) {
    for (const auto& [cell, value] : *names) {
      const auto name = Name::parse(value.value_exact<std::string>().value_or(""));
      if (!name || name->empty()) {
        inner.fail("names", "\"" + std::string(cell.str()) + "\": must be a name of 1 to 31 characters");
      }
      column.names.emplace_back(cell.str(), *name);
    }
  }
  inner.no_other_keys();
  found.column = std::move(column);
  return found;
}

void read_kind_and_names(MappingSection& section, const std::optional<Name>& target, FileMapping& file) {
  const std::string kind = section.required_text("kind", "radar, angles, gps or truth");
  const auto kinds = all_kinds();
  const auto known = std::find_if(kinds.begin(), kinds.end(), [&](const KindInfo& k) { return k.name == kind; });
  if (known == kinds.end()) section.fail("kind", "'" + kind + "'; allowed: radar, angles, gps, truth");
  file.kind = known->kind;
  if (file.kind != FileKind::Truth) {
    const bool gps = file.kind == FileKind::Gps;
    const std::string key = gps ? "station" : "sensor";
    const NameOrColumn source = read_name(section, key);
    if (source.name.empty() && !source.column) {
      section.fail(key, std::string("missing: the ") +
                            (gps                            ? "telemetry station"
                             : file.kind == FileKind::Radar ? "radar"
                                                            : "tracker") +
                            "'s name, or {column = ...}: the column that says it");
    }
    file.source = source.name;
    file.source_column = source.column;
  }
  if (file.kind == FileKind::Gps) {
    const NameOrColumn receiver = read_name(section, "receiver");
    file.receiver = receiver.name;
    file.receiver_column = receiver.column;
  }
  const NameOrColumn own_target = read_name(section, "target");
  file.target_column = own_target.column;
  file.target = own_target.name.empty() ? target.value_or(Name()) : own_target.name;
  if (file.target.empty() && !file.target_column) section.fail("target", "missing here and at the top of the file");
}

void read_filter(MappingSection section, FileMapping& file) {
  RowFilter filter;
  filter.column = section.required_text("column", "whose value decides");
  const auto equals = section.texts("equals", true);
  const auto differs = section.texts("differs", true);
  if (equals.has_value() == differs.has_value())
    section.fail("equals", "needed, or differs: a value or a list of them");
  filter.equals = equals.has_value();
  filter.texts = equals ? *equals : *differs;
  section.no_other_keys();
  file.filters.push_back(std::move(filter));
}

void read_filters(MappingSection& section, FileMapping& file) {
  const toml::node* node = section.find("where");
  if (node == nullptr) return;
  const std::string prefix = section.prefix() + "where.";
  if (const toml::table* table = node->as_table()) return read_filter({section.file(), *table, prefix}, file);
  const toml::array* list = node->as_array();
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const toml::table* table = list->get(i)->as_table();
    if (table == nullptr) list = nullptr;
    if (table != nullptr) read_filter({section.file(), *table, prefix}, file);
  }
  if (list == nullptr) section.fail("where", "must be {column = ..., equals = ...} or a list of such");
}

void read_format(MappingSection& section, FileMapping& file) {
  if (const auto delimiter = section.text("delimiter")) {
    if (*delimiter == "blanks" || *delimiter == " ") {
      file.delimiter = blanks;
    } else if (*delimiter == "tab") {
      file.delimiter = '\t';
    } else if (delimiter->size() == 1 && (*delimiter)[0] != '"' && (*delimiter)[0] != '\n') {
      file.delimiter = (*delimiter)[0];
    } else {
      section.fail("delimiter", "must be one character, \"tab\" or \"blanks\"");
    }
  }
  if (const auto decimal = section.text("decimal")) {
    if (*decimal != "." && *decimal != ",") section.fail("decimal", "must be \".\" or \",\"");
    file.decimal = *decimal == "," ? DecimalMark::Comma : DecimalMark::Point;
    if (file.decimal == DecimalMark::Comma && file.delimiter == ',') {
      section.fail("decimal", "a comma cannot be delimiter and decimal mark");
    }
  }
  if (const auto lines = section.number("skip_lines")) {
    if (*lines < 0 || *lines > 1e6 || *lines != std::floor(*lines)) section.fail("skip_lines", "must be 0 to 1000000");
    file.skip_lines = static_cast<std::uint64_t>(*lines);
  }
  file.comments = section.texts("comment");
  file.header = section.flag("header").value_or(true);
  file.missing = section.texts("missing", true).value_or(std::vector<std::string>());
  read_filters(section, file);
  if (const auto others = section.text("other_columns")) {
    if (*others != "ignore") section.fail("other_columns", "'" + *others + "'; allowed: ignore");
    file.ignore_others = true;
  }
}

void read_times(MappingSection& section, FileMapping& file) {
  if (const auto latency = section.number("latency_s")) {
    if (*latency < 0 || *latency > 3600) section.fail("latency_s", "must be 0 to 3600");
    file.latency = seconds(*latency);
  }
  if (const auto scale = section.text("time_scale")) {
    constexpr std::array<std::pair<std::string_view, TimeScale>, 3> names{
        {{"UTC", TimeScale::Utc}, {"GPS", TimeScale::Gps}, {"TAI", TimeScale::Tai}}};
    const auto* found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == *scale; });
    if (found == names.end()) section.fail("time_scale", "'" + *scale + "'; allowed: UTC, GPS, TAI");
    file.scale = found->second;
  }
  if (const toml::node* date = section.find("date")) {
    const auto day = date->value_exact<toml::date>();
    file.date = day ? time_of(*day) : std::nullopt;
    if (!file.date) section.fail("date", "must be a date, e.g. 2025-03-04, from 1800 to 2160");
  }
  if (const auto wrap = section.number("wrap_s")) {
    if (*wrap != 0 && (*wrap < 1 || *wrap > 1e8)) section.fail("wrap_s", "must be 0, or 1 to 100000000");
    file.wrap = seconds(*wrap);
  }
  if (const auto order = section.text("date_order")) {
    constexpr std::array<std::pair<std::string_view, DateOrder>, 3> names{
        {{"ymd", DateOrder::YearFirst}, {"dmy", DateOrder::DayFirst}, {"mdy", DateOrder::MonthFirst}}};
    const auto* found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == *order; });
    if (found == names.end()) section.fail("date_order", "'" + *order + "'; allowed: ymd, dmy, mdy");
    file.date_order = found->second;
  }
  file.sort = section.flag("sort");
  file.accept_implausible = section.flag("accept_implausible").value_or(false);
}

void read_columns(MappingSection& section, FileMapping& file) {
  const toml::node* columns = section.find("columns");
  if (columns == nullptr || !columns->is_table()) section.fail("columns", "missing: a table of the file's columns");
  const std::string prefix = section.prefix() + "columns.";
  for (const auto& [key, node] : *columns->as_table()) {
    const std::string column(key.str());
    if (const auto* table = node.as_table()) {
      MappingSection inner(section.file(), *table, prefix + column + '.');
      const auto place = read_place(inner);
      // A place alone: for a filter or a name.
      if (!place || table->contains("field")) file.columns.push_back(read_column(inner, column, file.kind));
      inner.no_other_keys();
      if (place) file.fixed.push_back({column, *place});
    } else if (node.value<std::string>() == "ignore") {
      file.ignored.push_back(column);
    } else {
      MappingSection(section.file(), *columns->as_table(), prefix)
          .fail(column, "must be \"ignore\" or {field = ..., unit = ...}");
    }
  }
}

/// Columns stand at places, all of them, or between delimiters.
void check_places(MappingSection& section, const FileMapping& file) {
  if (file.fixed.empty()) return;
  const auto placed = [&](const std::string& column) {
    return std::any_of(file.fixed.begin(), file.fixed.end(), [&](const FixedColumn& c) { return c.name == column; });
  };
  const auto check = [&](const std::string& column) {
    if (!placed(column)) section.fail("columns", "'" + column + "' has no at = [first, last], and others have");
  };
  for (const ColumnMapping& column : file.columns) check(column.column);
  for (const RowFilter& filter : file.filters) check(filter.column);
  for (const NameColumn* name : file.name_columns()) check(name->column);
  if (file.delimiter) section.fail("delimiter", "has no meaning where columns stand at places (at)");
}

void check_times(MappingSection& section, const FileMapping& file) {
  if (file.kind != FileKind::Truth && file.latency.has_value() == file.has(Field::Received)) {
    section.fail("latency_s", "needed where no column is 'received', and only there");
  }
  const auto is_time = [](const ColumnMapping& c) { return c.field == Field::Epoch || c.field == Field::Received; };
  // Without since: the cells may be dates.
  const auto from_liftoff = [&](const ColumnMapping& c) {
    return is_time(c) && !c.text && !c.packed && c.since == Since::Liftoff;
  };
  if (file.scale != TimeScale::Utc && std::any_of(file.columns.begin(), file.columns.end(), from_liftoff)) {
    section.fail(
        "time_scale",
        "found since = \"liftoff\", which is the same on every scale; leave one of the two out (dates need no since)");
  }
}

FileMapping read_file(const std::filesystem::path& mapping_file, const toml::table& table, std::size_t index,
                      const std::filesystem::path& folder, const std::optional<Name>& target) {
  MappingSection section(mapping_file, table, "file[" + std::to_string(index) + "].");
  FileMapping file;
  file.path = (folder / section.required_text("path", "the CSV file")).lexically_normal();
  read_kind_and_names(section, target, file);
  const std::string format = section.text("format").value_or("table");
  if (format != "table" && format != "nmea") section.fail("format", "'" + format + "'; allowed: table, nmea");
  read_times(section, file);
  if (format == "nmea") {
    if (file.kind != FileKind::Gps) section.fail("format", "nmea is of kind gps only");
    declare_nmea(file);
  } else {
    read_format(section, file);
    read_columns(section, file);
  }
  check_fields(section, file);
  check_times(section, file);
  check_places(section, file);
  section.no_other_keys();
  return file;
}

}  // namespace

const ColumnMapping* FileMapping::column_of(Field field) const {
  const auto found = std::ranges::find(columns, field, &ColumnMapping::field);
  return found == columns.end() ? nullptr : &*found;
}

std::vector<const NameColumn*> FileMapping::name_columns() const {
  std::vector<const NameColumn*> found;
  for (const auto* column : {&source_column, &receiver_column, &target_column}) {
    if (*column) found.push_back(&**column);
  }
  return found;
}

ImportMapping load_mapping(const std::filesystem::path& file, const std::optional<std::filesystem::path>& folder) {
  ImportMapping mapping;
  toml::table table;
  try {
    mapping.text = text::read_file(file, text::max_toml_size);
    table = text::parse_toml(mapping.text);
  } catch (const text::FileError& error) {
    throw ImportError(file.string() + ": cannot open the mapping: " + error.what());
  } catch (const text::TomlError& error) {
    throw ImportError(file.string() + ":" + std::to_string(error.line()) + ": " + error.what());
  }

  MappingSection section(file, table, "");
  mapping.mission = section.required_name("mission", "the flight's name");
  mapping.liftoff = liftoff_of(section);
  if (const auto leap_seconds = section.number("leap_seconds")) {
    if (*leap_seconds != std::floor(*leap_seconds) || *leap_seconds < 0 || *leap_seconds > 100) {
      section.fail("leap_seconds", "must be a whole number, 0 to 100: GPS time minus UTC");
    }
    mapping.leap_seconds = static_cast<int>(*leap_seconds);
  }
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
