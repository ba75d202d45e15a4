#include <archive/reader.hpp>
#include <archive/record_catalogue.hpp>
#include <text/printable.hpp>

namespace downrange::archive {
namespace {

template <class Message>
Record decode(Message& message, const RawMessage& raw) {
  Defect defect;
  if (raw.payload.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) ||
      !message.ParseFromArray(raw.payload.data(), static_cast<int>(raw.payload.size()))) {
    defect.what = "not a " + raw.channel->schema + " message";
  } else if (auto record = from_proto(message, defect); defect.what.empty()) {
    return record;
  }
  return BadRecord{raw.channel->topic, defect.what + " (in the record at byte " + std::to_string(raw.offset) + ")"};
}

}  // namespace

class Reader::Decoder {
 public:
  struct Meaning {
    std::optional<RecordKind> kind;  ///< nothing: not ours
    Role role = Role::Input;
    std::uint64_t* foreign = nullptr;  ///< where messages of a channel that is not ours are counted
  };

  /// Of a channel; found once, then remembered by its id.
  const Meaning& meaning(const ChannelInfo& channel) {
    const auto known = meanings_.find(channel.id);
    if (known != meanings_.end()) return known->second;
    Meaning meaning;
    if (channel.message_encoding == "protobuf") meaning.kind = kind_of_schema(channel.schema);
    if (!meaning.kind) meaning.foreign = &foreign_channel(channel);
    if (meaning.kind) {
      const auto role = channel.metadata.find("role");
      const auto named = role == channel.metadata.end() ? std::nullopt : role_named(role->second);
      meaning.role = named.value_or(usual_role(*meaning.kind));
    }
    return meanings_.emplace(channel.id, meaning).first->second;
  }

  Record decode_as(RecordKind kind, const RawMessage& raw) {
    Record record = BadRecord{raw.channel->topic, "unknown kind of record"};
    Records::for_each([&]<class T>() {
      if (kind_of_record<T> == kind) record = decode(std::get<Proto<T>>(messages_), raw);
    });
    return record;
  }

  [[nodiscard]] const std::map<std::string, std::uint64_t>& foreign() const { return foreign_; }

 private:
  std::uint64_t& foreign_channel(const ChannelInfo& channel) {
    constexpr std::size_t named = 5;
    if (foreign_.size() >= named) return foreign_["other channels"];
    return foreign_[text::in_quotes(channel.topic) + " (" + text::in_quotes(channel.schema) + ')'];
  }

  std::map<std::uint16_t, Meaning> meanings_;
  std::map<std::string, std::uint64_t> foreign_;  ///< messages by channel
  // Parsed into again and again, so that their strings and arrays keep their memory.
  Records::Tuple<Proto> messages_;
};

Reader::Reader(const std::filesystem::path& path) : raw_(path), decoder_(std::make_unique<Decoder>()) {}
Reader::~Reader() = default;

std::optional<Entry> Reader::next() {
  while (const auto raw = raw_.next()) {
    const Decoder::Meaning& meaning = decoder_->meaning(*raw->channel);
    if (meaning.kind) {
      return Entry{decoder_->decode_as(*meaning.kind, *raw), meaning.role, raw->sequence, raw->channel->topic};
    }
    ++*meaning.foreign;
  }
  return std::nullopt;
}

Skipped Reader::skipped() const {
  Skipped skipped = raw_.skipped();
  for (const auto& [channel, count] : decoder_->foreign()) skipped.foreign_messages += count;
  return skipped;
}

std::map<std::string, std::uint64_t> Reader::foreign_channels() const { return decoder_->foreign(); }

}  // namespace downrange::archive
