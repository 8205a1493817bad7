// Changes of a rig's levels in order of time: read from a log, or received from the pump.
#pragma once

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight {

struct LevelChange {
  TimeNs at_ns = 0;   // when they take effect; a time before that of an earlier change counts as that change's time
  int universe = -1;  // index among the rig's
  Slots levels{};     // of the whole universe
};

class LevelChanges {
 public:
  virtual ~LevelChanges() = default;
  // False: no change is available. A later call may return one.
  virtual Result<bool> next(LevelChange& change) = 0;
};

}  // namespace footlight
