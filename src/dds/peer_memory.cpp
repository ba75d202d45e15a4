#include "dds/peer_memory.hpp"

#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/UDPv6TransportDescriptor.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "dds/spdp_lease.hpp"

namespace downrange::dds {
namespace {

using eprosima::fastdds::rtps::Locator;
using eprosima::fastdds::rtps::LocatorList;
using eprosima::fastdds::rtps::SendResourceList;
using eprosima::fastdds::rtps::TransportDescriptorInterface;
using eprosima::fastdds::rtps::TransportInterface;
using eprosima::fastdds::rtps::TransportReceiverInterface;
using eprosima::fastrtps::rtps::octet;

/// Between a transport's channel and who reads from it; one thread calls.
class LeaseReceiver final : public TransportReceiverInterface {
 public:
  LeaseReceiver(TransportReceiverInterface& reader, std::int32_t lease_s) : reader_(reader), lease_s_(lease_s) {}

  void OnDataReceived(const octet* data, std::uint32_t size, const Locator& local, const Locator& remote) override {
    message_.assign(data, data + size);
    put_lease(message_, lease_s_);
    reader_.OnDataReceived(message_.data(), size, local, remote);
  }

 private:
  TransportReceiverInterface& reader_;
  std::int32_t lease_s_;
  std::vector<octet> message_;
};

/// A transport whose messages pass LeaseReceivers. Everything else is the inner transport's.
class RememberingTransport final : public TransportInterface {
 public:
  RememberingTransport(std::unique_ptr<TransportInterface> inner, std::int32_t lease_s)
      : TransportInterface(inner->kind()), lease_s_(lease_s), inner_(std::move(inner)) {}

  bool OpenInputChannel(const Locator& locator, TransportReceiverInterface* reader, std::uint32_t max_size) override {
    const std::scoped_lock lock(mutex_);
    receivers_.push_back(std::make_unique<LeaseReceiver>(*reader, lease_s_));
    return inner_->OpenInputChannel(locator, receivers_.back().get(), max_size);
  }

  bool init(const eprosima::fastrtps::rtps::PropertyPolicy* properties) override { return inner_->init(properties); }
  bool IsInputChannelOpen(const Locator& l) const override { return inner_->IsInputChannelOpen(l); }
  bool IsLocatorSupported(const Locator& l) const override { return inner_->IsLocatorSupported(l); }
  bool is_locator_allowed(const Locator& l) const override { return inner_->is_locator_allowed(l); }
  Locator RemoteToMainLocal(const Locator& remote) const override { return inner_->RemoteToMainLocal(remote); }
  bool transform_remote_locator(const Locator& remote, Locator& result) const override {
    return inner_->transform_remote_locator(remote, result);
  }
  bool OpenOutputChannel(SendResourceList& senders, const Locator& l) override {
    return inner_->OpenOutputChannel(senders, l);
  }
  bool CloseInputChannel(const Locator& l) override { return inner_->CloseInputChannel(l); }
  bool DoInputLocatorsMatch(const Locator& a, const Locator& b) const override {
    return inner_->DoInputLocatorsMatch(a, b);
  }
  LocatorList NormalizeLocator(const Locator& l) override { return inner_->NormalizeLocator(l); }
  void select_locators(eprosima::fastrtps::rtps::LocatorSelector& selector) const override {
    inner_->select_locators(selector);
  }
  bool is_local_locator(const Locator& l) const override { return inner_->is_local_locator(l); }
  TransportDescriptorInterface* get_configuration() override { return inner_->get_configuration(); }
  void AddDefaultOutputLocator(LocatorList& list) override { inner_->AddDefaultOutputLocator(list); }
  bool getDefaultMetatrafficMulticastLocators(LocatorList& list, std::uint32_t port) const override {
    return inner_->getDefaultMetatrafficMulticastLocators(list, port);
  }
  bool getDefaultMetatrafficUnicastLocators(LocatorList& list, std::uint32_t port) const override {
    return inner_->getDefaultMetatrafficUnicastLocators(list, port);
  }
  bool getDefaultUnicastLocators(LocatorList& list, std::uint32_t port) const override {
    return inner_->getDefaultUnicastLocators(list, port);
  }
  bool fillMetatrafficMulticastLocator(Locator& l, std::uint32_t port) const override {
    return inner_->fillMetatrafficMulticastLocator(l, port);
  }
  bool fillMetatrafficUnicastLocator(Locator& l, std::uint32_t port) const override {
    return inner_->fillMetatrafficUnicastLocator(l, port);
  }
  bool configureInitialPeerLocator(Locator& l, const eprosima::fastrtps::rtps::PortParameters& ports,
                                   std::uint32_t domain, LocatorList& list) const override {
    return inner_->configureInitialPeerLocator(l, ports, domain, list);
  }
  bool fillUnicastLocator(Locator& l, std::uint32_t port) const override { return inner_->fillUnicastLocator(l, port); }
  std::uint32_t max_recv_buffer_size() const override { return inner_->max_recv_buffer_size(); }
  void shutdown() override { inner_->shutdown(); }
  void update_network_interfaces() override { inner_->update_network_interfaces(); }

 private:
  std::int32_t lease_s_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<LeaseReceiver>>
      receivers_;  ///< as long as channels may call them: the inner one goes first
  std::unique_ptr<TransportInterface> inner_;
};

/// A site's transport as it is configured, of which a RememberingTransport is made.
template <class Descriptor>
class Remembering final : public Descriptor {
 public:
  Remembering(const Descriptor& configured, std::int32_t lease_s) : Descriptor(configured), lease_s_(lease_s) {}

  TransportInterface* create_transport() const override {
    std::unique_ptr<TransportInterface> inner(Descriptor::create_transport());
    return inner ? new RememberingTransport(std::move(inner), lease_s_) : nullptr;
  }

 private:
  std::int32_t lease_s_;
};

template <class Descriptor>
bool replace(std::shared_ptr<TransportDescriptorInterface>& transport, std::int32_t lease_s) {
  const auto configured = std::dynamic_pointer_cast<Descriptor>(transport);
  if (configured) transport = std::make_shared<Remembering<Descriptor>>(*configured, lease_s);
  return configured != nullptr;
}

}  // namespace

void remember_peers_by_own_lease(eprosima::fastdds::dds::DomainParticipantQos& qos) {
  const auto& own = qos.wire_protocol().builtin.discovery_config.leaseDuration;
  if (own == eprosima::fastrtps::c_TimeInfinite) return;
  const std::int32_t lease_s = std::max(1, static_cast<std::int32_t>(own.to_ns() / 1'000'000'000 * 9 / 10));
  for (auto& transport : qos.transport().user_transports) {
    using namespace eprosima::fastdds::rtps;
    if (!replace<UDPv4TransportDescriptor>(transport, lease_s)) replace<UDPv6TransportDescriptor>(transport, lease_s);
  }
}

}  // namespace downrange::dds
