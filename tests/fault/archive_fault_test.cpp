// Crashes, full disks, flipped bits: an archive tells what happened to it, and gives back all that is whole.

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <archive/lasting_writer.hpp>
#include <fstream>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

class ArchiveFault : public testing::TestWithParam<Compression> {
 protected:
  /// Two chunks with every kind of record, small enough to break at every byte.
  std::filesystem::path sound_file() {
    WriterOptions options;
    options.compression = GetParam();
    Writer writer(folder_ / "sound.mcap", options);
    write_all_kinds(writer);
    writer.flush();
    for (std::uint64_t i = 0; i < 5; ++i) writer.write(Event(some_radar(100 + i)));
    EXPECT_TRUE(writer.close().ok());
    return folder_ / "sound.mcap";
  }

  struct Outcome {
    std::size_t records = 0;
    std::size_t bad_records = 0;
    bool truncated = false;
    bool error = false;
  };
  Outcome read(const std::filesystem::path& path) {
    Outcome outcome;
    try {
      Reader reader(path);
      while (const auto entry = reader.next()) {
        ++(std::holds_alternative<BadRecord>(entry->record) ? outcome.bad_records : outcome.records);
      }
      outcome.truncated = reader.truncated().has_value();
      if (outcome.truncated) {
        EXPECT_LE(reader.truncated()->offset, std::filesystem::file_size(path));
      }
    } catch (const ArchiveError&) {
      outcome.error = true;
    }
    return outcome;
  }

  TemporaryFolder folder_;
};

constexpr std::size_t all_records = all_kinds_count + 5;

TEST_P(ArchiveFault, CutOffAnywhereGivesAPrefix) {
  const auto file = sound_file();
  ASSERT_EQ(read(file).records, all_records);
  ASSERT_FALSE(read(file).truncated);
  std::size_t longer = all_records;
  for (std::uintmax_t size = std::filesystem::file_size(file); size-- > 0;) {
    std::filesystem::resize_file(file, size);
    const Outcome outcome = read(file);
    ASSERT_TRUE(outcome.truncated) << "cut at byte " << size;
    ASSERT_FALSE(outcome.error) << "cut at byte " << size;
    ASSERT_EQ(outcome.bad_records, 0u);
    ASSERT_TRUE(outcome.records == 0 || outcome.records == all_kinds_count || outcome.records == all_records);
    ASSERT_LE(outcome.records, longer) << "a shorter file gives less";
    longer = outcome.records;
  }
  EXPECT_EQ(longer, 0u);
}

/// No flipped bit shortens the file: none may pass for a crash, whose loss is taken as it is.
TEST_P(ArchiveFault, EveryFlippedBitIsDamage) {
  const auto path = sound_file();
  const Bytes sound = read_bytes(path);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const auto put_byte = [&](std::size_t at, int value) {
    file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(value)).flush();
  };
  for (std::size_t at = 0; at < sound.size(); ++at) {
    put_byte(at, sound[at] ^ (1 << (at % 8)));
    const Outcome outcome = read(path);
    ASSERT_TRUE(outcome.error && !outcome.truncated) << "bit " << at % 8 << " of byte " << at << " of " << sound.size();
    put_byte(at, sound[at]);
  }
  EXPECT_EQ(read(path).records, all_records);
}

TEST_P(ArchiveFault, ZerosAfterAPowerFailureAreAnEnd) {
  const auto path = sound_file();
  const auto size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, 8 + 9 + 4 + 4 + std::string("downrange 0.1.0").size());  // magic and header
  std::filesystem::resize_file(path, size);
  const Outcome outcome = read(path);
  EXPECT_TRUE(outcome.truncated);
  EXPECT_EQ(outcome.records, 0u);
}

TEST_P(ArchiveFault, ZerosBeforeTheEndAreDamage) {
  const auto path = sound_file();
  const std::streamoff header_end = 8 + 9 + 4 + 4 + static_cast<std::streamoff>(std::string("downrange 0.1.0").size());
  std::fstream(path, std::ios::binary | std::ios::in | std::ios::out).seekp(header_end).write("\0\0\0\0\0\0\0\0\0", 9);
  const Outcome outcome = read(path);
  EXPECT_TRUE(outcome.error);
  EXPECT_FALSE(outcome.truncated);
}

INSTANTIATE_TEST_SUITE_P(Compressions, ArchiveFault,
                         testing::Values(Compression::None, Compression::Zstd, Compression::Lz4));

TEST(ArchiveDisk, FullAtTheStartIsAnException) {
  WriterOptions options;
  options.overwrite = true;
  try {
    Writer writer("/dev/full", options);
    FAIL() << "a full disk was not noticed";
  } catch (const ArchiveError& error) {
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos) << error.what();
  }
}

