// Who else speaks Art-Net: a table of devices and ports, filled from ArtPollReply, and what the Art-Net ports of one
// program know in common. No socket, no clock; the pump's thread only.
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
// A device that has left three polls unanswered has gone. The document gives it one poll and 3 s; but one lost datagram
// must not turn a lamp off.
inline constexpr DurationNs kArtnetNodeTimeoutNs = 10 * kNsPerS;
// A device answers within this, at a random moment, so that a thousand do not answer at once ("ArtPollReply").
inline constexpr DurationNs kArtnetReplyDelayMaxNs = kNsPerS;
// Everybody on this machine who listens on all addresses.
inline constexpr std::uint32_t kLoopbackBroadcast = 0x7FFF'FFFF;

[[nodiscard]] constexpr bool is_loopback(std::uint32_t ipv4) { return ipv4 >> 24 == 127; }
// That the datagram left this machine: it comes from the address that it arrives at, or from any of 127.0.0.0/8.
[[nodiscard]] inline bool is_from_here(const Datagram& datagram) {
  return is_loopback(datagram.from_ipv4) || datagram.from_ipv4 == datagram.local_ipv4;
}

// A device, for people.
struct ArtnetNode {
  std::uint32_t ipv4 = 0;
  int interface_index = 0;  // where its answers come in
  std::string short_name;
  std::string long_name;
  std::array<std::uint8_t, 6> mac = {};
  ArtnetPollReply::Style style = ArtnetPollReply::Style::kNode;
  bool rdm = false;
  TimeNs heard_ns = 0;
  // Port addresses, ascending: what it takes from Art-Net and what it gives to Art-Net.
  std::vector<int> outputs;
  std::vector<int> inputs;
};

// A device is an IPv4 address; each of its replies (they differ by bind index, or not even by that) adds its ports. A
// port, like the device, is forgotten when no reply has named it for kArtnetNodeTimeoutNs.
class ArtnetNodes {
 public:
  // Devices, and ports of one device, at a time; what comes on top is not taken, so that made-up replies cost no
  // memory.
  static constexpr std::size_t kNodesMax = 1'024;
  static constexpr std::size_t kPortsPerNodeMax = 2'048;

  void hear(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns);
  // Forgets. Cheap before the first can have timed out.
  void expire(TimeNs now_ns);
  // Goes up when a port comes or goes.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

  // Appends the addresses of the devices that take this port address (`output`), or that give it. `interfaces`: only
  // those heard on one of these; empty: all.
  void subscribers_of(int port_address, bool output, std::span<const int> interfaces,
                      std::vector<std::uint32_t>& ipv4s) const;
  // Empty: not known.
  [[nodiscard]] std::string name_of(std::uint32_t ipv4) const;
  // By address.
  [[nodiscard]] std::vector<ArtnetNode> list() const;

 private:
  struct Device {
    ArtnetNode node;              // without its ports
    std::map<int, TimeNs> ports;  // 2 * port address + (1: output); when last heard
  };
  std::map<std::uint32_t, Device> devices_;
  TimeNs next_expiry_ns_ = kTimeNever;
  std::uint64_t revision_ = 0;
};

// A digest of the levels of one ArtDmx, to know one's own again.
[[nodiscard]] std::uint64_t artnet_digest(std::span<const std::uint8_t> slots);

// What one sink has sent lately. Its frames come back by broadcast, from the address and the UDP port of every other
// program on this machine; their content tells them apart.
class ArtnetOwnFrames {
 public:
  void note(int port_address, std::uint8_t sequence, std::uint64_t digest) {
    digests_[port_address][sequence] = digest;
  }
  [[nodiscard]] bool has(int port_address, std::uint8_t sequence, std::uint64_t digest) const {
    const auto found = digests_.find(port_address);
    return found != digests_.end() && digest != 0 && found->second[sequence] == digest;
  }

 private:
  std::unordered_map<int, std::array<std::uint64_t, 256>> digests_;
};

// The Art-Net ports of one program. What one of them hears serves all: an answer to a sink's poll arrives at the
// source's socket where there is a source, since unicast to UDP port 6454 has one receiver.
//
// Ports come and go on any thread; the rest is the pump's.
class ArtnetProgram {
 public:
  ArtnetNodes nodes;

