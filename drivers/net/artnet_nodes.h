// The other Art-Net devices in the network: a table of devices and ports, filled from ArtPollReply, and the shared
// state of a program's Art-Net ports. No socket, no clock; the pump's thread only.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/udp.h"
#include "sim/core/clock.h"

namespace footlight::drivers {

// Controllers poll every 2.5 to 3 s (art-net.org.uk, "Discovery Packets").
inline constexpr DurationNs kArtnetPollIntervalNs = 2'500 * kNsPerMs;
inline constexpr DurationNs kArtnetPollJitterNs = 500 * kNsPerMs;
// A device that left three polls unanswered is gone. The Art-Net document allows one poll and 3 s, but one lost
// datagram must not turn a lamp off.
inline constexpr DurationNs kArtnetNodeTimeoutNs = 10 * kNsPerS;
// A device answers within this time, at a random moment, so that a thousand do not answer at once ("ArtPollReply").
inline constexpr DurationNs kArtnetReplyDelayMaxNs = kNsPerS;
// Reaches every program on this machine that listens on all addresses.
inline constexpr std::uint32_t kLoopbackBroadcast = 0x7FFF'FFFF;

[[nodiscard]] constexpr bool is_loopback(std::uint32_t ipv4) { return ipv4 >> 24 == 127; }
// True if this machine sent the datagram: it comes from the address that it arrives at, or from any of 127.0.0.0/8.
[[nodiscard]] inline bool is_from_here(const Datagram& datagram) {
  return is_loopback(datagram.from_ipv4) || datagram.from_ipv4 == datagram.local_ipv4;
}

// A device, for status output.
struct ArtnetNode {
  std::uint32_t ipv4 = 0;
  int interface_index = 0;  // where its answers arrive
  std::string short_name;
  std::string long_name;
  std::array<std::uint8_t, 6> mac = {};
  ArtnetPollReply::Style style = ArtnetPollReply::Style::kNode;
  bool rdm = false;
  TimeNs received_ns = 0;
  // Port addresses, ascending: what it takes from Art-Net and what it sends to Art-Net.
  std::vector<int> outputs;
  std::vector<int> inputs;
};

// A device is an IPv4 address; each of its replies (which may differ by bind index) adds its ports. A port or device is
// removed when no reply has listed it for kArtnetNodeTimeoutNs.
class ArtnetNodes {
 public:
  // The maximum of devices, and of ports per device. Further ones are ignored, so that forged replies use no memory.
  static constexpr std::size_t kNodesMax = 1'024;
  static constexpr std::size_t kPortsPerNodeMax = 2'048;

  void receive(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns);
  // Removes devices and ports that timed out. Cheap before the first can have timed out.
  void expire(TimeNs now_ns);
  // Increases when a port appears or disappears.
  [[nodiscard]] std::uint64_t revision() const { return revision_.load(std::memory_order_relaxed); }

  // Appends the addresses of the devices that take this port address (`output`), or that send it. `interfaces`: only
  // devices received on one of these; empty: all.
  void subscribers_of(int port_address, bool output, std::span<const int> interfaces,
                      std::vector<std::uint32_t>& ipv4s) const;
  // Empty: unknown.
  [[nodiscard]] std::string name_of(std::uint32_t ipv4) const;
  // Sorted by address.
  [[nodiscard]] std::vector<ArtnetNode> list() const;

 private:
  struct Device {
    ArtnetNode node;              // without its ports
    std::map<int, TimeNs> ports;  // key: 2 * port address + (1: output); value: when last received
  };
  mutable std::mutex mutex_;                  // two pumps of one program may have ports
  std::map<std::uint32_t, Device> devices_;  // guarded by mutex_
  TimeNs next_expiry_ns_ = kTimeNever;       // guarded by mutex_
  std::atomic<std::uint64_t> revision_ = 0;
};

// A digest of the levels of one ArtDmx, to recognise own frames.
[[nodiscard]] std::uint64_t artnet_digest(std::span<const std::uint8_t> slots);

// The frames that one sink has sent recently. They return by broadcast, from the same address and UDP port as frames of
// other programs on this machine; only the content distinguishes them.
class ArtnetOwnFrames {
 public:
  void note(int port_address, std::uint8_t sequence, std::uint64_t digest) {
    const std::lock_guard lock(mutex_);
    digests_[port_address][sequence] = digest;
  }
  [[nodiscard]] bool has(int port_address, std::uint8_t sequence, std::uint64_t digest) const {
    const std::lock_guard lock(mutex_);
    const auto found = digests_.find(port_address);
    return found != digests_.end() && digest != 0 && found->second[sequence] == digest;
  }

