// Talks to the service manager that started the program, if one did (sd_notify(3)). Without libsystemd or outside a
// service nothing happens. Threads: any.
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
  // How often alive() has to be called; kTimeNever: nobody watches.
  [[nodiscard]] DurationNs alive_period_ns() const;
};

}  // namespace footlight::tools
