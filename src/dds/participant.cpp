#include "dds/participant.hpp"

#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <string_view>

// After the factory's header, which declares what it needs.
#include <fastrtps/xmlparser/XMLProfileManager.h>

#include "dds/entities.hpp"
#include "dds/log_router.hpp"
#include "dds/peer_memory.hpp"
#include "dds/qos.hpp"
#include "dds/topics.hpp"

namespace downrange::dds {

extern const char* const built_in_profiles;  ///< config/dds-qos.xml, as it was at build time

namespace {

using eprosima::fastrtps::types::ReturnCode_t;

constexpr int last_domain = 232;  ///< the ports of later domains would exceed 65535
/// Later ones use ports that Linux also hands out to any program that asks for some port.
constexpr int last_undisturbed_domain = 101;
constexpr const char* participant_profile = "downrange";
/// How long the writers of a node that goes away wait, all together, for their readers to have their last samples.
constexpr std::chrono::milliseconds last_words{300};

[[nodiscard]] bool ok(const ReturnCode_t& code) { return code == ReturnCode_t::RETCODE_OK; }

/// The first lines, which are the cause: the middleware repeats itself from there.
std::string joined(const std::vector<std::string>& lines) {
  constexpr std::size_t shown = 2;
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, lines.size()); ++i) text += (i == 0 ? "" : "; ") + lines[i];
  return text;
}

/// Replaces all profiles that are loaded. The parser reports part of what it does not understand by log lines only.
void load_profiles(const std::filesystem::path& path, const std::string& name, const LogCapture& log) {
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  if (!path.empty() && ::access(path.c_str(), R_OK) != 0) throw DdsError(name + ": cannot be read");
  eprosima::fastrtps::xmlparser::XMLProfileManager::DeleteInstance();
  const std::string_view text = built_in_profiles;
  const ReturnCode_t code = path.empty() ? factory->load_XML_profiles_string(text.data(), text.size())
                                         : factory->load_XML_profiles_file(path.string());
  const std::vector<std::string> errors = log.lines("XML", true);
  if (!ok(code) || !errors.empty()) throw DdsError(name + ": " + (errors.empty() ? "not understood" : joined(errors)));
}

[[nodiscard]] DdsError refused(const char* what, const char* topic, const LogCapture& log) {
  return DdsError(std::string("DDS ") + what + " of " + topic + " refused: " + joined(log.lines("", false)));
}

/// Whether any interface that can carry UDP over IPv4 is up, if only loopback.
bool network_is_up() {
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return false;
  bool up = false;
  for (const ifaddrs* it = first; it != nullptr; it = it->ifa_next) {
    up = up || ((it->ifa_flags & IFF_UP) != 0 && it->ifa_addr != nullptr && it->ifa_addr->sa_family == AF_INET);
  }
  ::freeifaddrs(first);
  return up;
}

}  // namespace

Participant::Impl::Impl(const ParticipantOptions& options) : node(options.node), clock(options.clock) {
  if (options.domain < 0 || options.domain > last_domain) {
    throw DdsError("DDS domain " + std::to_string(options.domain) + ": must be 0 to " + std::to_string(last_domain));
  }
  const std::string profiles =
      options.profiles.empty() ? "built-in DDS profiles" : "DDS profiles " + options.profiles.string();
  const LogCapture log;  // until all profiles are read: they are global to the process
  load_profiles(options.profiles, profiles, log);
  open(options.domain, profiles);
  if (entities_.publisher == nullptr || entities_.subscriber == nullptr) {
    throw DdsError("DDS domain " + std::to_string(options.domain) +
                   " cannot be opened: " + joined(log.lines("", false)));
  }
  read_profiles(profiles);
}

Participant::Impl::Entities::~Entities() {
  if (participant == nullptr) return;
  participant->delete_contained_entities();
  fdds::DomainParticipantFactory::get_instance()->delete_participant(participant);
}

void Participant::Impl::open(int domain, const std::string& profiles) {
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  fdds::DomainParticipantQos qos;
  if (!ok(factory->get_participant_qos_from_profile(participant_profile, qos))) {
    throw DdsError(profiles + ": no participant profile '" + participant_profile + "'");
  }
  qos.name(std::string(node.view()));
  if (clock == ClockMode::Range) adapt_to_range_clock(qos);
  remember_peers_by_own_lease(qos);
  if (domain > last_undisturbed_domain) {
    notes.push_back(
        "domain " + std::to_string(domain) +
        ": above 101, where any program may hold one of its ports by chance: then nodes do not find each other");
  }
  if (!network_is_up()) notes.emplace_back("no network interface is up, not even loopback: no other process is heard");
  entities_.participant =
      factory->create_participant(static_cast<fdds::DomainId_t>(domain), qos, &mismatches, fdds::StatusMask::none());
  if (entities_.participant == nullptr) return;
  entities_.publisher = entities_.participant->create_publisher(fdds::PUBLISHER_QOS_DEFAULT);
  entities_.subscriber = entities_.participant->create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT);
}

