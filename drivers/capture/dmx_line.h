// Decodes samples of a DMX line into frames and their timing (ANSI E1.11): break, mark after break, start code, slots
// of eleven bits at 250 kbaud. No file, no clock, no I/O.
//
// Accepts what real devices send, not only what the standard allows: breaks from 44 us (uDMX sends 50), marks after
// break from 3 us (an SGM Regia sends 4 to 5, which is 3 to 5 at one sample per microsecond), any number of slots up to
// 512, breaks that differ from frame to frame. The longest low of a slot is 36 us. A low of 44 us or more is a break:
// that is halfway to the shortest break to accept (48 us), with its tenth of jitter. Pulses below 1.5 us are glitches,
// ignored and counted; a bit has 4 us. A glitch nearer than that to an edge moves the edge. Each slot is sampled from
// its own start edge, so a sender may be 4 % fast or slow.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

inline constexpr DurationNs kLineBitNs = 4 * kNsPerUs;
inline constexpr DurationNs kLineSlotNs = 11 * kLineBitNs;
inline constexpr DurationNs kLineBreakMinNs = 44 * kNsPerUs;
inline constexpr DurationNs kLineBreakMaxNs = kNsPerS;  // longer: the line is off
inline constexpr DurationNs kLineMabMinNs = 3 * kNsPerUs;
inline constexpr DurationNs kLineGlitchNs = 1'500;
// Two samples per bit; from four per bit every slot is certain.
inline constexpr std::uint64_t kLineSampleRateMinHz = 500'000;
inline constexpr std::uint64_t kLineSampleRateMaxHz = 1'000'000'000;

// Why a frame was rejected.
enum class LineFault {
  kNone,
  kBreakLong,     // above 1 s
  kMabShort,      // below 3 us
  kNoStartCode,   // a break followed by another break
  kNoStopBit,     // low at the end of a slot, but too short for a break
  kCutSlot,       // the next break starts inside a slot
  kTooManySlots,  // more than 512
  kUnfinished,    // the samples end before its start code
};
inline constexpr int kLineFaultCount = 8;
[[nodiscard]] const char* text_of(LineFault fault);

struct LineFrameTiming {
  TimeNs start_ns = 0;  // start of its break, from the first sample
  DurationNs break_ns = 0;
  DurationNs mab_ns = 0;  // mark after break; 0 if the frame ends before it
  int slot_count = 0;     // valid slots after the start code, 0 to 512
  std::uint8_t start_code = 0;
  // Mark time between the end of a slot's eleven nominal bits (44 us) and the next start bit, over all slots including
  // the start code. Never negative: a sender whose slots are shorter than 44 us has a gap of 0 (see pitch_min_ns). 0
  // with fewer than two slots.
  DurationNs gap_min_ns = 0;
  DurationNs gap_max_ns = 0;
  DurationNs gap_sum_ns = 0;
  // Shortest time between two start bits, to within one sample. Below 44 us if the sender is fast or sends one stop
  // bit. 0 with fewer than two slots.
  DurationNs pitch_min_ns = 0;
  TimeNs end_ns = 0;         // of the last valid slot
  DurationNs period_ns = 0;  // to the next break; 0: there was none
  bool unfinished = false;   // the samples end inside the frame; the part before is valid
  LineFault fault = LineFault::kNone;
};

struct LineFrame {
  LineFrameTiming timing;
  std::array<std::uint8_t, 1 + kSlotCountMax> bytes = {};  // start code, slots
  [[nodiscard]] std::span<const std::uint8_t> slots() const {
    return std::span(bytes).subspan(1, static_cast<std::size_t>(timing.slot_count));
  }
};

struct LineCounters {
  std::uint64_t sound = 0;  // frames, including an unfinished one at the end
  std::uint64_t rejected = 0;
  std::array<std::uint64_t, kLineFaultCount> faults = {};  // by LineFault
  std::uint64_t glitches = 0;
  std::uint64_t false_starts = 0;  // lows between slots that ended before the middle of a start bit
};

class DmxLineDecoder {
 public:
  // kLineSampleRateMinHz to kLineSampleRateMaxHz, checked.
  explicit DmxLineDecoder(std::uint64_t sample_rate_hz);

  // `count` samples of one level; true: mark.
  void feed(bool mark, std::uint64_t count);
  // Whole samples of `unit_size` bytes each; `bit` of each, little-endian, is the line.
  void feed_samples(std::span<const std::uint8_t> samples, std::size_t unit_size, unsigned bit, bool inverted);
  // Call after the last sample.
  void finish();

  // The next frame, valid or rejected, in the order of their breaks. False if none is complete.
  [[nodiscard]] bool take(LineFrame& frame);
  [[nodiscard]] const LineCounters& counters() const { return counters_; }
  // Time of the last sample so far, from the first.
  [[nodiscard]] TimeNs now_ns() const { return time_of(position_); }

 private:
  enum class State { kIdle, kMab, kSlots };

  [[nodiscard]] TimeNs time_of(std::uint64_t sample) const;
  void end_pulse();
  void take_run(bool mark, TimeNs begin_ns, TimeNs end_ns, bool begins_at_edge);
  void receive(bool mark, TimeNs begin_ns, TimeNs end_ns);
  void begin_frame(TimeNs begin_ns, DurationNs break_ns);
  void end_frame(std::optional<TimeNs> next_break_ns);
  void reject(LineFault fault);

  std::uint64_t rate_hz_;
  std::uint64_t position_ = 0;  // samples fed
  // The current pulse, glitch or not.
  bool any_ = false;
  bool pulse_mark_ = false;
  std::uint64_t pulse_begin_ = 0;
  // The run of one level that contains it, without glitches.
  bool run_known_ = false;
  bool run_mark_ = false;
  bool run_begins_at_edge_ = false;
  TimeNs run_begin_ns_ = 0;

  State state_ = State::kIdle;
  bool open_ = false;  // frame_ is in progress
  LineFrame frame_;
  int byte_count_ = 0;      // of frame_.bytes
  bool receiving_ = false;  // inside a slot
  TimeNs slot_begin_ns_ = 0;
  int bit_ = 0;  // of the slot, 0: start bit; the next bit to sample
  std::uint8_t value_ = 0;
  TimeNs last_mark_ns_ = 0;  // how long the line has been at mark when the samples end

  std::deque<LineFrame> done_;
  LineCounters counters_;
};

}  // namespace footlight::drivers
