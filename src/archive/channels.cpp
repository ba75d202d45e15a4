#include <archive.pb.h>
#include <google/protobuf/descriptor.pb.h>

#include <archive/channels.hpp>
#include <set>

namespace downrange::archive {
namespace {

const google::protobuf::Descriptor* descriptor(RecordKind kind) {
  switch (kind) {
    case RecordKind::RadarTspi:
      return record::RadarTspi::descriptor();
    case RecordKind::GpsFix:
      return record::GpsFix::descriptor();
    case RecordKind::MissionEvent:
      return record::MissionEvent::descriptor();
    case RecordKind::Observation:
      return record::Observation::descriptor();
    case RecordKind::SensorBias:
      return record::SensorBias::descriptor();
    case RecordKind::Trajectory:
      return record::Trajectory::descriptor();
    case RecordKind::SlavingCommand:
      return record::SlavingCommand::descriptor();
    case RecordKind::SourceHealth:
      return record::SourceHealth::descriptor();
    case RecordKind::LastTick:
      return record::LastTick::descriptor();
    case RecordKind::Truth:
      return record::Truth::descriptor();
    case RecordKind::AngleTspi:
      return record::AngleTspi::descriptor();
    case RecordKind::ClockGap:
      return record::ClockGap::descriptor();
  }
  return nullptr;
}

/// One file with the message and the enumerations it uses: archive.proto without the other messages. A message of
/// archive.proto holds no other message, and the file imports nothing.
google::protobuf::FileDescriptorSet descriptor_set(const google::protobuf::Descriptor& message) {
  google::protobuf::FileDescriptorSet set;
  google::protobuf::FileDescriptorProto& file = *set.add_file();
  file.set_name(message.file()->name());
  file.set_package(message.file()->package());
  file.set_syntax("proto3");
  message.CopyTo(file.add_message_type());
  std::set<const google::protobuf::EnumDescriptor*> enums;
  for (int i = 0; i < message.field_count(); ++i) {
    const google::protobuf::EnumDescriptor* used = message.field(i)->enum_type();
    if (used != nullptr && enums.insert(used).second) used->CopyTo(file.add_enum_type());
  }
  return set;
}

}  // namespace

std::string_view to_string(Role role) {
  switch (role) {
    case Role::Input:
      return "input";
    case Role::Output:
      return "output";
    case Role::Mark:
      return "mark";
    case Role::Truth:
      return "truth";
  }
  return "";
}

std::optional<Role> role_named(std::string_view name) {
  for (const Role role : {Role::Input, Role::Output, Role::Mark, Role::Truth}) {
    if (name == to_string(role)) return role;
  }
  return std::nullopt;
}

std::string_view schema_name(RecordKind kind) { return descriptor(kind)->full_name(); }

std::optional<RecordKind> kind_of_schema(std::string_view name) {
  for (const Channel& channel : channels) {
    if (schema_name(channel.kind) == name) return channel.kind;
  }
  return std::nullopt;
}

Bytes schema_record(const Channel& channel) {
  const std::string data = descriptor_set(*descriptor(channel.kind)).SerializeAsString();

  Bytes out;
  put(out, channel.schema_id());
  put_string(out, schema_name(channel.kind));
  put_string(out, "protobuf");
  put_string(out, data);
  return out;
}

Bytes channel_record(const Channel& channel) {
  Bytes metadata;
  put_string(metadata, "role");
  put_string(metadata, to_string(channel.role));

  Bytes out;
  put(out, channel.id);
  put(out, channel.schema_id());
  put_string(out, channel.topic);
  put_string(out, "protobuf");
  put(out, static_cast<std::uint32_t>(metadata.size()));
  put_bytes(out, metadata);
  return out;
}

}  // namespace downrange::archive
