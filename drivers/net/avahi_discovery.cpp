// Multicast DNS through Avahi's daemon.
//
// Groups of MVR-xchange are labels between the instance and the service, which is not how RFC 6763 forms sub types. So
// records are browsed and published one by one; Avahi's calls for services would refuse these names.
#include <algorithm>
#include <array>
#include <cstring>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <avahi-client/client.h>
#include <avahi-client/lookup.h>
#include <avahi-client/publish.h>
#include <avahi-common/alternative.h>
#include <avahi-common/defs.h>
#include <avahi-common/domain.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/simple-watch.h>

#include "drivers/net/bytes.h"
#include "drivers/net/mvr_xchange_discovery.h"
#include "drivers/net/mvr_xchange_names.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kReopenNs = 5 * kNsPerS;  // after the daemon has ended
constexpr int kStepsMax = 64;                  // messages of the daemon in one step
constexpr std::uint32_t kTtlPointerS = 4500;   // RFC 6762 section 10
constexpr std::uint32_t kTtlHostS = 120;

template <auto Free>
struct FreedBy {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Poll = std::unique_ptr<AvahiSimplePoll, FreedBy<avahi_simple_poll_free>>;
using Client = std::unique_ptr<AvahiClient, FreedBy<avahi_client_free>>;
using Browser = std::unique_ptr<AvahiRecordBrowser, FreedBy<avahi_record_browser_free>>;
using Group = std::unique_ptr<AvahiEntryGroup, FreedBy<avahi_entry_group_free>>;

// "Desk\.1.Default._mvrxchange._tcp.local", as Avahi takes names.
std::string escaped(const DnsLabels& labels) {
  std::string name;
  for (const std::string& label : labels) {
    std::array<char, AVAHI_LABEL_MAX* 4 + 1> buffer = {};
    char* at = buffer.data();
    std::size_t room = buffer.size();
    if (avahi_escape_label(label.data(), label.size(), &at, &room) == nullptr) continue;
    name += (name.empty() ? "" : ".") + std::string(buffer.data());
  }
  return name;
}

std::span<const std::uint8_t> octets(const void* data, std::size_t size) {
  return {static_cast<const std::uint8_t*>(data), size};
}

class AvahiDiscovery;

// One instance, from the PTR record that named it on.
struct Instance {
  AvahiDiscovery* owner = nullptr;
  DnsLabels name;
  int pointers = 0;  // PTR records that name it now
  Browser services;
  Browser texts;
  Browser hosts;
  std::optional<DnsService> service;
  MvrText text;
  bool has_text = false;
  std::vector<std::uint32_t> addresses;  // one that is seen on two interfaces is there twice
};

class AvahiDiscovery final : public MvrDiscovery {
 public:
  static Result<std::unique_ptr<MvrDiscovery>> open() {
    std::unique_ptr<AvahiDiscovery> discovery(new AvahiDiscovery);
    FL_TRY(discovery->connect());
    return discovery;
  }

  void add_descriptors(std::vector<pollfd>& waiting) const override {
    if (!lost_) waiting.insert(waiting.end(), waiting_.begin(), waiting_.end());
  }

  void step(TimeNs now_ns) override {
    if (lost_) {
      if (now_ns < reopen_ns_) return;
      reopen_ns_ = now_ns + kReopenNs;
      if (const Status connected = connect(); !connected) {
        trouble_ = connected.error().message;
        return;
      }
    }
    // What is published in one turn is sent in the next.
    for (int i = 0; i < kStepsMax && !lost_; ++i) {
      if (renew_) publish();
      again_ = false;
      if (avahi_simple_poll_iterate(poll_.get(), -1) != 0) lost_ = true;
      if (!again_ && !renew_) break;
    }
  }

  [[nodiscard]] std::vector<MvrFound> found() const override {
    std::vector<MvrFound> found;
    for (const Instance& one : instances_) {
      if (!one.service || !one.has_text || one.addresses.empty()) continue;
      const auto words = mvr_instance_of(one.name);
      MvrFound station;
      station.name = !one.text.station_name.empty() ? one.text.station_name : words->station;
      station.uuid = one.text.station_uuid;
      station.group = words->group;
      station.address = {one.addresses.front(), one.service->port};
      for (const std::uint32_t ipv4 : one.addresses) {
        const MvrAddress address = {ipv4, one.service->port};
        const bool known = address == station.address ||
                           std::find(station.others.begin(), station.others.end(), address) != station.others.end();
        if (!known) station.others.push_back(address);
      }
      // Some programs announce the same instance under two names.
      if (std::find(found.begin(), found.end(), station) == found.end()) found.push_back(std::move(station));
    }
    return found;
  }

  void announce(const MvrAnnouncement& announcement) override {
    announcement_ = announcement;
    label_ = announcement.name;
    renew_ = true;
  }

  [[nodiscard]] std::string announced_name() const override { return established_ ? label_ : ""; }
  [[nodiscard]] std::string trouble() const override { return trouble_; }

 private:
  AvahiDiscovery() = default;

