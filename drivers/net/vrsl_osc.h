// The OSC feed of VRSL's grid node, in and out, as ports of the pump.
//
// The grid node sends every changed channel as a message of its own to UDP port 12001, where VRSL's grid reader in the
// editor receives it; the reader asks the node for all channels at the port below it (12000) with
// /VRSL/Command/RefreshDMX. A message has the channel and one level (0 to 255, universes 1 to 3), or three (universes
// 1 to 3, 4 to 6 and 7 to 9, which VRSL shows as red, green and blue). Channels count from 1 and go through the cells
// of the grid: channel c of universe u is c + 520 (u - 1), and 4 to 9 share the cells of 1 to 3.
//
// The text of the address is an assumption, since the node's source is not public: sent as "/VRSL/ch12", which another
// sender for VRSL uses. Read are all addresses below /VRSL that end in the channel, and those without a number whose
// first argument is the channel.
#pragma once

#include <array>
#include <bitset>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "drivers/net/net_source.h"
#include "drivers/net/osc_packet.h"

namespace footlight::drivers {

inline constexpr std::uint16_t kVrslOscPort = 12'001;
inline constexpr int kVrslUniverses = 9;
inline constexpr int kVrslPlanes = 3;              // red, green, blue
inline constexpr int kVrslCellsPerUniverse = 520;  // 512 slots and 8 cells that are never lit
inline constexpr int kVrslCells = 3 * kVrslCellsPerUniverse;
inline constexpr std::string_view kVrslOscRefresh = "/VRSL/Command/RefreshDMX";
// A receiver with Linux's usual buffer keeps 277 small datagrams: more than this are never sent at once.
inline constexpr int kVrslOscBurst = 128;
inline constexpr DurationNs kVrslOscBurstIntervalNs = 5 * kNsPerMs;

// One cell of the grid.
struct VrslCell {
  int channel = 0;      // 1 to kVrslCells
  int level_count = 0;  // 1, or kVrslPlanes
  std::array<std::uint8_t, kVrslPlanes> levels = {};
};
// nullopt: not a cell, or out of range.
[[nodiscard]] std::optional<VrslCell> vrsl_cell_of(const OscMessage& message);

// universes: 1 to 9 on the wire.
// addresses: local; receive only datagrams sent to these. None: any. They are not asked for all channels: this machine
// is at the start, and every sender when it is first received.
struct VrslOscSourceOptions : NetSourceOptions {
  VrslOscSourceOptions() : NetSourceOptions(kVrslOscPort) {}
};
// universes: 1 to 9 on the wire; if one is above 3, messages have three levels.
// addresses: of the receivers. None: this machine.
// port: of the receivers; requests for all channels are answered at the port below it.
struct VrslOscSinkOptions : NetSinkOptions {
  VrslOscSinkOptions() : NetSinkOptions(kVrslOscPort) {}
};
[[nodiscard]] Result<std::unique_ptr<Source>> make_vrsl_osc_source(const VrslOscSourceOptions& options);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_vrsl_osc_sink(const VrslOscSinkOptions& options);

// All senders write the same levels; the newest message wins. Only changes are sent, so no sender is ever silent for
// too long. Each poll() delivers a universe at most once, with all changes.
class VrslOscSource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<VrslOscSource>> create(const VrslOscSourceOptions& options);
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  // Messages that were valid and gave no level: of other addresses, other channels and other universes.
  [[nodiscard]] std::uint64_t other_messages() const { return other_messages_; }

 private:
  VrslOscSource(Settings settings, Fd asker);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;
  void ask(std::uint32_t ipv4);

  Fd asker_;
  DatagramWriter writer_;
  std::array<std::uint8_t, 64> request_ = {};
  std::size_t request_bytes_ = 0;
  std::vector<OscMessage> messages_;
  std::vector<std::uint32_t> asked_;
  std::array<Slots, kVrslUniverses> levels_ = {};
  std::bitset<kVrslUniverses> changed_;
  TimeNs stamp_ns_ = 0;  // of the newest change
  std::uint64_t other_messages_ = 0;
};

// Sends the channels that changed, each in a datagram, at most kVrslOscBurst at once; a channel that waits is sent with
// its newest level. After a request all channels are sent. Requests come to the port below the receivers'. If another
// program holds it, there are no answers, and a notice states it.
class VrslOscSink final : public Sink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<VrslOscSink>> create(const VrslOscSinkOptions& options);
  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] int poll_fd() const override { return listener_.get(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return due_ns_; }
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override { return trouble_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return std::exchange(notice_, std::nullopt); }
  [[nodiscard]] std::span<const Universe> universes() const override { return show_universes_; }
  [[nodiscard]] double rate_hz_max() const override { return options_.rate_hz_max; }
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  void rest(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;
  // Requests for all channels.
  [[nodiscard]] std::uint64_t refreshes() const { return refreshes_; }

 private:
  VrslOscSink(const VrslOscSinkOptions& options, std::vector<std::uint32_t> receivers, Fd sender, Fd listener);
  void read_requests();
  void mark_all();
  void transmit(TimeNs now_ns);

  struct Message {
    std::array<std::uint8_t, 40> bytes;
    std::size_t size = 0;
  };

  const VrslOscSinkOptions options_;
  const std::vector<std::uint32_t> receivers_;
  const bool rgb_;
  std::vector<Universe> show_universes_;
  UniverseIndex show_index_;
  Fd sender_;
  Fd listener_;
  DatagramReader reader_;
  DatagramWriter writer_;
  std::vector<OscMessage> requests_;
  std::vector<Message> messages_;
  std::vector<int> error_numbers_;
  std::array<Slots, kVrslUniverses> levels_ = {};
  std::bitset<kVrslUniverses> known_;  // have had a frame
  std::bitset<kVrslCells> waiting_;    // to be sent
  std::size_t next_cell_ = 0;          // where the next burst begins
  TimeNs due_ns_ = kTimeNever;         // of the next burst
  TimeNs burst_ns_ = -kTimeNever;      // of the last one
  PortCounters counters_;
  std::uint64_t refreshes_ = 0;
  std::string trouble_;
  std::optional<PortNotice> notice_;
  bool has_sent_ = false;
};

}  // namespace footlight::drivers
