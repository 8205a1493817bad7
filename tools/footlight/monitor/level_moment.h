// The levels of universes at one moment, and how those of two moments differ: for `footlight log compare` and the
// window.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight::tools {

struct LevelMoment {
  std::vector<Universe> universes;   // ascending
  std::vector<std::uint8_t> levels;  // universes x 512
  bool operator==(const LevelMoment&) const = default;
};

// The same without owning it.
struct LevelView {
  LevelView(std::span<const Universe> those, std::span<const std::uint8_t> with) : universes(those), levels(with) {}
  LevelView(const LevelMoment& moment) : universes(moment.universes), levels(moment.levels) {}
  // The 512 levels of a universe; empty: it is not in the moment.
  [[nodiscard]] std::span<const std::uint8_t> of(Universe universe) const;

  std::span<const Universe> universes;
  std::span<const std::uint8_t> levels;  // universes x 512
};

struct SlotDifference {
  Universe universe = 0;
  Address address = 0;
  std::uint8_t a = 0;
  std::uint8_t b = 0;
  bool operator==(const SlotDifference&) const = default;
};

struct MomentDifference {
  struct Count {
    Universe universe = 0;
    int slots = 0;  // that differ
    bool in_a = false;
    bool in_b = false;
  };
  std::vector<Count> universes;       // of either moment, ascending
  std::vector<SlotDifference> slots;  // by universe, then by address
  // Whether no slot differs. A universe that is in one moment only and dark there does not count.
  [[nodiscard]] bool equal() const;
  [[nodiscard]] int slots_of(Universe universe) const;
};

// The universes of a moment that are among these, ascending.
[[nodiscard]] LevelMoment only_of(const LevelView& moment, std::span<const Universe> universes);

// A universe that is in one moment only has level 0 in the other. tolerance: levels may differ by this much.
[[nodiscard]] MomentDifference compare_moments(const LevelView& a, const LevelView& b, int tolerance = 0);

// All universes that have had a frame by this time of a log. kBadInput: the log ends before it.
[[nodiscard]] Result<LevelMoment> moment_of(LogReader& reader, DurationNs at_ns);

}  // namespace footlight::tools
