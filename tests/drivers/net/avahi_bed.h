// Avahi's daemon with a message bus of its own, in the network namespace of the test.
#pragma once

#include <sys/types.h>

namespace footlight::testing {

class AvahiBed {
 public:
  // Starts both. Only after enter_private_network(), with an interface added. Sets DBUS_SYSTEM_BUS_ADDRESS.
  AvahiBed();
  ~AvahiBed();
  AvahiBed(const AvahiBed&) = delete;
  AvahiBed& operator=(const AvahiBed&) = delete;
  [[nodiscard]] static bool is_installed();  // avahi-daemon and dbus-daemon
  // False: one does not start (reported on stderr).
  [[nodiscard]] bool runs() const { return runs_; }
  void stop_daemon();
  [[nodiscard]] bool start_daemon();

 private:
  pid_t bus_ = -1;
  pid_t daemon_ = -1;
  bool runs_ = false;
};

}  // namespace footlight::testing
