// What changes the levels of a rig, in the order of time: a log that is read, or looks that came over the wire.
#pragma once

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight {

struct LevelChange {
  TimeNs at_ns = 0;   // from when on they hold; one that lies before an earlier change's counts from that one's time
  int universe = -1;  // index among the rig's
  Slots levels{};     // of the whole universe
};

class LevelChanges {
 public:
  virtual ~LevelChanges() = default;
  // False: there is none, or none yet; it may be asked again.
  virtual Result<bool> next(LevelChange& change) = 0;
};

}  // namespace footlight
