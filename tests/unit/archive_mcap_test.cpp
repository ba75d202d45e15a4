// The container against the MCAP specification (mcap.dev/spec): bytes written here by hand from its tables, not by our
// own encoder.

#include <archive/compare.hpp>
#include <archive/mcap.hpp>
#include <archive/replay.hpp>
#include <functional>
#include <initializer_list>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

using namespace std::string_literals;

// Serialisation section of the specification: little-endian integers, uint32 length before strings and maps.
std::string le(std::uint64_t value, int size) {
  std::string out;
  for (int i = 0; i < size; ++i) out += static_cast<char>((value >> (8 * i)) & 0xFF);
  return out;
}
std::string str(const std::string& text) { return le(text.size(), 4) + text; }
std::string rec(int op, const std::string& content) { return le(op, 1) + le(content.size(), 8) + content; }

const std::string magic = "\x89MCAP0\r\n";
const std::string header = rec(0x01, str("") + str("by hand"));
const std::string schema = rec(0x03, le(7, 2) + str("a.B") + str("protobuf") + str("descriptor"));
const std::string channel =
    rec(0x04, le(258, 2) + le(7, 2) + str("some/topic") + str("protobuf") + str(str("k") + str("v")));
std::string message(std::uint64_t log_time, const std::string& data) {
  return rec(0x05, le(258, 2) + le(0xA1B2C3D4, 4) + le(log_time, 8) + le(log_time + 1, 8) + data);
}
std::string chunk(const std::string& records, std::uint32_t crc) {
  return rec(0x06,
             le(10, 8) + le(20, 8) + le(records.size(), 8) + le(crc, 4) + str("") + le(records.size(), 8) + records);
}
const std::string data_end = rec(0x0F, le(0, 4));
const std::string footer = rec(0x02, le(0, 8) + le(0, 8) + le(0, 4));

std::uint32_t crc_of(const std::string& text) {
  // Bit by bit from the polynomial of ISO 3309, so that the table-driven one is checked too.
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

ByteView view(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

class ArchiveMcap : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& bytes) {
    write_bytes(folder_ / "hand.mcap", view(bytes));
    return folder_ / "hand.mcap";
  }
  TemporaryFolder folder_;
};

// The check value of CRC-32 in every catalogue of checksums: "123456789" gives CBF43926.
TEST_F(ArchiveMcap, Crc32HasItsCheckValue) {
  EXPECT_EQ(crc32(view("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32(view("6789"), crc32(view("12345"))), 0xCBF43926U);
  EXPECT_EQ(crc_of("123456789"), 0xCBF43926U);
}

TEST_F(ArchiveMcap, ReadsTheSmallestFile) {
  RawReader reader(file(magic + header + data_end + footer + magic));
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.library(), "by hand");
}

TEST_F(ArchiveMcap, ReadsMessagesInAndOutsideChunks) {
  const std::string inside = schema + channel + message(10, "one") + message(20, "");
  RawReader reader(
      file(magic + header + chunk(inside, crc_of(inside)) + message(30, "loose") + data_end + footer + magic));

  auto found = reader.next();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->channel->id, 258);
  EXPECT_EQ(found->channel->topic, "some/topic");
  EXPECT_EQ(found->channel->schema, "a.B");
  EXPECT_EQ(found->channel->metadata.at("k"), "v");
  EXPECT_EQ(found->sequence, 0xA1B2C3D4U);
  EXPECT_EQ(found->log_time, 10u);
  EXPECT_EQ(found->publish_time, 11u);
  EXPECT_EQ(std::string(found->payload.begin(), found->payload.end()), "one");
  EXPECT_EQ(found->offset, magic.size() + header.size());
  found = reader.next();
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->payload.empty());
  found = reader.next();
  ASSERT_TRUE(found);
  EXPECT_EQ(std::string(found->payload.begin(), found->payload.end()), "loose");
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
}

TEST_F(ArchiveMcap, ReadsAttachmentsAndMetadata) {
  const std::string fields = le(5, 8) + le(6, 8) + str("n.txt") + str("text/plain") + le(4, 8) + "data";
  const std::string attachment = rec(0x09, fields + le(crc_of(fields), 4));
  const std::string metadata = rec(0x0C, str("m") + str(str("a") + str("1") + str("b") + str("2")));
  RawReader reader(file(magic + header + attachment + metadata + data_end + footer + magic));
  EXPECT_FALSE(reader.next());
  ASSERT_EQ(reader.attachments().size(), 1u);
  EXPECT_EQ(reader.attachments()[0].name, "n.txt");
  EXPECT_EQ(reader.attachments()[0].data, "data");
  EXPECT_EQ(reader.attachments()[0].log_time, 5u);
  EXPECT_EQ(reader.metadata().at("m").at("b"), "2");
}

