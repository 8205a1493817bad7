#include "drivers/capture/dmx_line.h"

#include <algorithm>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

// A line at mark for this long when the samples end has completed its frame; gaps of 60 us occur inside frames.
constexpr DurationNs kRestNs = kNsPerMs;

}  // namespace

const char* text_of(LineFault fault) {
  switch (fault) {
    case LineFault::kNone: return "sound";
    case LineFault::kBreakLong: return "the break is longer than 1 s";
    case LineFault::kMabShort: return "the mark after break is shorter than 3 us";
    case LineFault::kNoStartCode: return "no start code follows the break";
    case LineFault::kNoStopBit: return "a slot has no stop bit";
    case LineFault::kCutSlot: return "the next break begins inside a slot";
    case LineFault::kTooManySlots: return "more than 512 slots";
    case LineFault::kUnfinished: return "the capture ends before the start code";
  }
  return "?";
}

DmxLineDecoder::DmxLineDecoder(std::uint64_t sample_rate_hz) : rate_hz_(sample_rate_hz) {
  FL_CHECK(rate_hz_ >= kLineSampleRateMinHz && rate_hz_ <= kLineSampleRateMaxHz);
}

TimeNs DmxLineDecoder::time_of(std::uint64_t sample) const {
  // Computed in two parts to avoid overflow: the rate is below 2^30.
  constexpr std::uint64_t kPerS = kNsPerS;
  return static_cast<TimeNs>(sample / rate_hz_ * kPerS + sample % rate_hz_ * kPerS / rate_hz_);
}

void DmxLineDecoder::feed(bool mark, std::uint64_t count) {
  if (count == 0) return;
  if (!any_ || mark != pulse_mark_) {
    if (any_) end_pulse();
    any_ = true;
    pulse_mark_ = mark;
    pulse_begin_ = position_;
  }
  position_ += count;
}

void DmxLineDecoder::feed_samples(std::span<const std::uint8_t> samples, std::size_t unit_size, unsigned bit,
                                  bool inverted) {
  FL_CHECK(unit_size > 0 && bit < unit_size * 8 && samples.size() % unit_size == 0);
  const auto mask = static_cast<std::uint8_t>(1u << bit % 8);
  std::size_t at = bit / 8;
  while (at < samples.size()) {
    const std::uint8_t level = samples[at] & mask;
    const std::size_t begin = at;
    do {
      at += unit_size;
    } while (at < samples.size() && (samples[at] & mask) == level);
    feed((level != 0) != inverted, (at - begin) / unit_size);
  }
}

// Handles the end of a pulse: part of the run, a glitch in it, or the next run.
void DmxLineDecoder::end_pulse() {
  const TimeNs begin_ns = time_of(pulse_begin_);
  if (!run_known_) {
    run_known_ = true;
    run_mark_ = pulse_mark_;
    run_begin_ns_ = begin_ns;
    run_begins_at_edge_ = false;
    return;
  }
  if (pulse_mark_ == run_mark_) return;
  if (time_of(position_) - begin_ns < kLineGlitchNs) {
    ++counters_.glitches;
    return;
  }
  take_run(run_mark_, run_begin_ns_, begin_ns, run_begins_at_edge_);
  run_mark_ = pulse_mark_;
  run_begin_ns_ = begin_ns;
  run_begins_at_edge_ = true;
}

void DmxLineDecoder::take_run(bool mark, TimeNs begin_ns, TimeNs end_ns, bool begins_at_edge) {
  const DurationNs length_ns = end_ns - begin_ns;
  last_mark_ns_ = mark ? length_ns : 0;
  // A low at the start of the samples has an unknown start.
  if (!mark && length_ns >= kLineBreakMinNs && begins_at_edge) {
    begin_frame(begin_ns, length_ns);
    return;
  }
  switch (state_) {
    case State::kIdle: return;
    case State::kMab:
      frame_.timing.mab_ns = length_ns;
      if (length_ns < kLineMabMinNs) {
        reject(LineFault::kMabShort);
      } else {
        state_ = State::kSlots;
      }
      return;
    case State::kSlots: receive(mark, begin_ns, end_ns); return;
  }
}

