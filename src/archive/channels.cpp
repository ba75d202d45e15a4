#include <google/protobuf/descriptor.pb.h>

#include <archive/record_catalogue.hpp>
#include <array>
#include <set>

namespace downrange::archive {
namespace {

const google::protobuf::Descriptor* descriptor(RecordKind kind) {
  static const auto descriptors = []<class... T>(RecordList<T...>) {
    return std::array{Proto<T>::descriptor()...};
  }(Records{});
  return descriptors.at(kind);
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

template <class T>
constexpr bool carries_role(Role role) {
  switch (role) {
    case Role::Input:
      return Inputs::contains<T> || std::is_same_v<T, Observation> || std::is_same_v<T, ClockGap>;
    case Role::Output:
      return Outputs::contains<T>;
    case Role::Mark:
      return std::is_same_v<T, LastTick>;
    case Role::Truth:
      return std::is_same_v<T, Truth>;
  }
  return false;
}

constexpr std::array roles{Role::Input, Role::Output, Role::Mark, Role::Truth};

}  // namespace

const std::vector<Channel>& channels() {
  static const std::vector<Channel> all = [] {
    std::vector<Channel> made;
    Records::for_each([&]<class T>() {
      for (const Role role : roles) {
        if (!carries_role<T>(role)) continue;
        const auto id = static_cast<std::uint16_t>(1 + made.size());
        made.push_back({id, kind_of_record<T>, role, MessageInfo<T>::topic});
      }
    });
    return made;
  }();
  return all;
}

Role usual_role(RecordKind kind) {
  // Of an observation: the last that fits, for most archives hold what a node made.
  Role usual = Role::Output;
  for (const Channel& channel : channels()) {
    if (channel.kind == kind) usual = channel.role;
  }
  return usual;
}

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
  for (const Role role : roles) {
    if (name == to_string(role)) return role;
  }
  return std::nullopt;
}

std::string_view schema_name(RecordKind kind) { return descriptor(kind)->full_name(); }

std::optional<RecordKind> kind_of_schema(std::string_view name) {
  for (RecordKind kind = 0; kind < Records::size; ++kind) {
    if (schema_name(kind) == name) return kind;
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