/// A file size limit stands for the full disk; it holds for the whole process, so a child takes it.
TEST(ArchiveDisk, FullInFlightIsAStatusAndEveryLossIsCounted) {
  const TemporaryFolder folder;
  const auto path = folder / "full.mcap";
  constexpr std::uint64_t plots = 5000;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit limit{100'000, 100'000};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    WriterOptions options;
    options.compression = Compression::None;
    Writer writer(path, options);
    for (std::uint64_t i = 0; i < plots; ++i) writer.write(Event(some_radar(i)));
    const WriterStatus status = writer.close();
    const bool told = !status.ok() && writer.failed() && status.failure.find("File too large") != std::string::npos &&
                      status.failure.find(path.string()) != std::string::npos;
    const bool counted = status.messages_written + status.messages_lost == plots && status.messages_written > 0;
    ::_exit(told && counted ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);

  Reader reader(path);
  const auto entries = read_all(reader);
  EXPECT_GT(entries.size(), 0u);
  EXPECT_LT(entries.size(), plots);
  EXPECT_TRUE(reader.truncated());
}

TEST(ArchiveDisk, AKilledProcessLosesAtMostASecond) {
  const TemporaryFolder folder;
  const auto path = folder / "killed.mcap";
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  constexpr std::uint64_t plots = 205;  // 20 per second: ten closed seconds and a quarter
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Writer writer(path);
    for (std::uint64_t i = 0; i < plots; ++i) writer.write(Event(some_radar(i)));
    while (writer.status().chunks_written < 10 && !writer.failed()) ::usleep(1000);
    if (::write(ready[1], "x", 1) != 1) ::_exit(1);
    for (;;) ::pause();
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  ::close(ready[0]);
  ::close(ready[1]);

  Reader reader(path);
  EXPECT_EQ(read_all(reader).size(), 200u);
  EXPECT_TRUE(reader.truncated());
}

/// A pipe that nobody reads yet is the slow disk.
TEST(ArchiveDisk, ASlowDiskCostsTheChunkNotTheEngine) {
  const TemporaryFolder folder;
  const auto path = folder / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader_end = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader_end, 0);

  WriterOptions options;
  options.overwrite = true;
  options.compression = Compression::None;
  options.queue_chunks = 2;
  options.backlog = Backlog::Drop;
  Writer writer(path, options);
  constexpr std::uint64_t plots = 4000;
  for (std::uint64_t i = 0; i < plots; ++i) writer.write(Event(some_radar(i)));  // returns, though nothing drains
  EXPECT_GT(writer.status().messages_lost, 0u);
  EXPECT_FALSE(writer.failed());
  EXPECT_FALSE(writer.status().ok());

  std::thread drain([&] {
    Bytes buffer(1 << 16);
    ssize_t got = 0;
    ::fcntl(reader_end, F_SETFL, 0);
    do got = ::read(reader_end, buffer.data(), buffer.size());
    while (got > 0);
  });
  const WriterStatus status = writer.close();
  drain.join();
  ::close(reader_end);
  EXPECT_EQ(status.messages_written + status.messages_lost, plots);
  EXPECT_EQ(status.failure, "");
}

/// Plots into a file whose folder is not safe.
class LastingArchive : public testing::Test {
 protected:
  void record(std::uint64_t plots) {
    for (std::uint64_t i = 0; i < plots; ++i) archive_.writer().write(Event(some_radar(i)));
  }
  [[nodiscard]] static std::size_t plots_in(const std::filesystem::path& path) {
    Reader reader(path);
    const std::vector<Entry> entries = read_all(reader);
    EXPECT_FALSE(reader.truncated());
    return entries.size();
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / ("flights/" + name); }

  TemporaryFolder folder_;
  bool made_ = std::filesystem::create_directory(folder_ / "flights");
  LastingWriter archive_{file("flight.mcap"), {}, [](Writer& writer, const std::filesystem::path& continues) {
                           writer.metadata("downrange", {{"continues", continues.string()}});
                         }};
};

TEST_F(LastingArchive, StaysInItsFileWhileThatIsThere) {
  record(10);
  EXPECT_FALSE(archive_.look());
  record(10);
  EXPECT_TRUE(archive_.writer().close().ok());
  EXPECT_EQ(archive_.path(), file("flight.mcap"));
  EXPECT_EQ(plots_in(file("flight.mcap")), 20U);
}