// Samples the line in the middle of each bit within this run.
void DmxLineDecoder::receive(bool mark, TimeNs begin_ns, TimeNs end_ns) {
  if (!receiving_) {
    if (mark) return;
    receiving_ = true;
    slot_begin_ns_ = begin_ns;
    bit_ = 0;
    value_ = 0;
  }
  for (; slot_begin_ns_ + bit_ * kLineBitNs + kLineBitNs / 2 < end_ns; ++bit_) {
    if (bit_ == 0) {
      if (!mark) continue;
      ++counters_.false_starts;
      receiving_ = false;
      return;
    }
    if (bit_ <= 8) {
      value_ = static_cast<std::uint8_t>(value_ >> 1 | (mark ? 0x80 : 0));
      continue;
    }
    receiving_ = false;
    if (!mark) {
      reject(LineFault::kNoStopBit);
      return;
    }
    if (byte_count_ == 1 + kSlotCountMax) {
      reject(LineFault::kTooManySlots);
      return;
    }
    LineFrameTiming& timing = frame_.timing;
    if (byte_count_ > 0) {
      // Edges are exact to a sample and bits to 4 %, so slots without a gap measure up to 44 us plus or minus both.
      const DurationNs pitch_ns = slot_begin_ns_ - (timing.end_ns - kLineSlotNs);
      const DurationNs gap_ns = std::max<DurationNs>(pitch_ns - kLineSlotNs, 0);
      timing.pitch_min_ns = byte_count_ == 1 ? pitch_ns : std::min(timing.pitch_min_ns, pitch_ns);
      timing.gap_min_ns = byte_count_ == 1 ? gap_ns : std::min(timing.gap_min_ns, gap_ns);
      timing.gap_max_ns = byte_count_ == 1 ? gap_ns : std::max(timing.gap_max_ns, gap_ns);
      timing.gap_sum_ns += gap_ns;
      ++timing.slot_count;
    } else {
      timing.start_code = value_;
    }
    frame_.bytes[static_cast<std::size_t>(byte_count_++)] = value_;
    timing.end_ns = slot_begin_ns_ + kLineSlotNs;
    return;  // only stop bits remain in this run
  }
}

void DmxLineDecoder::begin_frame(TimeNs begin_ns, DurationNs break_ns) {
  if (open_) {
    if (state_ == State::kSlots && receiving_) reject(LineFault::kCutSlot);
    if (state_ == State::kSlots && byte_count_ == 0) reject(LineFault::kNoStartCode);
    end_frame(begin_ns);
  }
  open_ = true;
  frame_.timing = {};
  frame_.timing.start_ns = begin_ns;
  frame_.timing.break_ns = break_ns;
  frame_.timing.end_ns = begin_ns + break_ns;
  byte_count_ = 0;
  receiving_ = false;
  state_ = State::kMab;
  if (break_ns > kLineBreakMaxNs) reject(LineFault::kBreakLong);
}

void DmxLineDecoder::end_frame(std::optional<TimeNs> next_break_ns) {
  LineFrameTiming& timing = frame_.timing;
  if (next_break_ns) timing.period_ns = *next_break_ns - timing.start_ns;
  if (timing.fault == LineFault::kNone) {
    ++counters_.sound;
  } else {
    ++counters_.rejected;
    ++counters_.faults[static_cast<std::size_t>(timing.fault)];
  }
  done_.push_back(frame_);
  open_ = false;
  state_ = State::kIdle;
}

// The frame stays open, to measure its period.
void DmxLineDecoder::reject(LineFault fault) {
  if (frame_.timing.fault == LineFault::kNone) frame_.timing.fault = fault;
  receiving_ = false;
  state_ = State::kIdle;
}

void DmxLineDecoder::finish() {
  if (any_) {
    end_pulse();
    take_run(run_mark_, run_begin_ns_, time_of(position_), false);
    any_ = run_known_ = false;
  }
  if (!open_) return;
  const bool full = byte_count_ == 1 + kSlotCountMax;
  const bool rested = byte_count_ > 0 && last_mark_ns_ >= kRestNs;
  if (state_ == State::kMab || (state_ == State::kSlots && byte_count_ == 0)) {
    reject(LineFault::kUnfinished);
  } else if (state_ == State::kSlots) {
    frame_.timing.unfinished = receiving_ || !(full || rested);
  }
  end_frame(std::nullopt);
}

bool DmxLineDecoder::take(LineFrame& frame) {
  if (done_.empty()) return false;
  frame = done_.front();
  done_.pop_front();
  return true;
}

}  // namespace footlight::drivers
