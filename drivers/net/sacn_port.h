// sACN in and out as ports of the pump. Made with make_sacn_source() and make_sacn_sink() in net.h; this header adds
// the counters of sACN.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "drivers/net/net_sink.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_receiver.h"

namespace footlight::drivers {

// The rules are in sacn_receiver.h and sacn_synchroniser.h; this class joins the groups, including those of
// synchronisation addresses.
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

// In addition to frames, as the options request: priorities per address before the levels, at most 925 ms apart; a
// synchronisation packet after each batch; and the list of its universes every 10 s.
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
  // For one universe, or for the synchronisation of several.
  [[nodiscard]] std::vector<Destination> destinations_of(int universe, std::span<const std::uint32_t> unicast) const;
  std::size_t write_packet(const Packet& packet) override;
  void add_before(TimeNs now_ns, std::span<const std::size_t> places) override;
  void add_after(TimeNs now_ns, std::span<const std::size_t> places) override;
  [[nodiscard]] bool ends_streams() const override { return true; }
  // The main sink may have the same identifier if a user chose it. Ending the universe here would then end the main
  // sink's.
  [[nodiscard]] bool ends_streams_at_rest() const override { return !cid_is_chosen_; }
  void announce();

  std::string source_name_;
  Cid cid_;
  bool cid_is_chosen_ = false;
  std::vector<std::uint8_t> sequences_;  // per universe, shared by levels and priorities (E1.31-2018 section 6.7.2)

  // Priorities per address, if the options have them.
  std::vector<std::uint8_t> address_priorities_;
  std::vector<std::array<std::uint8_t, kSacnDataBytesMax>> priority_packets_;  // per universe
  std::vector<TimeNs> priorities_due_ns_;                                      // per universe
  std::vector<int> priorities_left_;  // per universe: how many of the next frames they precede, due or not

  int sync_universe_ = 0;  // 0: not synchronised
  std::uint8_t sync_sequence_ = 0;
  std::vector<Destination> sync_destinations_;
  std::array<std::uint8_t, kSacnSyncBytes> sync_packet_ = {};

  std::vector<Destination> announce_destinations_;  // none: no announcements
  TimeNs announce_due_ns_ = kTimeNever;             // kTimeNever before the first frame
};

}  // namespace footlight::drivers