TEST_F(LastingArchive, GoesOnInANewFileWhenItsOwnIsRemoved) {
  record(10);
  std::filesystem::remove(file("flight.mcap"));
  EXPECT_EQ(archive_.look().value_or(""), file("flight.mcap").string() +
                                              " was removed or replaced while it was written: recording goes on in " +
                                              file("flight-2.mcap").string());
  EXPECT_FALSE(archive_.look());
  record(5);
  EXPECT_TRUE(archive_.writer().close().ok());
  EXPECT_EQ(plots_in(file("flight-2.mcap")), 5U);
  EXPECT_FALSE(std::filesystem::exists(file("flight.mcap")));
  Reader reader(file("flight-2.mcap"));
  static_cast<void>(read_all(reader));
  EXPECT_EQ(reader.raw().metadata().at("downrange").at("continues"), file("flight.mcap").string());
}

TEST_F(LastingArchive, WritesOverNoFileThatTookItsPlace) {
  std::ofstream(file("flight-2.mcap")) << "another's";
  std::ofstream(file("new")) << "a stranger's";
  std::filesystem::rename(file("new"), file("flight.mcap"));
  EXPECT_TRUE(archive_.look());
  EXPECT_EQ(archive_.path(), file("flight-3.mcap"));
  EXPECT_EQ(std::filesystem::file_size(file("flight-2.mcap")), 9U);
  EXPECT_EQ(std::filesystem::file_size(file("flight.mcap")), 12U);
}

TEST_F(LastingArchive, MakesItsFolderAnew) {
  std::filesystem::remove_all(folder_ / "flights");
  EXPECT_TRUE(archive_.look());
  record(5);
  EXPECT_TRUE(archive_.writer().close().ok());
  EXPECT_EQ(plots_in(archive_.path()), 5U);
}

TEST_F(LastingArchive, SaysOnceWhyItCannotGoOnAndTriesAgain) {
  std::filesystem::remove_all(folder_ / "flights");
  std::ofstream(folder_ / "flights") << "a file in the folder's place";
  EXPECT_NE(archive_.look().value_or("").find("cannot create the archive"), std::string::npos);
  EXPECT_FALSE(archive_.look());
  EXPECT_FALSE(archive_.writer().in_place());
  std::filesystem::remove(folder_ / "flights");
  EXPECT_NE(archive_.look().value_or("").find("goes on in"), std::string::npos);
  EXPECT_TRUE(archive_.writer().in_place());
}

/// "10 in flight.mcap, 5 lost with flight-2.mcap"
std::string account_of(const std::vector<WrittenFile>& files) {
  std::string text;
  for (const WrittenFile& file : files) {
    EXPECT_EQ(file.messages_kept() + file.messages_lost(), file.status.messages_written + file.status.messages_lost);
    text += (text.empty() ? "" : ", ") + std::to_string(file.status.messages_written) +
            (file.kept ? " in " : " lost with ") + file.path.filename().string();
  }
  return text;
}

TEST_F(LastingArchive, TellsHowManyMessagesAreInWhichFile) {
  record(10);
  EXPECT_EQ(account_of(archive_.close()), "10 in flight.mcap");
}

TEST_F(LastingArchive, CountsWhatWasWrittenToARemovedFile) {
  record(10);
  std::filesystem::remove(file("flight.mcap"));
  record(3);  // before that is seen
  EXPECT_TRUE(archive_.look());
  record(5);
  EXPECT_EQ(account_of(archive_.close()), "13 lost with flight.mcap, 5 in flight-2.mcap");
}

TEST_F(LastingArchive, FindsAFileThatWasMoved) {
  record(10);
  std::filesystem::rename(file("flight.mcap"), file("elsewhere.mcap"));
  record(3);
  EXPECT_TRUE(archive_.look());
  record(5);
  EXPECT_EQ(account_of(archive_.close()), "13 in elsewhere.mcap, 5 in flight-2.mcap");
  EXPECT_EQ(plots_in(file("elsewhere.mcap")), 13U);
}

TEST_F(LastingArchive, CountsTheTimeWithoutAFile) {
  record(10);
  std::filesystem::rename(file("flight.mcap"), file("elsewhere.mcap"));
  EXPECT_TRUE(archive_.look());
  record(5);
  std::filesystem::remove_all(folder_ / "flights");
  std::ofstream(folder_ / "flights") << "a file in the folder's place";
  EXPECT_TRUE(archive_.look());
  record(7);
  EXPECT_FALSE(archive_.look());
  std::filesystem::remove(folder_ / "flights");
  EXPECT_TRUE(archive_.look());
  record(4);
  EXPECT_EQ(account_of(archive_.close()),
            "10 lost with elsewhere.mcap, 12 lost with flight-2.mcap, 4 in flight-2.mcap");
}

}  // namespace
}  // namespace downrange::archive
