// The receiver's rules of E1.31-2018: which frames are used, in which order, and when. No socket, no clock; SacnSource
// (sacn_port.h) feeds it from the network, the fuzz target from a file.
//
// - Levels (start code 0) and priorities per address (0xDD) are delivered; other start codes are counted. Sequence
//   numbers are checked per universe, sender and start code: some senders number start codes together, some separately.
// - Priorities per address are not held for synchronisation, and the end of a sender takes effect at once.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/net/net.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_synchroniser.h"
#include "drivers/net/sender_names.h"
#include "drivers/net/sequence.h"
#include "drivers/net/universe_index.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// Valid datagrams that gave no frame, by reason.
struct SacnSourceDetails {
  std::uint64_t late = 0;              // sequence number equal to or up to 19 behind the newest of its sender
  std::uint64_t preview = 0;           // flagged as preview
  std::uint64_t other_start_code = 0;  // neither levels nor priorities per address
  std::uint64_t other_universe = 0;    // a universe that this source does not carry
  std::uint64_t own = 0;               // sent by this program
  std::uint64_t ended_already = 0;     // second and third packet of a sender that stops
  std::uint64_t sync = 0;              // synchronisation packets
  std::uint64_t discovery = 0;
  SacnSynchroniser::Counters synchroniser;
};

class SacnReceiver {
 public:
  struct Settings {
    std::vector<WireUniverse> universes;
    bool hear_preview = false;
    std::shared_ptr<OwnSenders> own_senders;  // null: none
  };
  explicit SacnReceiver(const Settings& settings);

  // Takes one datagram that came at `now_ns`; its frames go to `receiver` before this returns. False: it is not an sACN
  // packet.
  bool take(std::span<const std::uint8_t> datagram, std::uint32_t from_ipv4, TimeNs now_ns, FrameReceiver& receiver);
  // After a datagram: the synchronisation address whose group must now be joined or left.
  [[nodiscard]] std::optional<SacnSynchroniser::Change> take_change() { return synchroniser_.take_change(); }

  [[nodiscard]] std::string sender_text(SenderId sender) const { return names_.text_of(sender); }
  // For Settings::universes[place].
  [[nodiscard]] SenderLosses losses(std::size_t place, SenderId sender) const {
    return level_filters_[place].losses(sender);
  }
  [[nodiscard]] SacnSourceDetails details() const;

 private:
  void take_data(const SacnData& data, std::uint32_t from_ipv4, TimeNs now_ns, FrameReceiver& receiver);

  bool hear_preview_;
  std::shared_ptr<OwnSenders> own_senders_;
  std::vector<Universe> show_universes_;
  UniverseIndex wire_index_;
  std::vector<SequenceFilter> level_filters_;     // per universe
  std::vector<SequenceFilter> priority_filters_;  // per universe
  SacnSynchroniser synchroniser_;
  SenderNames names_;
  SacnSourceDetails details_;
};

}  // namespace footlight::drivers
