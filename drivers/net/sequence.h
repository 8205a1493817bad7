// Tells late and doubled datagrams from new ones, for one universe and each of its senders (E1.31-2018 section 6.7.2),
// and counts those that never came.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// After this long without a datagram a sender is forgotten, and any sequence number is new again (E1.31 section 6.7.1).
inline constexpr DurationNs kSenderTimeoutNs = 2'500 * kNsPerMs;

// How a protocol numbers the frames of a universe.
enum class SequenceRule : std::uint8_t {
  kSacn,    // 0 to 255; a repeated number is late, since a datagram arrives once per interface that joined its group
  kArtnet,  // 1 to 255 (0: not numbered, is not judged); frames whose number never moves are taken
};

class SequenceFilter {
 public:
  // Senders remembered at a time; one more takes the place of the one silent for longest, so a flood of made-up senders
  // costs no memory.
  static constexpr std::size_t kSendersMax = 16;

  enum class Verdict { kNew, kLate, kEndedAlready };

  // kEndedAlready: the second and third of the three packets that say that a sender stops.
  Verdict judge(SenderId sender, std::uint8_t sequence, bool terminated, SequenceRule rule, TimeNs now_ns) {
    const auto known = find(sender);
    if (known == senders_.end()) {
      add({.id = sender, .heard_ns = now_ns, .sequence = sequence, .terminated = terminated});
      return Verdict::kNew;
    }
    if (now_ns - known->heard_ns < kSenderTimeoutNs) {
      const int step = step_between(known->sequence, sequence, rule);
      if (step > -kLateMax && (step < 0 || (step == 0 && rule == SequenceRule::kSacn))) {
        known->take_late(-step);
        return Verdict::kLate;
      }
      known->advance(step);
      if (terminated && known->terminated) {
        known->sequence = sequence;
        return Verdict::kEndedAlready;
      }
    } else {
      known->begin_anew();
    }
    known->heard_ns = now_ns;
    known->sequence = sequence;
    known->terminated = terminated;
    return Verdict::kNew;
  }

  // A datagram of this sender and universe that is not judged here, though it may have taken a number of those that
  // are: sACN numbers all start codes of a universe together (E1.31-2018 section 6.7.2), and some senders do not.
  void skip(SenderId sender) {
    const auto known = find(sender);
    if (known != senders_.end() && known->skipped < 255) ++known->skipped;
  }

  // Since the sender was first heard. A gap of up to 126 numbers is one of lost frames, less those of skip(); a frame
  // that comes up to 19 numbers late is no longer lost. Not counted: what is lost before a silence of 2.5 s or where
  // numbers go back by 20 or more, which is taken for a new start. A new start within 2.5 s that goes forth counts as a
  // gap.
  [[nodiscard]] SenderLosses losses(SenderId sender) const {
    const auto known = std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.id == sender; });
    return known == senders_.end() ? SenderLosses{} : known->losses;
  }

 private:
  static constexpr int kLateMax = 20;

  struct Sender {
    SenderId id = 0;
    TimeNs heard_ns = 0;
    std::uint8_t sequence = 0;
    bool terminated = false;
    std::uint8_t skipped = 0;   // calls of skip() since `sequence`
    std::uint32_t missing = 0;  // bit k: the number k before `sequence` counts as lost
    SenderLosses losses;

    void advance(int step) {
      if (step <= 0) {
        if (step < 0) begin_anew();
        return;
      }
      const int gap = std::max(step - 1 - skipped, 0);
      losses.lost += static_cast<std::uint64_t>(gap);
      missing = step < 32 ? missing << step : 0;
      for (int k = 1; k < std::min(step, 32) && gap > 0; ++k) missing |= 1u << k;
      skipped = 0;
    }
    void take_late(int behind) {
      const std::uint32_t bit = 1u << behind;
      if ((missing & bit) == 0) return;  // doubled
      missing &= ~bit;
      ++losses.late;
      if (losses.lost > 0) --losses.lost;
    }
    void begin_anew() {
      missing = 0;
      skipped = 0;
    }
  };

  // From -128 to 127; Art-Net leaves out 0.
  static int step_between(std::uint8_t from, std::uint8_t to, SequenceRule rule) {
    if (rule == SequenceRule::kSacn) return static_cast<std::int8_t>(static_cast<std::uint8_t>(to - from));
    const int step = (to - from + 255) % 255;
    return step > 127 ? step - 255 : step;
  }

  [[nodiscard]] std::vector<Sender>::iterator find(SenderId sender) {
    return std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.id == sender; });
  }

  void add(const Sender& sender) {
    if (senders_.size() < kSendersMax) {
      senders_.push_back(sender);
    } else {
      *std::min_element(senders_.begin(), senders_.end(),
                        [](const Sender& a, const Sender& b) { return a.heard_ns < b.heard_ns; }) = sender;
    }
  }

  std::vector<Sender> senders_;
};

}  // namespace footlight::drivers
