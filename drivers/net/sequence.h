// Tells late and doubled datagrams from new ones, for one universe and each of its senders (E1.31-2018 section 6.7.2).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/core/dmx.h"

namespace footlight::drivers {

// After this long without a datagram a sender is forgotten, and any sequence number is new again (E1.31 section 6.7.1).
inline constexpr DurationNs kSenderTimeoutNs = 2'500 * kNsPerMs;

class SequenceFilter {
 public:
  // Senders remembered at a time; one more takes the place of the one silent for longest, so a flood of made-up senders
  // costs no memory.
  static constexpr std::size_t kSendersMax = 16;

  enum class Verdict { kNew, kLate, kEndedAlready };

  // `equal_is_late`: sACN discards a repeated number, since the same datagram arrives once per interface that joined
  // its group. Art-Net frames with a number that never moves are taken.
  // kEndedAlready: the second and third of the three packets that say that a sender stops.
  Verdict judge(SenderId sender, std::uint8_t sequence, bool terminated, bool equal_is_late, TimeNs now_ns) {
    auto known = std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.id == sender; });
    if (known == senders_.end()) {
      if (senders_.size() < kSendersMax) {
        known = senders_.insert(senders_.end(), Sender{});
      } else {
        known = std::min_element(senders_.begin(), senders_.end(),
                                 [](const Sender& a, const Sender& b) { return a.heard_ns < b.heard_ns; });
      }
      *known = {sender, now_ns, sequence, terminated};
      return Verdict::kNew;
    }
    if (now_ns - known->heard_ns < kSenderTimeoutNs) {
      const int step = static_cast<std::int8_t>(static_cast<std::uint8_t>(sequence - known->sequence));
      if (step > -20 && (step < 0 || (step == 0 && equal_is_late))) return Verdict::kLate;
      if (terminated && known->terminated) {
        known->sequence = sequence;
        return Verdict::kEndedAlready;
      }
    }
    *known = {sender, now_ns, sequence, terminated};
    return Verdict::kNew;
  }

 private:
  struct Sender {
    SenderId id = 0;
    TimeNs heard_ns = 0;
    std::uint8_t sequence = 0;
    bool terminated = false;
  };
  std::vector<Sender> senders_;
};

}  // namespace footlight::drivers
