// SIGINT and SIGTERM as a request, so that sinks can say their last words. A second signal ends the program at once.
// SIGPIPE is ignored.
#pragma once

#include "sim/pump.h"

namespace footlight::tools {

// From construction on, signals are remembered; from stop(pump) on, they stop that pump. One at a time in a program.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  // nullptr: no pump any more. A signal that came before stops it at once.
  void stops(Pump* pump);
  [[nodiscard]] bool came() const;
};

}  // namespace footlight::tools
