#include "drivers/net/artnet_nodes.h"

#include <algorithm>
#include <cstring>

#include "drivers/net/bytes.h"
#include "drivers/net/hash.h"

namespace footlight::drivers {
namespace {

// The longest time until our own broadcast returns.
constexpr DurationNs kEchoNs = 50 * kNsPerMs;

[[nodiscard]] bool came_back(TimeNs sent_ns, TimeNs arrived_ns) {
  return arrived_ns - kEchoNs <= sent_ns && sent_ns <= arrived_ns + kEchoNs;
}

// Names come from other devices: keep what can be printed on one line.
std::string printable(std::string_view text) {
  std::string clean(text);
  for (char& c : clean) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  while (!clean.empty() && clean.back() == ' ') clean.pop_back();
  return clean;
}

}  // namespace

void ArtnetNodes::receive(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  // The device's address is the one that the datagram came from, whatever its reply contains. So a forged reply cannot
  // direct levels to another device. On this machine answers come over loopback, and the reply contains the address.
  std::uint32_t ipv4 = datagram.from_ipv4;
  if (is_loopback(ipv4) && read_u32_be(reply.ip, 0) != 0) ipv4 = read_u32_be(reply.ip, 0);
  auto found = devices_.find(ipv4);
  if (found == devices_.end()) {
    if (devices_.size() >= kNodesMax) return;
    found = devices_.emplace(ipv4, Device{}).first;
    found->second.node.ipv4 = ipv4;
    ++revision_;
  }
  Device& device = found->second;
  ArtnetNode& node = device.node;
  // The first reply has the name of the device; later ones may have names of its ports.
  if (reply.bind_index <= 1 || node.short_name.empty()) {
    node.short_name = printable(reply.short_name);
    node.long_name = printable(reply.long_name);
    node.mac = reply.mac;
    node.style = reply.style;
  }
  node.rdm = reply.rdm;
  node.interface_index = datagram.interface_index;
  node.received_ns = now_ns;
  for (const auto& port : reply.ports()) {
    const int key = 2 * port.port_address + (port.output ? 1 : 0);
    const auto known = device.ports.find(key);
    if (known != device.ports.end()) {
      known->second = now_ns;
    } else if (device.ports.size() < kPortsPerNodeMax) {
      device.ports.emplace(key, now_ns);
      ++revision_;
    }
  }
  next_expiry_ns_ = std::min(next_expiry_ns_, now_ns + kArtnetNodeTimeoutNs);
}

void ArtnetNodes::expire(TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  if (now_ns < next_expiry_ns_) return;
  next_expiry_ns_ = kTimeNever;
  const auto is_old = [&](TimeNs received_ns) {
    if (now_ns - received_ns >= kArtnetNodeTimeoutNs) return true;
    next_expiry_ns_ = std::min(next_expiry_ns_, received_ns + kArtnetNodeTimeoutNs);
    return false;
  };
  std::size_t gone = 0;
  for (auto& [ipv4, device] : devices_) {
    gone += std::erase_if(device.ports, [&](const auto& port) { return is_old(port.second); });
  }
  gone += std::erase_if(devices_, [&](const auto& entry) { return is_old(entry.second.node.received_ns); });
  if (gone > 0) ++revision_;
}

void ArtnetNodes::subscribers_of(int port_address, bool output, std::span<const int> interfaces,
                                 std::vector<std::uint32_t>& ipv4s) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [ipv4, device] : devices_) {
    if (!interfaces.empty() &&
        std::find(interfaces.begin(), interfaces.end(), device.node.interface_index) == interfaces.end()) {
      continue;
    }
    if (device.ports.contains(2 * port_address + (output ? 1 : 0))) ipv4s.push_back(ipv4);
  }
}

std::string ArtnetNodes::name_of(std::uint32_t ipv4) const {
  const std::lock_guard lock(mutex_);
  const auto found = devices_.find(ipv4);
  if (found == devices_.end()) return {};
  const ArtnetNode& node = found->second.node;
  return node.long_name.empty() ? node.short_name : node.long_name;
}

std::vector<ArtnetNode> ArtnetNodes::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<ArtnetNode> nodes;
  for (const auto& [ipv4, device] : devices_) {
    ArtnetNode& node = nodes.emplace_back(device.node);
    for (const auto& [key, received_ns] : device.ports) (key % 2 != 0 ? node.outputs : node.inputs).push_back(key / 2);
  }
  return nodes;
}

std::uint64_t artnet_digest(std::span<const std::uint8_t> slots) {
  std::uint64_t digest = slots.size();
  for (; slots.size() >= sizeof(std::uint64_t); slots = slots.subspan(sizeof(std::uint64_t))) {
    std::uint64_t word = 0;
    std::memcpy(&word, slots.data(), sizeof word);
    digest = mix64(digest ^ word);
  }
  for (const std::uint8_t slot : slots) digest = mix64(digest ^ slot);
  return digest == 0 ? 1 : digest;  // 0: never sent
}

void ArtnetProgram::receive(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns) {
  if (is_from_here(datagram)) {
    const std::lock_guard lock(mutex_);
    const auto ports = reply.ports();
    const bool is_own = !ports.empty() && std::all_of(ports.begin(), ports.end(), [&](const auto& port) {
      return source_port_addresses_.count(port.port_address) != 0;
    });
    if (is_own) return;
  }
  nodes.receive(reply, datagram, now_ns);
}