  // In place of Avahi's poll(): does not wait, and stores what Avahi waits for.
  static int wait(pollfd* descriptors, unsigned count, int timeout_ms, void* data) {
    auto* const self = static_cast<AvahiDiscovery*>(data);
    self->waiting_.assign(descriptors, descriptors + count);
    const int ready = ::poll(descriptors, count, 0);
    self->again_ = ready > 0 || timeout_ms == 0;
    return ready;
  }

  Status connect() {
    forget_all();
    poll_.reset(avahi_simple_poll_new());
    if (poll_ == nullptr) return fail(ErrorCode::kIo, "MVR-xchange: the system is out of memory for Avahi");
    avahi_simple_poll_set_func(poll_.get(), wait, this);
    int error = 0;
    client_.reset(avahi_client_new(avahi_simple_poll_get(poll_.get()), AvahiClientFlags{}, on_client, this, &error));
    if (client_ == nullptr) {
      return fail(
          ErrorCode::kNotFound,
          "Avahi's daemon, which searches for MVR-xchange stations, cannot be reached ({}): install avahi-daemon "
          "and start it with 'sudo systemctl start avahi-daemon', or name a station with --station "
          "ADDRESS:PORT",
          avahi_strerror(error));
    }
    lost_ = false;
    trouble_.clear();
    stations_ = browse(with_service(), AVAHI_DNS_TYPE_PTR, on_pointer, this);
    renew_ = announcement_.has_value();
    return {};
  }

  static DnsLabels with_service() { return mvr_group_name(""); }

  void forget_all() {
    established_ = false;
    instances_.clear();
    stations_.reset();
    group_.reset();
    client_.reset();
    poll_.reset();
    waiting_.clear();
  }

  Browser browse(const DnsLabels& name, std::uint16_t type, AvahiRecordBrowserCallback callback, void* data) {
    return Browser(avahi_record_browser_new(client_.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_INET, escaped(name).c_str(),
                                            AVAHI_DNS_CLASS_IN, type, AvahiLookupFlags{}, callback, data));
  }

  static void on_client(AvahiClient* client, AvahiClientState state, void* data) {
    auto* const self = static_cast<AvahiDiscovery*>(data);
    if (state == AVAHI_CLIENT_S_RUNNING) self->renew_ = self->announcement_.has_value();
    if (state == AVAHI_CLIENT_FAILURE) self->lost_ = true;
    // The host's name changes: what was published is withdrawn, and published again when that is over.
    if (state == AVAHI_CLIENT_S_COLLISION || state == AVAHI_CLIENT_S_REGISTERING) {
      if (self->group_ != nullptr) (void)avahi_entry_group_reset(self->group_.get());
      self->established_ = false;
    }
    (void)client;
  }

  static void on_pointer(AvahiRecordBrowser*, AvahiIfIndex, AvahiProtocol, AvahiBrowserEvent event, const char*,
                         std::uint16_t, std::uint16_t, const void* data, std::size_t size, AvahiLookupResultFlags,
                         void* self) {
    const auto name = parse_dns_name(octets(data, size));
    if (!name || !mvr_instance_of(*name)) return;
    static_cast<AvahiDiscovery*>(self)->count_pointer(*name, event);
  }

  void count_pointer(const DnsLabels& name, AvahiBrowserEvent event) {
    auto at = std::find_if(instances_.begin(), instances_.end(),
                           [&](const Instance& one) { return same_dns_name(one.name, name); });
    if (event == AVAHI_BROWSER_REMOVE && at != instances_.end()) {
      if (--at->pointers <= 0) instances_.erase(at);
    }
    if (event != AVAHI_BROWSER_NEW) return;
    if (at == instances_.end()) {
      if (instances_.size() >= kMvrFoundMax) return;
      Instance& one = instances_.emplace_back();
      one.owner = this;
      one.name = name;
      one.services = browse(name, AVAHI_DNS_TYPE_SRV, on_service, &one);
      one.texts = browse(name, AVAHI_DNS_TYPE_TXT, on_text, &one);
      at = std::prev(instances_.end());
    }
    ++at->pointers;
  }

  static void on_service(AvahiRecordBrowser*, AvahiIfIndex, AvahiProtocol, AvahiBrowserEvent event, const char*,
                         std::uint16_t, std::uint16_t, const void* data, std::size_t size, AvahiLookupResultFlags,
                         void* instance) {
    auto& one = *static_cast<Instance*>(instance);
    const auto service = parse_dns_srv(octets(data, size));
    if (event != AVAHI_BROWSER_NEW || !service) return;
    if (!one.service || !same_dns_name(one.service->host, service->host)) {
      one.addresses.clear();
      one.hosts = one.owner->browse(service->host, AVAHI_DNS_TYPE_A, on_host, &one);
    }
    one.service = service;
  }

  static void on_text(AvahiRecordBrowser*, AvahiIfIndex, AvahiProtocol, AvahiBrowserEvent event, const char*,
                      std::uint16_t, std::uint16_t, const void* data, std::size_t size, AvahiLookupResultFlags,
                      void* instance) {
    if (event != AVAHI_BROWSER_NEW) return;
    auto& one = *static_cast<Instance*>(instance);
    one.text = parse_mvr_text(octets(data, size));
    one.has_text = true;
  }

