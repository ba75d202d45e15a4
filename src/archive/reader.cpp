#include <archive/channels.hpp>
#include <archive/convert.hpp>
#include <archive/reader.hpp>
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

/// Channels of ours that an archive of another writer, without the role, can only mean one way.
Role usual_role(RecordKind kind) {
  switch (kind) {
    case RecordKind::RadarTspi:
    case RecordKind::GpsFix:
    case RecordKind::AngleTspi:
    case RecordKind::MissionEvent:
    case RecordKind::ClockGap:
      return Role::Input;
    case RecordKind::LastTick:
      return Role::Mark;
    case RecordKind::Truth:
      return Role::Truth;
    default:
      return Role::Output;
  }
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
    switch (kind) {
      case RecordKind::RadarTspi:
        return decode(radar_, raw);
      case RecordKind::GpsFix:
        return decode(gps_, raw);
      case RecordKind::AngleTspi:
        return decode(angles_, raw);
      case RecordKind::MissionEvent:
        return decode(mission_, raw);
      case RecordKind::ClockGap:
        return decode(gap_, raw);
      case RecordKind::Observation:
        return decode(observation_, raw);
      case RecordKind::SensorBias:
        return decode(bias_, raw);
      case RecordKind::Trajectory:
        return decode(trajectory_, raw);
      case RecordKind::SlavingCommand:
        return decode(slaving_, raw);
      case RecordKind::SourceHealth:
        return decode(health_, raw);
      case RecordKind::LastTick:
        return decode(last_tick_, raw);
      case RecordKind::Truth:
        return decode(truth_, raw);
    }
    return BadRecord{raw.channel->topic, "unknown kind of record"};
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
  record::RadarTspi radar_;
  record::GpsFix gps_;
  record::AngleTspi angles_;
  record::MissionEvent mission_;
  record::ClockGap gap_;
  record::Observation observation_;
  record::SensorBias bias_;
  record::Trajectory trajectory_;
  record::SlavingCommand slaving_;
  record::SourceHealth health_;
  record::LastTick last_tick_;
  record::Truth truth_;
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
