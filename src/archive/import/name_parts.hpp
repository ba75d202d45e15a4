#pragma once
/// A file whose rows say which sensor or target they are of, as one part for each.

#include <archive/import/mapping.hpp>
#include <string>
#include <vector>

namespace downrange::archive {

struct NameParts {
  std::vector<FileMapping>
      files;                      ///< in the order in which the file has them; the mapping itself where no column names
  std::vector<std::string> rows;  ///< of each: which rows it has, "RADAR = 1, OBJ = 7"; empty: all
  std::uint64_t unnamed = 0;      ///< rows without a name: in no part
};

/// Reads the file for the names. Throws ImportError, with file and line, for a cell that is no name, for more names
/// than a range has sources, and for a file of which no row says one.
[[nodiscard]] NameParts parts_by_name(const FileMapping& mapping);

}  // namespace downrange::archive