void Participant::Impl::read_profiles(const std::string& profiles) {
  std::string missing;
  const auto read = [&](const Topic& topic, const char* kind, auto&& from_profile) {
    const std::string delivery(to_string(topic.delivery));
    if (ok(from_profile(topic.name)) || ok(from_profile(delivery))) return;
    missing += (missing.empty() ? "" : ", ") + std::string(kind) + ' ' + topic.name + " or " + delivery;
  };
  for (const Topic& topic : all_topics()) {
    read(topic, "data_writer", [&](const std::string& profile) {
      return entities_.publisher->get_datawriter_qos_from_profile(profile, writer_qos_[topic.name]);
    });
    read(topic, "data_reader", [&](const std::string& profile) {
      return entities_.subscriber->get_datareader_qos_from_profile(profile, reader_qos_[topic.name]);
    });
  }
  if (!missing.empty()) throw DdsError(profiles + ": missing profile: " + missing);
}

fdds::Topic* Participant::Impl::topic(const char* name, const fdds::TypeSupport& type) {
  const std::scoped_lock lock(mutex_);
  fdds::Topic*& topic = topics_[name];
  if (topic == nullptr && ok(type.register_type(entities_.participant))) {
    topic = entities_.participant->create_topic(name, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT);
  }
  if (topic == nullptr) throw DdsError(std::string("DDS topic ") + name + " cannot be created");
  return topic;
}

fdds::DataWriter* Participant::Impl::create_writer(const char* topic_name, const fdds::TypeSupport& type,
                                                   const EndpointOptions& options, fdds::DataWriterListener& listener) {
  fdds::DataWriterQos qos = writer_qos_.at(topic_name);
  if (clock == ClockMode::Range) adapt_to_range_clock(topic_name, qos);
  if (qos.ownership().kind == fdds::EXCLUSIVE_OWNERSHIP_QOS) {
    qos.ownership_strength().value = static_cast<std::uint32_t>(options.strength);
  }
  const LogCapture log;
  fdds::DataWriter* writer = entities_.publisher->create_datawriter(topic(topic_name, type), qos, &listener);
  if (writer == nullptr) throw refused("writer", topic_name, log);
  mismatches.add_own(WriterEndpoint{topic_name, type.get_type_name(), type->m_isGetKeyDefined,
                                    qos.get_writerqos(entities_.publisher->get_qos(), fdds::TOPIC_QOS_DEFAULT)});
  return writer;
}

fdds::DataReader* Participant::Impl::create_reader(const char* topic_name, const fdds::TypeSupport& type,
                                                   const EndpointOptions& options, fdds::DataReaderListener& listener) {
  fdds::DataReaderQos qos = reader_qos_.at(topic_name);
  if (clock == ClockMode::Range) adapt_to_range_clock(topic_name, options.lossless, qos);
  const LogCapture log;
  fdds::DataReader* reader = entities_.subscriber->create_datareader(topic(topic_name, type), qos, &listener);
  if (reader == nullptr) throw refused("reader", topic_name, log);
  mismatches.add_own(ReaderEndpoint{topic_name, type.get_type_name(), type->m_isGetKeyDefined,
                                    qos.get_readerqos(entities_.subscriber->get_qos())});
  return reader;
}

void Participant::Impl::delete_writer(fdds::DataWriter* writer) {
  const auto now = std::chrono::steady_clock::now();
  {
    const std::scoped_lock lock(mutex_);
    if (now > leaving_until_ + last_words) leaving_until_ = now + last_words;
  }
  const auto left = std::max(std::chrono::nanoseconds(0), std::chrono::nanoseconds(leaving_until_ - now));
  writer->wait_for_acknowledgments({0, static_cast<std::uint32_t>(left.count())});
  // Fast DDS 2.9.1 frees the history of a writer that it deletes without the lock that its heartbeats hold: a heartbeat
  // in that moment walks freed samples for ever. Without history there is nothing to walk.
  std::size_t cleared = 0;
  writer->clear_history(&cleared);
  entities_.publisher->delete_datawriter(writer);
}
void Participant::Impl::delete_reader(fdds::DataReader* reader) { entities_.subscriber->delete_datareader(reader); }

Participant::Participant(const ParticipantOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Participant::~Participant() = default;

const Name& Participant::node() const { return impl_->node; }
ClockMode Participant::clock() const { return impl_->clock; }
const std::vector<std::string>& Participant::notes() const { return impl_->notes; }
std::vector<std::string> Participant::mismatches() const { return impl_->mismatches.texts(); }

std::vector<std::string> NewMismatches::among(const std::vector<std::string>& present) {
  std::vector<std::string> fresh;
  for (const std::string& mismatch : present) {
    if (!told_.contains(mismatch)) fresh.push_back(mismatch);
  }
  told_ = {present.begin(), present.end()};
  return fresh;
}

}  // namespace downrange::dds
