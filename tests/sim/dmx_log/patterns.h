// Synthetic traffic for measuring log sizes: 9 universes at 44 Hz, every slot of every universe in use.
//
// The stamps vary like those of a real receiver, because that affects the size: a jitter of about 100 us for each
// round, and of some microseconds between the universes of a round, so that the times do not compress to nothing.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/sim/dmx_log/support.h"

namespace footlight::testing {

enum class Pattern {
  kStill,      // one snapshot, repeated
  kCues,       // a cue every 8 s: every slot fades to its own new level within 3 s, then stays
  kChase,      // every slot runs a sine, shifted from slot to slot, with a different speed per universe
  kMovers,     // 16-slot moving heads: 16-bit pan and tilt on sines, dimmer chases, colour and gobo steps, pauses
  kAllFading,  // every slot fades continuously from one random level to the next, each in its own time
  kNoise,      // every slot random in every frame
};

inline constexpr std::array<std::pair<Pattern, const char*>, 6> kPatterns = {{{Pattern::kStill, "still levels"},
                                                                              {Pattern::kCues, "cues"},
                                                                              {Pattern::kChase, "chase on all slots"},
                                                                              {Pattern::kMovers, "moving heads"},
                                                                              {Pattern::kAllFading, "all slots fading"},
                                                                              {Pattern::kNoise, "noise"}}};

// A number from 0 to 1, determined by these keys.
inline double unit(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  return static_cast<double>(Random(a * 0x1000003u ^ (b * 0x10001u + c)).next() >> 11) * 0x1p-53;
}

inline std::uint8_t level_of(double unit_value) {
  return static_cast<std::uint8_t>(std::lround(std::min(std::max(unit_value, 0.0), 1.0) * 255.0));
}

inline double wave(double cycles) { return 0.5 + 0.5 * std::sin(2.0 * 3.14159265358979323846 * cycles); }

inline std::uint8_t pattern_level(Pattern pattern, int universe, int slot, double t_s, Random& random) {
  const auto u = static_cast<std::uint64_t>(universe);
  const auto s = static_cast<std::uint64_t>(slot);
  switch (pattern) {
    case Pattern::kStill: return level_of(unit(u, s, 0));
    case Pattern::kCues: {
      const auto cue = static_cast<std::uint64_t>(t_s / 8.0);
      const double part = std::min((t_s - 8.0 * static_cast<double>(cue)) / 3.0, 1.0);
      return level_of(unit(u, s, cue) + part * (unit(u, s, cue + 1) - unit(u, s, cue)));
    }
    case Pattern::kChase: return level_of(wave(t_s * (0.3 + 0.07 * universe) - slot / 32.0));
    case Pattern::kMovers: {
      const int fixture = slot / 16;
      const double speed_hz = 0.05 + 0.02 * universe;
      const double pan = wave(speed_hz * t_s + fixture / 32.0);
      const double tilt = 0.3 + 0.3 * wave(1.7 * speed_hz * t_s + fixture / 16.0);
      const auto pan16 = static_cast<unsigned>(std::lround(pan * 65535.0));
      const auto tilt16 = static_cast<unsigned>(std::lround(tilt * 65535.0));
      const auto step = static_cast<std::uint64_t>(t_s / 2.0);
      switch (slot % 16) {
        case 0: return static_cast<std::uint8_t>(pan16 >> 8);
        case 1: return static_cast<std::uint8_t>(pan16 & 0xFF);
        case 2: return static_cast<std::uint8_t>(tilt16 >> 8);
        case 3: return static_cast<std::uint8_t>(tilt16 & 0xFF);
        case 5: return level_of(wave(t_s - fixture / 8.0));
        case 7: return level_of(unit(u, static_cast<std::uint64_t>(fixture), step));
        case 8: return level_of(unit(u + 50, static_cast<std::uint64_t>(fixture), step / 2));
        case 9: return level_of(wave(0.2 * t_s + fixture / 32.0));
        case 10: return level_of(wave(0.2 * t_s + 0.33 + fixture / 32.0));
        case 11: return level_of(wave(0.2 * t_s + 0.66 + fixture / 32.0));
        default: return level_of(unit(u, s, 0));
      }
    }
    case Pattern::kAllFading: {
      const double period_s = 1.0 + 5.0 * unit(u, s, 1);
      const auto leg = static_cast<std::uint64_t>(t_s / period_s);
      const double part = t_s / period_s - static_cast<double>(leg);
      const double from = unit(u, s, 10 + leg);
      return level_of(from + part * (unit(u, s, 11 + leg) - from));
    }
    case Pattern::kNoise: return random.byte();
  }
  return 0;
}

// Calls take(const FrameView&) for each frame of `duration_s` seconds, in order of time.
template <class Take>
void play_pattern(Pattern pattern, double duration_s, Take take) {
  constexpr double kRateHz = 44.0;
  Random random(42);
  Slots slots{};
  const auto rounds = static_cast<int>(duration_s * kRateHz);
  DurationNs before_ns = 0;
  for (int round = 0; round < rounds; ++round) {
    const double t_s = round / kRateHz;
    DurationNs time_ns = static_cast<DurationNs>(t_s * 1e9) + random.between(0, 200'000);
    for (int universe = 1; universe <= 9; ++universe) {
      time_ns = std::max(time_ns + random.between(12'000, 30'000), before_ns);
      before_ns = time_ns;
      for (int slot = 0; slot < kSlotCountMax; ++slot) {
        slots[static_cast<std::size_t>(slot)] = pattern_level(pattern, universe, slot, t_s, random);
      }
      FrameView view;
      view.universe = universe;
      view.stamp_ns = time_ns;
      view.sender = 0x1234567890ABCDEF;
      view.sequence = static_cast<std::uint32_t>(round & 0xFF);
      view.slots = slots;
      take(view);
    }
  }
}

}  // namespace footlight::testing