// "Readers should ignore any unknown fields", and unknown records; a checksum of zero is not tested.
TEST_F(ArchiveMcap, PassesOverWhatItDoesNotKnow) {
  const std::string longer_schema = rec(0x03, le(7, 2) + str("a.B") + str("protobuf") + str("d") + "new field");
  const std::string inside = longer_schema + channel + message(1, "y");
  RawReader reader(file(magic + header + rec(0x90, "private") + chunk(inside, 0) + data_end + footer + magic));
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.skipped().unknown_records, 1u);
  EXPECT_NO_THROW(reader.require_declared());
}

/// What `read` throws.
std::string error_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const ArchiveError& error) {
    return error.what();
  }
  return "no error";
}

std::string orphan(int of_channel) {
  return rec(0x05, le(static_cast<std::uint64_t>(of_channel), 2) + le(1, 4) + le(1, 8) + le(1, 8) + "x");
}

// A message whose channel is not declared before it may be anything: whoever needs all of a file learns that some is
// lost, how much, and of which channel.
TEST_F(ArchiveMcap, MessagesOfUndeclaredChannelsAreSaid) {
  const std::string inside = orphan(99) + message(1, "early") + schema + channel + orphan(99) + message(1, "y");
  const auto path = file(magic + header + chunk(inside, 0) + orphan(7) + data_end + footer + magic);
  RawReader reader(path);
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.next());
  const std::string found = "1 message of channel 7, 2 messages of channel 99, 1 message of channel 258";
  EXPECT_EQ(reader.undeclared_messages(), found);
  const std::string said = path.string() + ": found " + found +
                           " that no Channel record before them declares, so what they hold cannot be read; "
                           "expected: none";
  EXPECT_EQ(error_of([&] { reader.require_declared(); }), said);
  for (const bool sort : {false, true}) {
    EventSource source(path, {.sort = sort});
    EXPECT_EQ(error_of([&] { static_cast<void>(source.next()); }), said);
  }
  EXPECT_EQ(error_of([&] { static_cast<void>(compare(path, path)); }), said);
  const std::string holds = error_of([&] { require_events(path); });
  EXPECT_NE(holds.find("it holds 1 messages of 'some/topic' ('a.B') and " + found + ", which no Channel record"),
            std::string::npos)
      << holds;
}

TEST_F(ArchiveMcap, UndeclaredChannelsAreNamedUpToFive) {
  std::string records;
  for (const int id : {1, 2, 3, 4, 5, 6, 7, 7}) records += orphan(id);
  RawReader reader(file(magic + header + records + data_end + footer + magic));
  EXPECT_FALSE(reader.next());
  const std::string found = reader.undeclared_messages();
  EXPECT_TRUE(found.ends_with(", 1 message of channel 5, 3 of other channels")) << found;
}

// Data where the specification has none would be lost without a word.
TEST_F(ArchiveMcap, RecordsInTheWrongPlaceAreDamage) {
  const std::string metadata = rec(0x0C, str("m") + str(""));
  const auto error = [&](const std::string& bytes) {
    RawReader reader(file(magic + header + bytes + footer + magic));
    return error_of([&] {
      while (reader.next()) {
      }
    });
  };
  const auto expect = [](const std::string& said, const std::string& what) {
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  const std::string nested = chunk(schema + channel + message(1, "y"), 0);
  expect(error(chunk(nested, 0) + data_end), "found a Chunk record inside a chunk, allowed there: schemas, channels");
  expect(error(chunk(metadata, 0) + data_end), "found a Metadata record inside a chunk");
  expect(error(data_end + nested), "found a Chunk record behind the end of the data, allowed there: the summary");
  expect(error(data_end + schema + channel + message(1, "y")), "found a Message record behind the end of the data");
  expect(error(chunk(rec(0x90, "private"), 0) + data_end + rec(0x90, "private")), "no error");
}

TEST_F(ArchiveMcap, ForeignChannelsAreCountedNotDecoded) {
  const std::string inside = schema + channel + message(1, "y");
  Reader reader(file(magic + header + chunk(inside, 0) + data_end + footer + magic));
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.skipped().foreign_messages, 1u);
  EXPECT_EQ(reader.foreign_channels(), (std::map<std::string, std::uint64_t>{{"'some/topic' ('a.B')", 1}}));
}

