#include <algorithm>
#include <archive/import/name_parts.hpp>
#include <archive/import/source_text.hpp>
#include <archive/import/table_reader.hpp>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

/// A column of numbers taken for one of names has more.
constexpr std::size_t most_parts = 64;

class Parts {
 public:
  explicit Parts(const FileMapping& mapping) : mapping_(mapping), columns_(mapping.name_columns()) {}

  NameParts run() {
    const SourceText source = read_source(mapping_.path);
    TableReader table(mapping_, source.text);
    while (table.next()) note_row(table);
    if (cells_.empty()) fail(0, "no row says a name in column " + text::in_quotes(columns_.front()->column));
    for (std::size_t i = 0; i < cells_.size(); ++i) add_part(i);
    return std::move(parts_);
  }

 private:
  [[noreturn]] void fail(std::uint64_t line, const std::string& what) const {
    throw ImportError(mapping_.path.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what);
  }

  void note_row(const TableReader& table) {
    std::vector<std::string> cells;
    for (const std::size_t place : table.name_places()) {
      if (place >= table.fields().size()) return;  // too short a row: counted as such when the part is read
      cells.emplace_back(table.fields()[place]);
    }
    if (std::any_of(cells.begin(), cells.end(), [](const std::string& c) { return is_no_value(c); })) {
      ++parts_.unnamed;
      return;
    }
    if (std::find(cells_.begin(), cells_.end(), cells) != cells_.end()) return;
    if (cells_.size() == most_parts) {
      fail(table.line(), "column " + text::in_quotes(columns_.front()->column) + " says more than " +
                             std::to_string(most_parts) + " names: is it the right one?");
    }
    std::vector<Name> names;
    for (std::size_t i = 0; i < cells.size(); ++i) names.push_back(name_of(*columns_[i], cells[i], table.line()));
    cells_.push_back(std::move(cells));
    names_.push_back(std::move(names));
  }

  [[nodiscard]] Name name_of(const NameColumn& column, const std::string& cell, std::uint64_t line) const {
    const auto found =
        std::find_if(column.names.begin(), column.names.end(), [&](const auto& n) { return n.first == cell; });
    if (found != column.names.end()) return found->second;
    const auto own = column.names.empty() ? Name::parse(cell) : std::nullopt;
    if (!own || own->empty()) {
      fail(line,
           "column " + text::in_quotes(column.column) + ": " + text::in_quotes(cell) +
               (column.names.empty() ? " is no name of 1 to 31 characters; write names = {\""
                                     : " is not among its names; leave its rows out (where) or write names = {\"") +
               text::printable(cell, false, 40) + "\" = ...}");
    }
    return *own;
  }

  void add_part(std::size_t index) {
    FileMapping file = mapping_;
    std::size_t at = 0;
    std::string rows;
    const auto from_its_row = [&](std::optional<NameColumn>& column, Name& name) {
      if (!column) return;
      name = names_[index][at];
      file.filters.push_back({column->column, {cells_[index][at]}, true, true});
      rows += (rows.empty() ? "" : ", ") + column->column + " = " + cells_[index][at];
      column.reset();
      ++at;
    };
    from_its_row(file.source_column, file.source);
    from_its_row(file.receiver_column, file.receiver);
    from_its_row(file.target_column, file.target);
    file.first_of_names = index == 0;
    parts_.files.push_back(std::move(file));
    parts_.rows.push_back(rows);
  }

  const FileMapping& mapping_;
  std::vector<const NameColumn*> columns_;
  std::vector<std::vector<std::string>> cells_;  ///< of each part, in the order of columns_
  std::vector<std::vector<Name>> names_;
  NameParts parts_;
};

}  // namespace

NameParts parts_by_name(const FileMapping& mapping) {
  if (mapping.name_columns().empty()) return {{mapping}, {""}, 0};
  return Parts(mapping).run();
}

}  // namespace downrange::archive
