// Notifies the service manager, if the program runs as a service (sd_notify(3)). Without libsystemd or outside a
// service the functions do nothing. Threads: any.
#pragma once

#include <string>

#include "sim/core/clock.h"

namespace footlight::tools {

class Service {
 public:
  void ready();
  void stopping();
  void reloading();  // until ready()
  void status(const std::string& line);
  void alive();
  // The period in which alive() must be called; kTimeNever: no watchdog.
  [[nodiscard]] DurationNs alive_period_ns() const;
};

}  // namespace footlight::tools