TEST_F(ArchiveMcap, RefusesWhatIsNotMcap) {
  EXPECT_THROW(RawReader(folder_ / "absent.mcap"), ArchiveError);
  EXPECT_THROW(RawReader{std::filesystem::temp_directory_path()}, ArchiveError);
  EXPECT_THROW(RawReader(file("time_s,recv_s\n0,1\n")), ArchiveError);
  EXPECT_THROW(RawReader(file("\x89MCAP1\r\n")), ArchiveError) << "another major version";
}

// Lengths that a damaged or hostile file may hold: an error or a cut-off, never a crash and never the memory they ask.
TEST_F(ArchiveMcap, HostileLengthsAreBounded) {
  constexpr std::uint64_t huge = 0x7FFF'FFFF'FFFF'FFFF;
  const auto records_read = [&](const std::string& bytes) {
    RawReader reader(file(magic + header + bytes));
    while (reader.next()) {
    }
    return reader.truncated().has_value();
  };
  for (const std::uint64_t size : {huge, huge * 2, huge * 2 + 1, std::uint64_t{1} << 32}) {
    EXPECT_TRUE(records_read("\x06"s + le(size, 8) + "abc")) << size;
    EXPECT_THROW(records_read(rec(0x06, le(0, 8) + le(0, 8) + le(size, 8) + le(0, 4) + str("zstd") + le(0, 8))),
                 ArchiveError);
    EXPECT_THROW(records_read(rec(0x06, le(0, 8) + le(0, 8) + le(1, 8) + le(0, 4) + str("") + le(size, 8) + "x")),
                 ArchiveError);
    EXPECT_THROW(records_read(chunk(schema + channel + "\x05"s + le(size, 8) + "abc", 0)), ArchiveError);
  }
  EXPECT_THROW(records_read(rec(0x03, le(1, 2) + le(0xFFFFFFFF, 4) + "abc")), ArchiveError);
  EXPECT_THROW(records_read(rec(0x04, le(1, 2) + le(0, 2) + str("t") + str("e") + le(0xFFFFFFFF, 4))), ArchiveError);
  EXPECT_THROW(records_read(rec(0x0C, str("m") + str(str("key without value")))), ArchiveError);
  EXPECT_THROW(records_read(rec(0x06, "short")), ArchiveError);
  EXPECT_THROW(records_read(chunk("", 0) + rec(0x05, "short")), ArchiveError);
}

TEST_F(ArchiveMcap, DamageNamesFileOffsetAndReason) {
  const std::string inside = schema + channel + message(10, "one");
  const auto path = file(magic + header + chunk(inside, crc_of(inside) ^ 1) + data_end + footer + magic);
  RawReader reader(path);
  try {
    static_cast<void>(reader.next());
    FAIL() << "a wrong checksum was not noticed";
  } catch (const ArchiveError& error) {
    EXPECT_EQ(error.what(), path.string() + ": damaged at byte " + std::to_string(magic.size() + header.size()) +
                                ": chunk checksum (CRC-32) is wrong");
  }
}

/// Walks a file of ours by the specification's tables, on its own: opcode and content of each record, with its offset.
struct Walked {
  std::uint64_t offset;
  int op;
  std::string content;
};
std::uint64_t number(const std::string& text, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int i = size - 1; i >= 0; --i)
    value = value << 8 | static_cast<unsigned char>(text.at(at + static_cast<std::size_t>(i)));
  return value;
}
std::vector<Walked> walk(const std::string& file, std::size_t begin, std::size_t end) {
  std::vector<Walked> records;
  while (begin < end) {
    const std::size_t size = number(file, begin + 1, 8);
    records.push_back({begin, static_cast<unsigned char>(file.at(begin)), file.substr(begin + 9, size)});
    begin += 9 + size;
  }
  EXPECT_EQ(begin, end);
  return records;
}

