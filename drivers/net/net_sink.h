// What sACN and Art-Net sinks have in common: which frame is new, when an old one is said again, and batched sending. A
// protocol derives from it and writes the packets.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/net/net.h"
#include "drivers/net/udp.h"
#include "drivers/net/universe_index.h"
#include "sim/core/dmx.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// After a change the same levels go out this many times more, so that a lost datagram does not leave a stale look, and
// then at the pace of the keep-alive (E1.31-2018 section 6.6.2 asks for three, and for 800 to 1000 ms).
inline constexpr int kRepeats = 3;
inline constexpr DurationNs kRepeatIntervalNs = 25 * kNsPerMs;
inline constexpr DurationNs kKeepAliveNs = 900 * kNsPerMs;
// When the send buffer was full, and when the network is down.
inline constexpr DurationNs kRetryFullNs = 2 * kNsPerMs;
inline constexpr DurationNs kRetryDownNs = 500 * kNsPerMs;

class NetSink : public Sink {
 public:
  [[nodiscard]] std::string name() const override { return settings_.name; }
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override { return trouble_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::span<const Universe> universes() const override { return show_universes_; }
  [[nodiscard]] double rate_hz_max() const override { return settings_.rate_hz_max; }
  // Frames that say `terminated` are passed over: a sink goes on with the last look until close().
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;

 protected:
  static constexpr std::size_t kPacketBytesMax = 640;

  struct Settings {
    std::string name;
    std::vector<WireUniverse> universes;
    std::string interface_name;  // empty: the routing table decides
    std::uint16_t udp_port = 0;
    double rate_hz_max = 0.0;
  };
  struct Packet {
    std::span<std::uint8_t> bytes;  // of this universe alone; keeps what was written last time
    std::size_t place = 0;          // in settings.universes
    bool terminated = false;
    std::span<const std::uint8_t> slots;  // 0 to 512
  };

  // `destinations`: IPv4 per universe.
  NetSink(Settings settings, std::vector<std::uint32_t> destinations, Fd socket);

  // Writes the next packet of a universe and returns its size; numbers it too.
  virtual std::size_t write_packet(const Packet& packet) = 0;
  // IPv4 addresses that the packets of a universe go to; may be empty. Valid until the next change by the protocol.
  [[nodiscard]] virtual std::span<const std::uint32_t> destinations_of(std::size_t place) const {
    return {&destinations_[place], 1};
  }
  // Adds what follows the packets of one call, such as a synchronisation packet; its bytes stay until the next call.
  virtual void end_batch(DatagramWriter& /*writer*/) {}
  // Has the newest look of a universe go out with the next poll(), which is due at once.
  void send_again(std::size_t place, TimeNs now_ns);
  [[nodiscard]] const Fd& socket() const { return socket_; }
  void count_error() { ++counters_.errors; }
  void count_rejected() { ++counters_.rejected; }
  // Whether close() sends three packets that end each universe.
  [[nodiscard]] virtual bool says_goodbye() const = 0;
  [[nodiscard]] std::span<std::uint8_t> packet_bytes(std::size_t place) { return outlets_[place].packet; }

 private:
  struct Outlet {
    std::array<std::uint8_t, kPacketBytesMax> packet = {};
    Slots slots = {};
    std::size_t slot_count = 0;  // the longest frame so far
    int repeats_left = 0;
    bool known = false;    // has had a frame
    bool unsent = false;   // its newest levels were refused by the system and have not left yet
    bool pending = false;  // is in pending_
  };

  // An interface that has gone and come back has another number; finds it again by its name.
  void find_interface_again();
  void add_pending(std::size_t place);
  // Sends one packet of each universe in pending_, and clears that.
  void transmit(TimeNs now_ns);

  Settings settings_;
  std::vector<Universe> show_universes_;
  UniverseIndex show_index_;
  std::vector<std::uint32_t> destinations_;
  std::vector<Outlet> outlets_;
  std::vector<TimeNs> due_ns_;  // per universe; kTimeNever before its first frame
  std::vector<std::size_t> pending_;
  std::vector<std::size_t> ends_;   // of transmit(): the datagrams of pending_[i] end before ends_[i]
  std::vector<int> error_numbers_;  // of transmit(): per datagram
  Fd socket_;
  DatagramWriter writer_;
  PortCounters counters_;
  std::string trouble_;
  bool has_sent_ = false;
};

}  // namespace footlight::drivers
