/// An archive has its name when it is whole, and what fails leaves things as they were.
#include <archive/new_archive.hpp>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

namespace fs = std::filesystem;

class NewArchiveTest : public testing::Test {
 protected:
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator((folder_ / "x").parent_path()), fs::directory_iterator()));
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "flight.mcap";
};

TEST_F(NewArchiveTest, AppearsWhenItIsWhole) {
  NewArchive archive(path_);
  archive.writer().write(Event(test::sample<RadarTspi>()));
  archive.writer().flush();
  EXPECT_FALSE(fs::exists(path_));
  ASSERT_TRUE(archive.close().ok());
  EXPECT_EQ(files(), 1u);
  Reader reader(path_);
  const auto entry = reader.next();
  ASSERT_TRUE(entry);
  EXPECT_EQ(std::get<RadarTspi>(entry->record), test::sample<RadarTspi>());
}

TEST_F(NewArchiveTest, WithoutACloseNothingIsLeftAndWhatWasThereStays) {
  { NewArchive archive(path_); }
  EXPECT_EQ(files(), 0u);
  std::ofstream(path_) << "older";
  {
    NewArchive archive(path_, {.overwrite = true});
    archive.writer().write(Event(test::sample<RadarTspi>()));
  }
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(fs::file_size(path_), 5u);
}

TEST_F(NewArchiveTest, AFileThatExistsIsWrittenOverOnlyOnDemand) {
  std::ofstream(path_) << "older";
  EXPECT_THROW(NewArchive{path_}, ArchiveError);
  NewArchive archive(path_, {.overwrite = true});
  ASSERT_TRUE(archive.close().ok());
  EXPECT_NE(fs::file_size(path_), 5u);
}

TEST_F(NewArchiveTest, AFileThatCameMeanwhileIsKept) {
  NewArchive archive(path_);
  std::ofstream(path_) << "meanwhile";
  const WriterStatus status = archive.close();
  EXPECT_FALSE(status.ok());
  EXPECT_NE(status.failure.find("flight.mcap: cannot be named so: File exists; nothing of it is kept"),
            std::string::npos)
      << status.failure;
  EXPECT_EQ(fs::file_size(path_), 9u);
  EXPECT_EQ(files(), 1u);
}

TEST_F(NewArchiveTest, ALinkStaysALinkAndADeviceADevice) {
  const fs::path target = folder_ / "target.mcap";
  std::ofstream(target) << "older";
  fs::create_symlink(target, path_);
  NewArchive archive(path_, {.overwrite = true});
  ASSERT_TRUE(archive.close().ok());
  EXPECT_TRUE(fs::is_symlink(path_));
  EXPECT_NE(fs::file_size(target), 5u);

  NewArchive nowhere("/dev/null", {.overwrite = true});
  EXPECT_TRUE(nowhere.close().ok());
  EXPECT_FALSE(fs::exists("/dev/null.part"));
}

}  // namespace
}  // namespace downrange::archive
