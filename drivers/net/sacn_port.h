// sACN in and out as ports of the pump. Made with make_sacn_source() and make_sacn_sink() in net.h; the classes are
// here for what only sACN counts.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "drivers/net/net_sink.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_receiver.h"

namespace footlight::drivers {

// The rules are in sacn_receiver.h and sacn_synchroniser.h; this joins groups, those of synchronisation addresses too.
class SacnSource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SacnSource>> create(const SacnSourceOptions& options);
  [[nodiscard]] SacnSourceDetails details() const { return rules_.details(); }
  [[nodiscard]] std::string sender_text(SenderId sender) const override { return rules_.sender_text(sender); }
  [[nodiscard]] SenderLosses sender_losses(std::size_t place, SenderId sender) const override {
    return rules_.losses(place, sender);
  }

 private:
  explicit SacnSource(const SacnSourceOptions& options);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;
  void follow(const SacnSynchroniser::Change& change);

  SacnReceiver rules_;
};

// Beside the frames a sink sends, where its options ask for it: priorities per address in front of the levels, at most
// 925 ms apart; a synchronisation packet behind each batch; and the list of its universes every 10 s.
class SacnSink final : public NetSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SacnSink>> create(const SacnSinkOptions& options);
  [[nodiscard]] const Cid& cid() const { return cid_; }
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  Status poll(TimeNs now_ns) override;
  void rest(TimeNs now_ns) override;
  void close(TimeNs now_ns) override;

 private:
  // `unicast`: the receivers; none: multicast.
  SacnSink(const SacnSinkOptions& options, std::vector<Link> links, std::span<const std::uint32_t> unicast);
  // Of one universe, or of the synchronisation of several.
  [[nodiscard]] std::vector<Destination> destinations_of(int universe, std::span<const std::uint32_t> unicast) const;
  std::size_t write_packet(const Packet& packet) override;
  void add_before(TimeNs now_ns, std::span<const std::size_t> places) override;
  void add_after(TimeNs now_ns, std::span<const std::size_t> places) override;
  [[nodiscard]] bool says_goodbye() const override { return true; }
  // With an identifier that somebody chose, the sink that it stands by for may have the same: ending the universe would
  // end that one's.
  [[nodiscard]] bool says_goodbye_at_rest() const override { return !cid_is_chosen_; }
  void announce();

  std::string source_name_;
  Cid cid_;
  bool cid_is_chosen_ = false;
  std::vector<std::uint8_t> sequences_;  // per universe, of levels and priorities together (E1.31-2018 section 6.7.2)

  // Priorities per address, where the options have them.
  std::vector<std::uint8_t> address_priorities_;
  std::vector<std::array<std::uint8_t, kSacnDataBytesMax>> priority_packets_;  // per universe
  std::vector<TimeNs> priorities_due_ns_;                                      // per universe
  std::vector<int> priorities_left_;  // per universe: how many of the next frames they go in front of, due or not

  int sync_universe_ = 0;  // 0: not synchronised
  std::uint8_t sync_sequence_ = 0;
  std::vector<Destination> sync_destinations_;
  std::array<std::uint8_t, kSacnSyncBytes> sync_packet_ = {};

  std::vector<Destination> announce_destinations_;  // none: is silent about its universes
  TimeNs announce_due_ns_ = kTimeNever;             // until the first frame
};

}  // namespace footlight::drivers