TEST_F(ArchiveMcap, WritesWhatTheSpecificationAsks) {
  const auto path = folder_ / "written.mcap";
  WriterOptions options;
  options.compression = Compression::None;
  Writer writer(path, options);
  write_all_kinds(writer);
  ASSERT_TRUE(writer.close().ok());
  const Bytes bytes = read_bytes(path);
  const std::string text(bytes.begin(), bytes.end());

  ASSERT_EQ(text.substr(0, 8), magic);
  ASSERT_EQ(text.substr(text.size() - 8), magic);
  const auto records = walk(text, 8, text.size() - 8);
  ASSERT_EQ(records.front().op, 0x01);
  EXPECT_EQ(number(records.front().content, 0, 4), 0u) << "empty profile";
  EXPECT_EQ(records.back().op, 0x02);

  std::map<int, std::vector<Walked>> by_op;
  for (const Walked& r : records) by_op[r.op].push_back(r);
  ASSERT_EQ(by_op[0x06].size(), 1u);
  ASSERT_EQ(by_op[0x0F].size(), 1u);
  const Walked& the_chunk = by_op[0x06][0];
  const Walked& end = by_op[0x0F][0];
  const std::string& foot = records.back().content;
  const std::string inner = the_chunk.content.substr(8 + 8 + 8 + 4 + 4 + 8);
  EXPECT_EQ(number(the_chunk.content, 16, 8), inner.size());
  EXPECT_EQ(number(the_chunk.content, 24, 4), crc_of(inner));
  EXPECT_EQ(number(end.content, 0, 4), crc_of(text.substr(0, end.offset)));
  const std::uint64_t summary_start = number(foot, 0, 8);
  EXPECT_EQ(summary_start, end.offset + 9 + 4);
  EXPECT_EQ(number(foot, 16, 4), crc_of(text.substr(summary_start, records.back().offset + 9 + 16 - summary_start)));

  // A channel's schema before the channel, a message's channel before the message; each message where its index says.
  std::set<std::uint64_t> schemas;
  std::map<std::uint64_t, std::uint64_t> counts;
  std::map<std::uint64_t, std::uint64_t> channel_of_message;
  std::uint64_t start = ~0ULL;
  std::uint64_t stop = 0;
  for (const Walked& r : walk(inner, 0, inner.size())) {
    const std::uint64_t id = number(r.content, 0, 2);
    if (r.op == 0x03) schemas.insert(id);
    if (r.op == 0x04) {
      EXPECT_TRUE(schemas.count(number(r.content, 2, 2)));
      counts[id] = 0;
    }
    if (r.op != 0x05) continue;
    ASSERT_TRUE(counts.count(id));
    ++counts[id];
    channel_of_message[r.offset] = id;
    start = std::min(start, number(r.content, 6, 8));
    stop = std::max(stop, number(r.content, 6, 8));
  }
  EXPECT_EQ(number(the_chunk.content, 0, 8), start);
  EXPECT_EQ(number(the_chunk.content, 8, 8), stop);
  EXPECT_EQ(by_op[0x07].size(), counts.size());
  for (const Walked& index : by_op[0x07]) {
    for (std::size_t at = 6; at < index.content.size(); at += 16) {
      EXPECT_EQ(channel_of_message.at(number(index.content, at + 8, 8)), number(index.content, 0, 2));
    }
  }

  const std::string& statistics = by_op[0x0B].at(0).content;
  EXPECT_EQ(number(statistics, 0, 8), all_kinds_count);
  EXPECT_EQ(number(statistics, 8, 2), schemas.size());
  EXPECT_EQ(number(statistics, 10, 4), counts.size());
  EXPECT_EQ(number(statistics, 14, 4), 1u);
  EXPECT_EQ(number(statistics, 18, 4), 1u);
  EXPECT_EQ(number(statistics, 22, 4), 1u);
  EXPECT_EQ(number(by_op[0x08].at(0).content, 16, 8), the_chunk.offset);
  EXPECT_EQ(number(by_op[0x0A].at(0).content, 0, 8), by_op[0x09].at(0).offset);
  EXPECT_EQ(number(by_op[0x0D].at(0).content, 0, 8), by_op[0x0C].at(0).offset);
  for (const Walked& offset : by_op[0x0E]) {
    const std::uint64_t group = number(offset.content, 1, 8);
    EXPECT_EQ(static_cast<unsigned char>(text.at(group)), static_cast<unsigned char>(offset.content.at(0)));
  }
}

}  // namespace
}  // namespace downrange::archive
