// Art-Net in and out as ports of the pump. Made with make_artnet_source() and make_artnet_sink() in net.h.
#pragma once

#include <memory>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/net_sink.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sequence.h"

namespace footlight::drivers {

// Sound datagrams that gave no frame, by reason.
struct ArtnetSourceDetails {
  std::uint64_t late = 0;
  std::uint64_t other_universe = 0;
  std::uint64_t other_interface = 0;
  std::uint64_t own = 0;
  std::uint64_t polls = 0;  // ArtPoll
  std::uint64_t polls_answered = 0;
  std::uint64_t sync = 0;
  std::uint64_t other_op_code = 0;
};

// A sender is an IPv4 address, as Art-Net's own rule for merging has it; two programs on one machine count as one.
class ArtnetSource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArtnetSource>> create(const ArtnetSourceOptions& options);
  [[nodiscard]] const ArtnetSourceDetails& details() const { return details_; }

 private:
  explicit ArtnetSource(const ArtnetSourceOptions& options);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;
  void take_dmx(const ArtnetDmx& dmx, const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver);
  void answer(const ArtnetPoll& poll, const Datagram& datagram, TimeNs now_ns);

  ArtnetSourceOptions options_;
  // Up to four universes of one net and sub-net: what one ArtPollReply can tell.
  struct Group {
    std::vector<std::size_t> places;
  };
  std::vector<Group> groups_;
  std::vector<SequenceFilter> filters_;  // per universe
  std::vector<TimeNs> heard_ns_;         // per universe
  ArtnetSourceDetails details_;
  DatagramWriter writer_;
};

class ArtnetSink final : public NetSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArtnetSink>> create(const ArtnetSinkOptions& options);

 private:
  ArtnetSink(const ArtnetSinkOptions& options, const std::vector<Destination>& destinations, std::vector<Link> links);
  std::size_t write_packet(const Packet& packet) override;
  [[nodiscard]] bool says_goodbye() const override { return false; }

  std::vector<int> port_addresses_;      // per universe
  std::vector<std::uint8_t> sequences_;  // per universe, 1 to 255: 0 would say that there is none
};

}  // namespace footlight::drivers