  // A reply, unless it is one of this program's own.
  void hear(const ArtnetPollReply& reply, const Datagram& datagram, TimeNs now_ns);

  // --- Sources
  void add_source(const std::vector<int>& port_addresses);
  void remove_source(const std::vector<int>& port_addresses);
  [[nodiscard]] bool has_sources() const { return source_count_.load(std::memory_order_relaxed) > 0; }

  // --- Sinks. What the last kClosedSinksMax that have closed sent stays known, since datagrams may still be on their
  // way.
  static constexpr std::size_t kClosedSinksMax = 8;
  [[nodiscard]] std::shared_ptr<ArtnetOwnFrames> add_sink();
  [[nodiscard]] bool is_own_frame(const ArtnetDmx& dmx) const;

  // --- Polls. Several sinks poll a network once.
  // True where nobody of this program has polled there in the last interval; then it counts as done.
  [[nodiscard]] bool may_poll(std::uint32_t broadcast, TimeNs now_ns);
  // Whether a poll from this machine is one of ours, come back: it arrives within a moment. A stranger's poll in that
  // moment is left unanswered once; neither polls at a fixed interval.
  [[nodiscard]] bool is_own_poll(TimeNs arrived_ns) const;
  void note_sync(TimeNs now_ns) { sync_ns_ = now_ns; }
  [[nodiscard]] bool is_own_sync(TimeNs arrived_ns) const;

 private:
  mutable std::mutex mutex_;
  std::map<int, int> heard_port_addresses_;                   // guarded by mutex_; how many sources have it
  std::vector<std::shared_ptr<ArtnetOwnFrames>> own_frames_;  // guarded by mutex_: the list, not what is in it
  std::atomic<int> source_count_ = 0;
  std::map<std::uint32_t, TimeNs> polled_ns_;
  TimeNs poll_ns_ = -kTimeNever;
  TimeNs sync_ns_ = -kTimeNever;
};

// The polls that wait for their answer.
class ArtnetAnswers {
 public:
  static constexpr std::size_t kAskersMax = 256;
  // Replies to one asker that go at once, and the pause until the next so many, so that a console's buffer holds them.
  static constexpr std::size_t kRepliesAtOnce = 32;
  static constexpr DurationNs kPauseNs = 10 * kNsPerMs;

  struct Asker {
    std::uint32_t ipv4 = 0;
    std::uint16_t udp_port = 0;
    std::uint32_t local_ipv4 = 0;  // ours, as it reaches us
    int interface_index = 0;
    std::array<std::uint8_t, 6> mac = {};  // of our interface there
    bool is_here = false;                  // on this machine
    int port_address_first = 0;
    int port_address_last = kArtnetPortAddressMax;
    TimeNs due_ns = 0;
    std::size_t next_reply = 0;  // of the replies that tell all ports
  };

  // `seed` differs from machine to machine. One who asks again while an answer is due gets that one.
  void add(const ArtnetPoll& poll, const Datagram& datagram, std::uint64_t seed, TimeNs now_ns);
  [[nodiscard]] TimeNs next_due_ns() const;
  // Calls `answer` for each asker whose time has come; it returns whether that asker has got everything, and has set a
  // later due_ns otherwise.
  void answer_due(TimeNs now_ns, const std::function<bool(Asker&)>& answer);

 private:
  std::vector<Asker> askers_;
  std::uint64_t count_ = 0;
};

[[nodiscard]] std::array<std::uint8_t, 4> octets_of(std::uint32_t ipv4);
// The hardware address of an interface of this machine; zeros where there is none.
[[nodiscard]] std::array<std::uint8_t, 6> mac_of(int interface_index);
// Differs from machine to machine.
[[nodiscard]] std::uint64_t artnet_machine_seed();

// Adds a reply to `writer` for an asker: to the protocol's UDP port, and to the one that it asked from where that is
// another. Programs on this machine share the protocol's port, and unicast to it would reach any one of them: they are
// answered by broadcast on loopback.
void add_artnet_reply(DatagramWriter& writer, std::span<const std::uint8_t> reply, const ArtnetAnswers::Asker& asker,
                      std::uint16_t udp_port);

}  // namespace footlight::drivers
