// Chunks as writers of all kinds compress them, and as nobody does: one frame, several, none, and bombs.

#include <archive/compression.hpp>
#include <archive/mcap.hpp>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Bytes compressed(Compression compression, std::initializer_list<std::string_view> frames) {
  Compressor compressor(compression);
  Bytes out;
  for (const std::string_view frame : frames) compressor.compress(bytes_of(frame), out);
  return out;
}

class ArchiveCompression : public testing::TestWithParam<Compression> {
 protected:
  /// What decompressing into `size` bytes gives; "!" and the reason where it is refused.
  std::string read(ByteView in, std::size_t size) {
    Bytes out(size);
    if (const auto wrong = decompress(GetParam(), in, out)) return "!" + *wrong;
    return {out.begin(), out.end()};
  }
};

TEST_P(ArchiveCompression, ReadsAnyNumberOfFrames) {
  EXPECT_EQ(read(compressed(GetParam(), {"one"}), 3), "one");
  EXPECT_EQ(read(compressed(GetParam(), {"one", "two"}), 6), "onetwo");
  EXPECT_EQ(read(compressed(GetParam(), {"", "one", "", "two", ""}), 6), "onetwo");
  EXPECT_EQ(read(compressed(GetParam(), {""}), 0), "");
  EXPECT_EQ(read({}, 0), "") << "a chunk of no bytes at all";
}

TEST_P(ArchiveCompression, ASizeOtherThanStatedIsRefused) {
  for (const std::size_t size : {0, 2, 4, 1000}) {
    EXPECT_EQ(read(compressed(GetParam(), {"one"}), size).front(), '!') << size;
    EXPECT_EQ(read(compressed(GetParam(), {"o", "ne"}), size).front(), '!') << size;
  }
  EXPECT_EQ(read({}, 1).front(), '!');
  Bytes cut = compressed(GetParam(), {"one"});
  cut.pop_back();
  EXPECT_EQ(read(cut, 3).front(), '!');
  EXPECT_EQ(read(bytes_of("no frame at all"), 3).front(), '!');
}

INSTANTIATE_TEST_SUITE_P(Compressions, ArchiveCompression, testing::Values(Compression::Zstd, Compression::Lz4));

/// An MCAP file made of records, without checksums.
class ArchiveBomb : public testing::Test {
 protected:
  static void put_chunk(Bytes& file, std::uint64_t stated_size, ByteView stored) {
    Bytes content;
    put(content, std::uint64_t{0});
    put(content, std::uint64_t{0});
    put(content, stated_size);
    put(content, std::uint32_t{0});
    put_string(content, "zstd");
    put(content, static_cast<std::uint64_t>(stored.size()));
    put_bytes(content, stored);
    put_record(file, Op::Chunk, content);
  }
  static Bytes channel(std::uint16_t id, std::size_t topic_size, std::size_t metadata_size) {
    Bytes metadata;
    if (metadata_size > 0) {
      put_string(metadata, "key");
      put_string(metadata, std::string(metadata_size, ' '));
    }
    Bytes content;
    put(content, id);
    put(content, std::uint16_t{0});
    put_string(content, std::string(topic_size, ' '));
    put_string(content, "protobuf");
    put(content, static_cast<std::uint32_t>(metadata.size()));
    put_bytes(content, metadata);
    Bytes record;
    put_record(record, Op::Channel, content);
    return record;
  }
  static Bytes start() {
    Bytes file(mcap_magic.begin(), mcap_magic.end());
    Bytes header;
    put_string(header, "");
    put_string(header, "");
    put_record(file, Op::Header, header);
    return file;
  }
  /// Why reading the file is refused.
  std::string refusal(const Bytes& file) {
    write_bytes(folder_ / "bomb.mcap", file);
    try {
      RawReader reader(folder_ / "bomb.mcap");
      while (reader.next()) {
      }
    } catch (const ArchiveError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(ArchiveBomb, AChunkThatStatesMoreThanItCanHoldIsRefused) {
  const Bytes stored = compressed(Compression::Zstd, {std::string(32 << 20, ' ')});
  ASSERT_LT(stored.size(), 10'000u);
  Bytes file = start();
  put_chunk(file, 32 << 20, stored);
  EXPECT_NE(refusal(file).find("damaged at byte 25: chunk of 33554432 bytes made of "), std::string::npos)
      << refusal(file);
}

TEST_F(ArchiveBomb, NamesAndMetadataCannotFillTheMemory) {
  Bytes file = start();
  put_bytes(file, channel(1, 5000, 0));
  EXPECT_NE(refusal(file).find("a channel's name of 5000 bytes"), std::string::npos);

  // Twenty channels of a megabyte of metadata, in chunks of a few kilobytes each.
  file = start();
  for (std::uint16_t id = 0; id < 20; ++id) {
    const Bytes records = channel(id, 10, 1 << 20);
    Bytes stored;
    Compressor(Compression::Zstd).compress(records, stored);
    put_chunk(file, records.size(), stored);
  }
  ASSERT_LT(file.size(), 10'000u);
  EXPECT_NE(refusal(file).find("names and metadata of more than 16 MB"), std::string::npos) << refusal(file);

  // The same channel again and again is one channel.
  file = start();
  for (int i = 0; i < 20; ++i) put_bytes(file, channel(1, 10, 1 << 20));
  EXPECT_EQ(refusal(file), "");
}

}  // namespace
}  // namespace downrange::archive
