#include "tools/footlight/bridge/service.h"

#ifdef FOOTLIGHT_HAVE_SYSTEMD
#include <cstdint>
#include <ctime>

#include <systemd/sd-daemon.h>
#endif

namespace footlight::tools {

#ifdef FOOTLIGHT_HAVE_SYSTEMD

void Service::ready() { sd_notify(0, "READY=1"); }
void Service::stopping() { sd_notify(0, "STOPPING=1"); }

// The time is that of CLOCK_MONOTONIC (sd_notify(3)).
void Service::reloading() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld", now.tv_sec * 1'000'000LL + now.tv_nsec / 1'000);
}
void Service::status(const std::string& line) { sd_notify(0, ("STATUS=" + line).c_str()); }
void Service::alive() { sd_notify(0, "WATCHDOG=1"); }

DurationNs Service::alive_period_ns() const {
  std::uint64_t timeout_us = 0;
  if (sd_watchdog_enabled(0, &timeout_us) <= 0) return kTimeNever;
  return static_cast<DurationNs>(timeout_us / 2) * kNsPerUs;  // half, as sd_watchdog_enabled(3) advises
}

#else

void Service::ready() {}
void Service::stopping() {}
void Service::reloading() {}
void Service::status(const std::string&) {}
void Service::alive() {}
DurationNs Service::alive_period_ns() const { return kTimeNever; }

#endif

}  // namespace footlight::tools
