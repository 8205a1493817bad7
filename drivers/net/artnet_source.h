// Art-Net in, as a port of the pump. Made with make_artnet_source() in net.h; this header adds the counters of Art-Net.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/net/artnet_gateway.h"
#include "drivers/net/artnet_nodes.h"
#include "drivers/net/artnet_packet.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sequence.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

// A sender silent for this long is no longer merged (Art-Net 4, "Data Merging"; senders may be silent for 4 s,
// "Streaming Packets").
inline constexpr DurationNs kArtnetSilenceMaxNs = 10 * kNsPerS;
// Frames are held for ArtSync until this long after the last ArtSync.
inline constexpr DurationNs kArtnetSyncTimeoutNs = 4 * kNsPerS;

// Valid datagrams that gave no frame, by reason.
struct ArtnetSourceDetails {
  std::uint64_t late = 0;
  std::uint64_t other_universe = 0;
  std::uint64_t other_interface = 0;
  std::uint64_t own = 0;
  std::uint64_t polls = 0;  // ArtPoll
  std::uint64_t polls_answered = 0;
  std::uint64_t sync = 0;
  std::uint64_t sync_ignored = 0;  // of a sender whose frames we do not use
  std::uint64_t held = 0;          // frames that waited for ArtSync
  std::uint64_t replies = 0;       // ArtPollReply
  std::uint64_t rdm = 0;           // ArtRdm, ArtTodRequest and ArtTodControl
  std::uint64_t other_op_code = 0;
};

// A sender is an IPv4 address, as in Art-Net's rule for merging; two programs on one machine count as one.
//
// ArtSync: after the first one of a sender, its frames are held, the newest of each universe, until its next ArtSync.
// They are then delivered together, stamped with its arrival. A universe with a second sender is merged and not held.
// Four seconds without ArtSync end the synchronisation, and held frames are delivered.
class ArtnetSource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArtnetSource>> create(const ArtnetSourceOptions& options);
  ~ArtnetSource() override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::string sender_text(SenderId sender) const override;
  [[nodiscard]] SenderLosses sender_losses(std::size_t place, SenderId sender) const override {
    return states_[place].filter.losses(sender);
  }
  [[nodiscard]] const ArtnetSourceDetails& details() const { return details_; }

 private:
  // Senders of one universe that are distinguished for merging and ArtSync.
  static constexpr std::size_t kSendersMax = 4;
  static constexpr std::size_t kSyncSendersMax = 16;
  static constexpr std::size_t kNameRequestsMax = 64;

  struct Held {
    Slots slots = {};
    std::size_t slot_count = 0;
    std::uint32_t ipv4 = 0;
    std::uint8_t sequence = 0;
    bool full = false;
  };
  struct Sender {
    std::uint32_t ipv4 = 0;
    TimeNs received_ns = -kTimeNever;
  };
  struct UniverseState {
    SequenceFilter filter;
    std::array<Sender, kSendersMax> senders;
    std::unique_ptr<Held> held;    // made when the first frame is held
    bool reported_active = false;  // state in the last replies
    bool reported_merging = false;
  };
  struct Sync {
    std::uint32_t ipv4 = 0;
    TimeNs until_ns = -kTimeNever;
  };

  explicit ArtnetSource(const ArtnetSourceOptions& options);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;
  void take_dmx(const ArtnetDmx& dmx, const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver);
  void take_sync(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver);
  void take_poll(const ArtnetPoll& poll, const Datagram& datagram, TimeNs now_ns);
  void deliver_frame(std::size_t place, std::uint32_t ipv4, std::uint8_t sequence, TimeNs stamp_ns,
                     std::span<const std::uint8_t> slots, FrameReceiver& receiver);
  void release(std::size_t place, TimeNs stamp_ns, FrameReceiver& receiver);
  [[nodiscard]] bool is_synchronous(std::uint32_t ipv4, TimeNs now_ns) const;
  [[nodiscard]] std::size_t live_senders(std::size_t place, TimeNs now_ns) const;

  // Sends all replies, or those whose ports are in range; false: more follow.
  bool answer(ArtnetAnswers::Requester& requester, TimeNs now_ns);
  void build_reply(std::size_t group, const ArtnetAnswers::Requester& requester, TimeNs now_ns,
                   std::span<std::uint8_t> out);
  // Finds ports whose state differs from the last replies, and sends replies to the subscribers.
  void report_changes(TimeNs now_ns);
  void send_rdm();
  void request_name(const Datagram& datagram, TimeNs now_ns);

  ArtnetSourceOptions options_;
  std::shared_ptr<OwnSenders> program_;  // from the options, or an own one
  std::vector<int> port_addresses_;      // per universe
  std::vector<UniverseState> states_;    // per universe
  // The content of each ArtPollReply: one universe, or up to four of one sub-net if there are more than 255.
  std::vector<std::vector<std::size_t>> groups_;
  ArtnetAnswers answers_;
  std::map<std::uint32_t, ArtnetAnswers::Requester> watchers_;  // requested replies on change; due_ns: end of the
                                                                // subscription
  TimeNs next_watch_ns_ = kTimeNever;
  std::vector<Sync> syncs_;
  std::vector<std::size_t> held_places_;
  std::map<std::uint32_t, TimeNs> requested_ns_;  // senders whose name was requested, and when
  std::map<SenderId, std::uint32_t> ipv4_of_sender_;
  std::unique_ptr<ArtnetGateway> gateway_;  // empty: disabled
  std::vector<ArtnetGateway::Reply> rdm_replies_;
  std::uint64_t seed_ = 0;
  ArtnetSourceDetails details_;
  DatagramWriter writer_;
};

}  // namespace footlight::drivers
