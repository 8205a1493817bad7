// sACN in and out as ports of the pump. Made with make_sacn_source() and make_sacn_sink() in net.h; the classes are
// here for what only sACN counts.
#pragma once

#include <memory>
#include <vector>

#include "drivers/net/net_sink.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sequence.h"

namespace footlight::drivers {

// Sound datagrams that gave no frame, by reason.
struct SacnSourceDetails {
  std::uint64_t late = 0;              // sequence number at or up to 19 behind the newest of its sender
  std::uint64_t preview = 0;           // flagged as preview
  std::uint64_t other_start_code = 0;  // per-address priority and other start codes than 0
  std::uint64_t other_universe = 0;    // a universe that this source does not carry
  std::uint64_t own = 0;               // sent by this program
  std::uint64_t ended_already = 0;     // second and third packet of a sender that stops
  std::uint64_t sync = 0;
  std::uint64_t discovery = 0;
};

// Frames with a synchronisation address are passed on as they come, as E1.31-2018 section 6.2.4.1 has it for receivers
// that do not synchronise.
class SacnSource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SacnSource>> create(const SacnSourceOptions& options);
  [[nodiscard]] const SacnSourceDetails& details() const { return details_; }

 private:
  explicit SacnSource(const SacnSourceOptions& options);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;
  void take_data(const SacnData& data, TimeNs stamp_ns, FrameReceiver& receiver);

  bool hear_preview_;
  std::shared_ptr<OwnSenders> own_senders_;
  std::vector<SequenceFilter> filters_;  // per universe
  SacnSourceDetails details_;
};

class SacnSink final : public NetSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SacnSink>> create(const SacnSinkOptions& options);
  [[nodiscard]] const Cid& cid() const { return cid_; }

 private:
  // `unicast`: the receivers; none: multicast.
  SacnSink(const SacnSinkOptions& options, std::vector<Link> links, std::span<const std::uint32_t> unicast);
  // Of one universe, or of the synchronisation of several.
  [[nodiscard]] std::vector<Destination> destinations_of(int universe, std::span<const std::uint32_t> unicast) const;
  std::size_t write_packet(const Packet& packet) override;
  [[nodiscard]] bool says_goodbye() const override { return true; }

  Cid cid_;
  std::vector<std::uint8_t> sequences_;  // per universe
};

}  // namespace footlight::drivers
