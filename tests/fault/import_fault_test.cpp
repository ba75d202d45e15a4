// Spoilt tables and mappings: imported, or refused with an error of ours; never a crash, never another exception.

#include <random>

#include "archive_import_testing.hpp"

namespace downrange::archive {
namespace {

constexpr const char* good_mapping =
    "mission = \"m\"\ntarget = \"t\"\nliftoff = 2018-02-06T20:45:00Z\n[[file]]\npath = \"r.csv\"\nkind = \"radar\"\n"
    "sensor = \"ra\"\nwhere = {column = \"TRK\", equals = 1}\nmissing = [\"-999\"]\n[file.columns]\n"
    "time = {field = \"epoch\", unit = \"s\", since = \"midnight\"}\nrecv = {field = \"received\", unit = \"text\"}\n"
    "rng = {field = \"range\", unit = \"m\"}\naz = {field = \"azimuth\", unit = \"deg\"}\n"
    "el = {field = \"elevation\", unit = \"deg\"}\nm = {field = \"mode\", values = {A = \"track\", \"*\" = "
    "\"coast\"}}\n";

std::string good_table() {
  std::string text = "# radar A\ntime,recv,rng,az,el,m,TRK\n";
  for (int i = 0; i < 10; ++i) {
    char row[160];
    std::snprintf(row, sizeof row, "20:45:1%d.5,2018-02-06T20:45:1%d.550Z,\"12,%03d.0\",+120.%d,1.0E+01,A,1\n", i, i,
                  30 * i, i);
    text += row;
  }
  return text;
}

class ImportFault : public ArchiveImport {
 protected:
  void try_import(const std::string& mapping, const std::string& table) {
    write_text(folder_ / "map.toml", mapping);
    write_text(folder_ / "r.csv", table);
    ImportOptions options;
    options.writer.overwrite = true;
    try {
      const ImportReport report = import_csv(folder_ / "map.toml", folder_ / "out.mcap", options);
      for (const FileReport& file : report.files) EXPECT_GT(file.imported, 0u);
      ++imported_;
    } catch (const ImportError& error) {
      EXPECT_NE(std::string(error.what()), "");
      ++refused_;
    }
  }
  int imported_ = 0;
  int refused_ = 0;
};

/// Deletes, doubles, exchanges or replaces a piece of the text.
std::string spoilt(std::string text, std::mt19937_64& random) {
  constexpr std::string_view pieces[] = {",",
                                         ";",
                                         "\t",
                                         "\"",
                                         "\r",
                                         "\n",
                                         "\0",
                                         "#",
                                         "-",
                                         "1e308",
                                         "nan",
                                         ".",
                                         ":",
                                         "T",
                                         " ",
                                         "\xFF",
                                         "\xFE",
                                         "\xC3",
                                         "9999999999999999999",
                                         "[",
                                         "{",
                                         "="};
  const auto at = [&] { return static_cast<std::size_t>(random() % (text.size() + 1)); };
  for (std::uint64_t i = 0, count = 1 + random() % 4; i < count; ++i) {
    const std::size_t from = at();
    const std::size_t size = std::min<std::size_t>(random() % 20, text.size() - from);
    switch (random() % 4) {
      case 0:
        text.erase(from, size);
        break;
      case 1:
        text.insert(at(), text.substr(from, size));
        break;
      case 2:
        text.insert(from, pieces[random() % std::size(pieces)]);
        break;
      default:
        if (from < text.size()) text[from] = static_cast<char>(random());
    }
  }
  return text;
}

TEST_F(ImportFault, ASpoiltTableIsImportedOrRefused) {
  constexpr std::uint64_t seed = 8;
  std::mt19937_64 random(seed);
  try_import(good_mapping, good_table());
  ASSERT_EQ(imported_, 1);
  for (int i = 0; i < 400; ++i) try_import(good_mapping, spoilt(good_table(), random));
  EXPECT_GT(imported_, 50);
  EXPECT_GT(refused_, 5);
}

TEST_F(ImportFault, ASpoiltMappingIsImportedOrRefused) {
  constexpr std::uint64_t seed = 16;
  std::mt19937_64 random(seed);
  for (int i = 0; i < 400; ++i) try_import(spoilt(good_mapping, random), good_table());
  EXPECT_GT(imported_, 0);
  EXPECT_GT(refused_, 100);
}

TEST_F(ImportFault, EveryPrefixOfATableIsImportedOrRefused) {
  const std::string whole = good_table();
  for (std::size_t size = 0; size < whole.size(); size += 7) try_import(good_mapping, whole.substr(0, size));
  EXPECT_GT(imported_, 50);
}

}  // namespace
}  // namespace downrange::archive