 private:
  mutable std::mutex mutex_;  // a source may read what the sink of another pump writes
  std::unordered_map<int, std::array<std::uint64_t, 256>> digests_;  // guarded by mutex_
};

// The Art-Net ports of one program share what each of them receives. Unicast to UDP port 6454 has one receiver, so the
// answer to a sink's poll arrives at the source's socket if there is a source.
//
// Thread-safe: ports of two pumps may share it.
class ArtnetProgram {
 public:
  ArtnetNodes nodes;

  // Takes a reply, unless this program sent it.
  void receive(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns);

  // --- Sources
  void add_source(const std::vector<int>& port_addresses);
  void remove_source(const std::vector<int>& port_addresses);
  [[nodiscard]] bool has_sources() const { return source_count_.load(std::memory_order_relaxed) > 0; }

  // --- Sinks. The frames of the last kClosedSinksMax closed sinks stay recorded, since datagrams may still be under
  // way.
  static constexpr std::size_t kClosedSinksMax = 8;
  [[nodiscard]] std::shared_ptr<ArtnetOwnFrames> add_sink();
  [[nodiscard]] bool is_own_frame(const ArtnetDmx& dmx) const;

  // --- Polls. Several sinks poll a network once.
  // True if no port of this program has polled there in the last interval; then it counts as polled.
  [[nodiscard]] bool may_poll(std::uint32_t broadcast, TimeNs now_ns);
  // True if a poll from this machine is one of ours, received back: it arrives almost at once. Another program's poll
  // at that moment stays unanswered once; neither polls at a fixed interval.
  [[nodiscard]] bool is_own_poll(TimeNs arrived_ns) const;
  void note_sync(TimeNs now_ns);
  [[nodiscard]] bool is_own_sync(TimeNs arrived_ns) const;

 private:
  mutable std::mutex mutex_;
  std::map<int, int> source_port_addresses_;                  // guarded by mutex_; how many sources have it
  std::vector<std::shared_ptr<ArtnetOwnFrames>> own_frames_;  // guarded by mutex_: the list, not its elements
  std::atomic<int> source_count_ = 0;
  std::map<std::uint32_t, TimeNs> polled_ns_;  // guarded by mutex_, as the next two
  TimeNs poll_ns_ = -kTimeNever;
  TimeNs sync_ns_ = -kTimeNever;
};

// The polls that wait for their answer.
class ArtnetAnswers {
 public:
  static constexpr std::size_t kRequestersMax = 256;
  // Replies to one requester that are sent at once, and the pause before the next ones, so that a console's buffer can
  // hold them.
  static constexpr std::size_t kRepliesAtOnce = 32;
  static constexpr DurationNs kPauseNs = 10 * kNsPerMs;

  struct Requester {
    std::uint32_t ipv4 = 0;
    std::uint16_t udp_port = 0;
    std::uint32_t local_ipv4 = 0;  // ours, where the request arrived
    int interface_index = 0;
    std::array<std::uint8_t, 6> mac = {};  // of our interface there
    bool is_here = false;                  // on this machine
    int port_address_first = 0;
    int port_address_last = kArtnetPortAddressMax;
    TimeNs due_ns = 0;
    std::size_t next_reply = 0;  // the next of the replies for all ports
  };

  // `seed` differs between machines. A requester that polls again while an answer is due gets only that one.
  void add(const ArtnetPoll& poll, const Datagram& datagram, std::uint64_t seed, TimeNs now_ns);
  [[nodiscard]] TimeNs next_due_ns() const;
  // Calls `answer` for each requester that is due. `answer` returns true if everything was sent, else it has set a
  // later due_ns.
  void answer_due(TimeNs now_ns, const std::function<bool(Requester&)>& answer);

 private:
  std::vector<Requester> requesters_;
  std::uint64_t count_ = 0;
};

[[nodiscard]] std::array<std::uint8_t, 4> octets_of(std::uint32_t ipv4);
// The hardware address of an interface of this machine; zeros if it has none.
[[nodiscard]] std::array<std::uint8_t, 6> mac_of(int interface_index);
// Differs between machines.
[[nodiscard]] std::uint64_t artnet_machine_seed();

// Adds a reply to `writer`: to the protocol's UDP port, and to the port of the request if that differs. Programs on
// this machine share the protocol's port, and unicast to it would reach any one of them. So they are answered by
// broadcast on loopback.
void add_artnet_reply(DatagramWriter& writer, std::span<const std::uint8_t> reply,
                      const ArtnetAnswers::Requester& requester, std::uint16_t udp_port);

}  // namespace footlight::drivers
