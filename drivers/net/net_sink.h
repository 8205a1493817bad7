// Common part of the sACN and Art-Net sinks: detection of new frames, repeats, destinations of each universe, and
// batched sending. A protocol derives from it and writes the packets.
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

// After a change the same levels are sent this many times more, so that a lost datagram does not leave old levels, and
// then at the keep-alive interval (E1.31-2018 section 6.6.2 requires three, and 800 to 1000 ms).
inline constexpr int kRepeats = 3;
inline constexpr DurationNs kRepeatIntervalNs = 25 * kNsPerMs;
inline constexpr DurationNs kKeepAliveNs = 900 * kNsPerMs;
// Retry intervals when the send buffer was full, and when the network is down.
inline constexpr DurationNs kRetryFullNs = 2 * kNsPerMs;
inline constexpr DurationNs kRetryDownNs = 500 * kNsPerMs;

// A datagram for several receivers is sent to each. An unreachable one is counted as an error and skipped until the
// next frame or keep-alive. The sink is kGone only while no receiver can be reached.
class NetSink : public Sink {
 public:
  [[nodiscard]] std::string name() const override { return settings_.name; }
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override { return trouble_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::span<const Universe> universes() const override { return show_universes_; }
  [[nodiscard]] double rate_hz_max() const override { return settings_.rate_hz_max; }
  // Frames marked `terminated` or without levels are skipped: a sink repeats the last levels until close().
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  // Ends the streams if the protocol supports that, and stops repeating; the next send() starts again.
  void rest(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;

 protected:
  static constexpr std::size_t kPacketBytesMax = 640;

  // One route: a socket whose multicast leaves through one interface.
  struct Link {
    Fd socket;
    std::string interface_name;  // empty: the routing table decides
    bool failed = false;         // the last datagrams were refused
  };
  struct Destination {
    std::uint32_t ipv4 = 0;
    std::uint8_t link = 0;
  };
  struct Packet {
    std::span<std::uint8_t> bytes;  // of this universe; keeps what was written last time
    std::size_t place = 0;          // in settings.universes
    bool terminated = false;
    std::span<const std::uint8_t> slots;  // 0 to 512
  };

  // At least one link.
  NetSink(const NetSinkOptions& options, std::vector<Link> links);

  // One link per interface; without interfaces, one whose route the routing table decides. Errors: as find_interface()
  // and open_sender().
  [[nodiscard]] static Result<std::vector<Link>> open_links(const std::string& port_name,
                                                            const std::vector<std::string>& interface_names,
                                                            int multicast_ttl);
  // An error if one of the receivers has no route; queries the routing table and sends nothing.
  [[nodiscard]] static Status check_routes(const std::string& port_name, std::span<const Link> links,
                                           std::span<const Destination> destinations);

  // The receivers of a universe; none: its frames are kept but not sent. May change at any time between calls.
  void set_destinations(std::size_t place, std::vector<Destination> destinations);
  [[nodiscard]] std::span<const Destination> destinations(std::size_t place) const {
    return outlets_[place].destinations;
  }

  // Writes the next packet of a universe, with its sequence number, and returns its size.
  virtual std::size_t write_packet(const Packet& packet) = 0;
  // Called before and after the packets of one batch, which carries the universes at `places`. Packets that they add()
  // are sent in the same batch, before or after the universes.
  virtual void add_before(TimeNs /*now_ns*/, std::span<const std::size_t> /*places*/) {}
  virtual void add_after(TimeNs /*now_ns*/, std::span<const std::size_t> /*places*/) {}
  // `bytes` must stay valid until the batch has been sent.
  void add(std::span<const std::uint8_t> bytes, std::span<const Destination> destinations);
  // Sends what was added outside of a batch, now.
  void send_added();
  // Sends the newest levels of a universe again with the next poll(), which is due at once.
  void send_again(std::size_t place, TimeNs now_ns);
  void count_error() { ++counters_.errors; }
  void count_rejected() { ++counters_.rejected; }
  // True if close() sends three packets that end each universe; the second: the same for rest().
  [[nodiscard]] virtual bool ends_streams() const = 0;
  [[nodiscard]] virtual bool ends_streams_at_rest() const { return ends_streams(); }

  [[nodiscard]] std::span<std::uint8_t> packet_bytes(std::size_t place) { return outlets_[place].packet; }
  [[nodiscard]] bool is_open() const { return !links_.empty(); }
  // True if the universe has had a frame.
  [[nodiscard]] bool is_known(std::size_t place) const { return outlets_[place].known; }
  [[nodiscard]] const NetSinkOptions& settings() const { return settings_; }
  [[nodiscard]] std::span<const Link> links() const { return links_; }

 private:
  static constexpr std::size_t kNoPlace = SIZE_MAX;

  struct Outlet {
    std::array<std::uint8_t, kPacketBytesMax> packet = {};
    Slots slots = {};
    std::size_t slot_count = 0;  // the longest frame so far
    int repeats_left = 0;
    bool known = false;    // has had a frame
    bool unsent = false;   // the system refused its newest levels, which are still unsent
    bool pending = false;  // is in pending_
    // The result of the current batch.
    bool reached = false;  // at least one receiver, or there is none
    bool refused = false;  // the send buffer was full
    std::vector<Destination> destinations;
  };
  // One datagram of the current batch.
  struct Entry {
    std::span<const std::uint8_t> bytes;
    std::uint32_t ipv4 = 0;
    std::size_t place = kNoPlace;  // of the universe that it carries
  };

  // An interface that was removed and returns has another number; finds it again by its name.
  void find_interface_again(Link& link);
  void add_pending(std::size_t place);
  // Ends every universe that has had a frame, with three packets each.
  void end_streams();
  // Sends one packet of each universe in pending_, and clears it.
  void transmit(TimeNs now_ns);
  void add_entry(std::span<const std::uint8_t> bytes, std::span<const Destination> destinations, std::size_t place);
  // Sends entries_ link by link and clears them. True: at least one was sent.
  bool flush_entries();
  bool flush_link(Link& link, const std::vector<Entry>& entries);

  const NetSinkOptions settings_;
  std::vector<Universe> show_universes_;
  UniverseIndex show_index_;
  std::vector<Outlet> outlets_;
  std::vector<TimeNs> due_ns_;  // per universe; kTimeNever before its first frame
  std::vector<std::size_t> pending_;
  std::vector<Link> links_;                  // none: closed
  std::vector<std::vector<Entry>> entries_;  // per link
  std::vector<int> error_numbers_;           // of flush_link(): per datagram
  DatagramWriter writer_;
  PortCounters counters_;
  std::string trouble_;  // why nothing could be sent
  std::string refusal_;  // the system's last error in the current batch
  bool has_sent_ = false;
};

}  // namespace footlight::drivers
