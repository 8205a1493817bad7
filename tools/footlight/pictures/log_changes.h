// The changes in a log, from time 0 on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/dmx_log/dmx_log.h"
#include "sim/level_changes.h"

namespace footlight::tools {

class LogChanges final : public LevelChanges {
 public:
  // universes: those of the rig, ascending; others are skipped. Takes ownership of the reader.
  LogChanges(LogReader reader, std::vector<Universe> universes);
  Result<bool> next(LevelChange& change) override;
  // next() returns the first change after this time.
  Status seek(DurationNs time_ns) { return reader_.seek(time_ns); }
  // The levels at the last seek: universes x 512 bytes, in the order of `universes`.
  void read_levels(std::span<std::uint8_t> levels);

 private:
  LogReader reader_;
  std::vector<Universe> universes_;
};

}  // namespace footlight::tools