  static void on_host(AvahiRecordBrowser*, AvahiIfIndex, AvahiProtocol, AvahiBrowserEvent event, const char*,
                      std::uint16_t, std::uint16_t, const void* data, std::size_t size, AvahiLookupResultFlags,
                      void* instance) {
    if (size != 4) return;
    auto& addresses = static_cast<Instance*>(instance)->addresses;
    const std::uint32_t ipv4 = read_u32_be(octets(data, size), 0);
    const auto at = std::find(addresses.begin(), addresses.end(), ipv4);
    if (event == AVAHI_BROWSER_REMOVE && at != addresses.end()) addresses.erase(at);
    if (event == AVAHI_BROWSER_NEW) addresses.push_back(ipv4);
  }

  static void on_group(AvahiEntryGroup*, AvahiEntryGroupState state, void* data) {
    auto* const self = static_cast<AvahiDiscovery*>(data);
    self->established_ = state == AVAHI_ENTRY_GROUP_ESTABLISHED;
    if (self->established_) self->trouble_.clear();
    if (state == AVAHI_ENTRY_GROUP_COLLISION) self->take_next_name();
    if (state == AVAHI_ENTRY_GROUP_FAILURE) self->set_trouble(avahi_client_errno(self->client_.get()));
  }

  void set_trouble(int error) {
    trouble_ = fmt::format(
        "Avahi's daemon does not announce '{}' ({}); choose another name or group, or see 'journalctl -u avahi-daemon'",
        announcement_->name, avahi_strerror(error));
  }

  void take_next_name() {
    char* const next = avahi_alternative_service_name(dns_label(label_).c_str());
    if (next != nullptr) label_ = next;
    avahi_free(next);
    renew_ = true;
  }

  void add(const DnsLabels& name, std::uint16_t type, bool unique, std::uint32_t ttl_s,
           const std::vector<std::uint8_t>& data, int& error) {
    if (error != AVAHI_OK) return;
    error = avahi_entry_group_add_record(group_.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_INET,
                                         unique ? AVAHI_PUBLISH_UNIQUE : AvahiPublishFlags{}, escaped(name).c_str(),
                                         AVAHI_DNS_CLASS_IN, type, ttl_s, data.data(), data.size());
  }

  // Once the daemon runs; it withdraws the records when this program ends, however it does.
  void publish() {
    renew_ = false;  // on_client() sets it when the daemon runs
    if (avahi_client_get_state(client_.get()) != AVAHI_CLIENT_S_RUNNING) return;
    const char* const host_name = avahi_client_get_host_name(client_.get());
    if (host_name == nullptr) return set_trouble(avahi_client_errno(client_.get()));
    established_ = false;
    if (group_ == nullptr) group_.reset(avahi_entry_group_new(client_.get(), on_group, this));
    if (group_ == nullptr) return set_trouble(avahi_client_errno(client_.get()));
    (void)avahi_entry_group_reset(group_.get());
    const DnsLabels instance = mvr_instance_name({label_, announcement_->group});
    const auto pointer = build_dns_name(instance);
    int error = AVAHI_OK;
    add(instance, AVAHI_DNS_TYPE_SRV, true, kTtlHostS, build_dns_srv({announcement_->port, {host_name, "local"}}),
        error);
    add(instance, AVAHI_DNS_TYPE_TXT, true, kTtlPointerS, build_mvr_text({announcement_->name, announcement_->uuid}),
        error);
    add(with_service(), AVAHI_DNS_TYPE_PTR, false, kTtlPointerS, pointer, error);
    add(mvr_group_name(announcement_->group), AVAHI_DNS_TYPE_PTR, false, kTtlPointerS, pointer, error);
    add({"_services", "_dns-sd", "_udp", "local"}, AVAHI_DNS_TYPE_PTR, false, kTtlPointerS,
        build_dns_name(with_service()), error);
    if (error == AVAHI_OK) error = avahi_entry_group_commit(group_.get());
    if (error == AVAHI_ERR_COLLISION) {  // with another program of this machine
      take_next_name();
    } else if (error != AVAHI_OK) {
      set_trouble(error);
    }
  }

  bool lost_ = false;
  bool again_ = false;  // Avahi had something to do, so it may have more
  bool renew_ = false;  // publish as soon as the daemon runs
  bool established_ = false;
  TimeNs reopen_ns_ = 0;
  std::vector<pollfd> waiting_;
  std::optional<MvrAnnouncement> announcement_;
  std::string label_;  // of the announced instance
  std::string trouble_;
  Poll poll_;
  Client client_;
  Group group_;
  Browser stations_;
  std::list<Instance> instances_;  // whose addresses stay, for the callbacks
};

}  // namespace

Result<std::unique_ptr<MvrDiscovery>> open_mvr_discovery() { return AvahiDiscovery::open(); }

}  // namespace footlight::drivers
