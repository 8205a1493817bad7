// Selects the plugged-in device for an endpoint, at first and after a replug.
//
// The first device that is opened pins the chooser: to its serial number, if no other device of the driver shares it,
// else to its USB socket. After that no other device is accepted.
//
// Threads: safe to call from any.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "drivers/registry.h"
#include "sim/core/result.h"

namespace footlight::drivers {

class Chooser {
 public:
  // driver_id: of the devices to accept, as in the driver table. target: a serial number, "port-1-2.3", or empty if
  // only one such device is plugged in.
  Chooser(std::string driver_id, std::string target, FindOptions find = {});

  // Errors: kNotFound (lists the other devices), kBadInput (several match; lists them), kPermission (names the command
  // that fixes it), kUnsupported. Returns a device only if it can be opened or the user named it.
  [[nodiscard]] Result<FoundDevice> choose() const;
  // As choose(), also for a device that cannot be opened.
  [[nodiscard]] Result<FoundDevice> find() const;
  // Call when the device was opened.
  void pin(const FoundDevice& device);
  // See Opener::identity().
  [[nodiscard]] std::string identity() const;
  [[nodiscard]] const std::string& driver_id() const { return driver_id_; }
  [[nodiscard]] const FindOptions& options() const { return find_; }

 private:
  const std::string driver_id_;
  const std::string target_;
  const FindOptions find_;
  struct Pin {
    std::string serial;
    std::string port_path;
  };
  mutable std::mutex mutex_;
  std::optional<Pin> pinned_;  // guarded by mutex_
};

}  // namespace footlight::drivers
