// Art-Net out, as a port of the pump. Made with make_artnet_sink() in net.h; the class is here for what only Art-Net
// counts.
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

// With more receivers of one universe than this a broadcast costs less (art-net.org.uk, "Subscription").
inline constexpr std::size_t kArtnetSubscribersMax = 40;

struct ArtnetSinkDetails {
  std::uint64_t polls = 0;           // ArtPoll sent, per network
  std::uint64_t replies = 0;         // ArtPollReply heard
  std::uint64_t polls_answered = 0;  // of other controllers
  std::uint64_t sync = 0;            // ArtSync sent, per destination
};

// Without a fixed address: asks every 2.5 to 3 s who is there, sends each universe by unicast to the devices that take
// it, and at once to one that comes. A universe that no device takes goes where ArtnetSinkOptions::unsubscribed says.
// Devices on this machine are reached by broadcast on loopback, since unicast to a shared port has one receiver.
class ArtnetSink final : public NetSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArtnetSink>> create(const ArtnetSinkOptions& options);
  [[nodiscard]] int poll_fd() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;
  [[nodiscard]] const ArtnetSinkDetails& details() const { return details_; }
  // Where a universe (by its place in the options) goes now. IPv4, ascending while devices are searched for.
  [[nodiscard]] std::vector<std::uint32_t> receivers_of(std::size_t place) const;

 private:
  // `broadcasts`: where levels go that nobody has asked for; with fixed addresses, those.
  ArtnetSink(const ArtnetSinkOptions& options, const std::vector<std::uint32_t>& broadcasts, std::vector<Link> links);
  std::size_t write_packet(const Packet& packet) override;
  void add_after(TimeNs now_ns, std::span<const std::size_t> places) override;
  [[nodiscard]] bool says_goodbye() const override { return false; }

  [[nodiscard]] bool is_searching() const { return options_.addresses.empty(); }
  [[nodiscard]] const Fd& socket() const { return links().front().socket; }
  void read_socket(TimeNs now_ns);
  void ask_around(TimeNs now_ns);
  // Has universes go to the devices that are there now, and sends new ones the look.
  void follow_nodes(TimeNs now_ns);
  bool answer(const ArtnetAnswers::Asker& asker);

  ArtnetSinkOptions options_;
  std::shared_ptr<OwnSenders> program_;  // of the options, or one of our own
  std::shared_ptr<ArtnetOwnFrames> own_frames_;
  std::vector<Destination> broadcasts_;
  std::vector<int> port_addresses_;      // per universe
  std::vector<std::uint8_t> sequences_;  // per universe, 1 to 255: 0 would say that there is none
  std::vector<std::uint32_t> own_ipv4s_;
  std::vector<std::uint32_t> polled_;  // broadcast addresses of the last search
  std::vector<int> interfaces_;        // those that the options name
  bool any_here_ = false;              // a receiver is on this machine
  std::uint64_t revision_ = 0;         // of the devices that the destinations were made from
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