void ArtnetProgram::add_source(const std::vector<int>& port_addresses) {
  ++source_count_;
  const std::lock_guard lock(mutex_);
  for (const int port_address : port_addresses) ++source_port_addresses_[port_address];
}

void ArtnetProgram::remove_source(const std::vector<int>& port_addresses) {
  --source_count_;
  const std::lock_guard lock(mutex_);
  for (const int port_address : port_addresses) {
    const auto found = source_port_addresses_.find(port_address);
    if (found != source_port_addresses_.end() && --found->second == 0) source_port_addresses_.erase(found);
  }
}

std::shared_ptr<ArtnetOwnFrames> ArtnetProgram::add_sink() {
  const std::lock_guard lock(mutex_);
  const auto is_closed = [](const auto& own) { return own.use_count() == 1; };
  if (static_cast<std::size_t>(std::count_if(own_frames_.begin(), own_frames_.end(), is_closed)) >= kClosedSinksMax) {
    own_frames_.erase(std::find_if(own_frames_.begin(), own_frames_.end(), is_closed));
  }
  return own_frames_.emplace_back(std::make_shared<ArtnetOwnFrames>());
}

bool ArtnetProgram::is_own_frame(const ArtnetDmx& dmx) const {
  const std::lock_guard lock(mutex_);
  if (own_frames_.empty()) return false;
  const std::uint64_t digest = artnet_digest(dmx.slots);
  return std::any_of(own_frames_.begin(), own_frames_.end(),
                     [&](const auto& own) { return own->has(dmx.port_address, dmx.sequence, digest); });
}

bool ArtnetProgram::may_poll(std::uint32_t broadcast, TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  const auto polled = polled_ns_.find(broadcast);
  if (polled != polled_ns_.end() && now_ns - polled->second < kArtnetPollIntervalNs) return false;
  polled_ns_[broadcast] = poll_ns_ = now_ns;
  return true;
}

bool ArtnetProgram::is_own_poll(TimeNs arrived_ns) const {
  const std::lock_guard lock(mutex_);
  return came_back(poll_ns_, arrived_ns);
}
void ArtnetProgram::note_sync(TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  sync_ns_ = now_ns;
}
bool ArtnetProgram::is_own_sync(TimeNs arrived_ns) const {
  const std::lock_guard lock(mutex_);
  return came_back(sync_ns_, arrived_ns);
}

void ArtnetAnswers::add(const ArtnetPoll& poll, const Datagram& datagram, std::uint64_t seed, TimeNs now_ns) {
  for (Requester& requester : requesters_) {
    if (requester.ipv4 != datagram.from_ipv4 || requester.udp_port != datagram.from_udp_port ||
        requester.next_reply != 0)
      continue;
    requester.port_address_first = std::min(requester.port_address_first, poll.port_address_first);
    requester.port_address_last = std::max(requester.port_address_last, poll.port_address_last);
    return;
  }
  if (requesters_.size() >= kRequestersMax) return;
  Requester& requester = requesters_.emplace_back();
  requester.ipv4 = datagram.from_ipv4;
  requester.udp_port = datagram.from_udp_port;
  requester.local_ipv4 = datagram.local_ipv4;
  requester.interface_index = datagram.interface_index;
  requester.is_here = is_from_here(datagram);
  requester.port_address_first = poll.port_address_first;
  requester.port_address_last = poll.port_address_last;
  const std::uint64_t random = mix64(seed ^ mix64(++count_ ^ std::uint64_t{datagram.from_ipv4} << 32));
  requester.due_ns = now_ns + static_cast<DurationNs>(random % static_cast<std::uint64_t>(kArtnetReplyDelayMaxNs));
}

TimeNs ArtnetAnswers::next_due_ns() const {
  TimeNs due_ns = kTimeNever;
  for (const Requester& requester : requesters_) due_ns = std::min(due_ns, requester.due_ns);
  return due_ns;
}

void ArtnetAnswers::answer_due(TimeNs now_ns, const std::function<bool(Requester&)>& answer) {
  for (std::size_t i = 0; i < requesters_.size();) {
    if (requesters_[i].due_ns <= now_ns && answer(requesters_[i])) {
      requesters_.erase(requesters_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

std::array<std::uint8_t, 4> octets_of(std::uint32_t ipv4) {
  std::array<std::uint8_t, 4> octets = {};
  write_u32_be(octets, 0, ipv4);
  return octets;
}

std::array<std::uint8_t, 6> mac_of(int interface_index) {
  for (const auto& candidate : list_interfaces()) {
    if (candidate.index == interface_index) return candidate.mac;
  }
  return {};
}

std::uint64_t artnet_machine_seed() {
  std::uint64_t seed = 0;
  for (const auto& each : list_interfaces()) seed = mix64(seed ^ sender_hash(each.mac) ^ each.ipv4);
  return seed;
}

void add_artnet_reply(DatagramWriter& writer, std::span<const std::uint8_t> reply,
                      const ArtnetAnswers::Requester& requester, std::uint16_t udp_port) {
  writer.add(reply, requester.is_here ? kLoopbackBroadcast : requester.ipv4, udp_port);
  if (requester.udp_port != udp_port && requester.udp_port != 0) writer.add(reply, requester.ipv4, requester.udp_port);
}

}  // namespace footlight::drivers
