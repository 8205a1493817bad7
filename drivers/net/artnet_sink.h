// Art-Net out, as a port of the pump. Made with make_artnet_sink() in net.h; this header adds the counters of Art-Net.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "drivers/net/artnet_nodes.h"
#include "drivers/net/artnet_packet.h"
#include "drivers/net/net_sink.h"

namespace footlight::drivers {

// With more receivers of one universe a broadcast costs less (art-net.org.uk, "Subscription").
inline constexpr std::size_t kArtnetSubscribersMax = 40;

struct ArtnetSinkDetails {
  std::uint64_t polls = 0;           // ArtPoll sent, per network
  std::uint64_t replies = 0;         // ArtPollReply received
  std::uint64_t polls_answered = 0;  // of other controllers
  std::uint64_t sync = 0;            // ArtSync sent, per destination
};

// Without a fixed address it polls the network every 2.5 to 3 s and sends each universe by unicast to the devices that
// take it, and at once to a new one. A universe that no device takes follows ArtnetSinkOptions::unsubscribed. Devices
// on this machine are reached by broadcast on loopback, since unicast to a shared port has one receiver.
class ArtnetSink final : public NetSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArtnetSink>> create(const ArtnetSinkOptions& options);
  [[nodiscard]] int poll_fd() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;
  [[nodiscard]] const ArtnetSinkDetails& details() const { return details_; }
  // The current receivers of a universe (by its place in the options). IPv4, ascending while devices are searched for.
  [[nodiscard]] std::vector<std::uint32_t> receivers_of(std::size_t place) const;

 private:
  // `broadcasts`: the receivers of levels that no device subscribes to; with fixed addresses, those.
  ArtnetSink(const ArtnetSinkOptions& options, const std::vector<std::uint32_t>& broadcasts, std::vector<Link> links);
  std::size_t write_packet(const Packet& packet) override;
  void add_after(TimeNs now_ns, std::span<const std::size_t> places) override;
  [[nodiscard]] bool ends_streams() const override { return false; }

  [[nodiscard]] bool is_searching() const { return options_.addresses.empty(); }
  [[nodiscard]] const Fd& socket() const { return links().front().socket; }
  void read_socket(TimeNs now_ns);
  void poll_networks(TimeNs now_ns);
  // Updates the receivers of each universe from the device table, and sends new ones the current levels.
  void follow_nodes(TimeNs now_ns);
  bool answer(const ArtnetAnswers::Requester& requester);

  ArtnetSinkOptions options_;
  std::shared_ptr<OwnSenders> program_;  // from the options, or an own one
  std::shared_ptr<ArtnetOwnFrames> own_frames_;
  std::vector<Destination> broadcasts_;
  std::vector<int> port_addresses_;      // per universe
  std::vector<std::uint8_t> sequences_;  // per universe, 1 to 255: 0 would mean unnumbered
  std::vector<std::uint32_t> own_ipv4s_;
  std::vector<std::uint32_t> polled_;  // broadcast addresses of the last search
  std::vector<int> interfaces_;        // those listed in the options
  bool any_here_ = false;              // a receiver is on this machine
  std::uint64_t revision_ = 0;         // of the device table when the destinations were made
  TimeNs next_poll_ns_ = kTimeNever;
  std::uint64_t poll_count_ = 0;
  std::uint64_t seed_ = 0;
  std::array<std::uint8_t, kArtnetSyncBytes> sync_packet_ = {};
  ArtnetAnswers answers_;
  ArtnetSinkDetails details_;
  std::unique_ptr<DatagramReader> reader_;
  DatagramWriter writer_;
};

}  // namespace footlight::drivers
