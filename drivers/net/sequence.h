// Detects late and duplicate datagrams per sender of one universe (E1.31-2018 section 6.7.2), and counts lost ones.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// A sender without a datagram for this long is removed, and any sequence number is new again (E1.31 section 6.7.1).
inline constexpr DurationNs kSenderTimeoutNs = 2'500 * kNsPerMs;

// How a protocol numbers the frames of a universe.
enum class SequenceRule : std::uint8_t {
  kSacn,    // 0 to 255; a repeated number is late, since a datagram arrives once per interface that joined its group
  kArtnet,  // 1 to 255 (0: unnumbered, not checked); frames whose number never changes are accepted
};

class SequenceFilter {
 public:
  // The maximum of senders stored. A further one replaces the one silent for longest, so that a flood of forged senders
  // uses no memory.
  static constexpr std::size_t kSendersMax = 16;

  enum class Verdict { kNew, kLate, kEndedAlready };

  // kEndedAlready: the second and third of the three packets that end a stream.
  Verdict judge(SenderId sender, std::uint8_t sequence, bool terminated, SequenceRule rule, TimeNs now_ns) {
    const auto known = find(sender);
    if (known == senders_.end()) {
      add({.id = sender, .received_ns = now_ns, .sequence = sequence, .terminated = terminated});
      return Verdict::kNew;
    }
    if (now_ns - known->received_ns < kSenderTimeoutNs) {
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
    known->received_ns = now_ns;
    known->sequence = sequence;
    known->terminated = terminated;
    return Verdict::kNew;
  }

  // A datagram of this sender and universe that is not checked here, but may have used a sequence number: sACN numbers
  // all start codes of a universe together (E1.31-2018 section 6.7.2), and some senders do not.
  void skip(SenderId sender) {
    const auto known = find(sender);
    if (known != senders_.end() && known->skipped < 255) ++known->skipped;
  }

  // Since the sender's first datagram. A gap of up to 126 numbers counts as lost frames, less those of skip(). A frame
  // up to 19 numbers late is no longer counted as lost. Not counted: losses before a silence of 2.5 s, or before the
  // numbers go back by 20 or more, which is taken as a restart. A restart within 2.5 s whose numbers go forward counts
  // as a gap.
  [[nodiscard]] SenderLosses losses(SenderId sender) const {
    const auto known = std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.id == sender; });
    return known == senders_.end() ? SenderLosses{} : known->losses;
  }

 private:
  static constexpr int kLateMax = 20;

  struct Sender {
    SenderId id = 0;
    TimeNs received_ns = 0;
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
      if ((missing & bit) == 0) return;  // duplicate
      missing &= ~bit;
      ++losses.late;
      if (losses.lost > 0) --losses.lost;
    }
    void begin_anew() {
      missing = 0;
      skipped = 0;
    }
  };

  // From -128 to 127; Art-Net skips 0.
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
                        [](const Sender& a, const Sender& b) { return a.received_ns < b.received_ns; }) = sender;
    }
  }

  std::vector<Sender> senders_;
};

}  // namespace footlight::drivers
