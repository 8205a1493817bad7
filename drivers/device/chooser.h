// Which of the plugged-in devices an endpoint means, now and after a replug.
//
// The first device that was opened pins the chooser: to its serial number where it has one that no other device of the
// driver shares, else to the socket that it sits in. From then on no other device is taken.
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
  // driver_id: of the devices to take, as in the driver table. target: a serial number, "port-1-2.3", or empty where
  // only one such device is plugged in.
  Chooser(std::string driver_id, std::string target, FindOptions find = {});

  // Errors: kNotFound (says which others are there), kBadInput (several fit; names them), kPermission (says what mends
  // it), kUnsupported. A device is given only where it can be opened, or where the user named it.
  [[nodiscard]] Result<FoundDevice> choose() const;
  // As choose(), whether it can be opened or not.
  [[nodiscard]] Result<FoundDevice> find() const;
  // The device was opened.
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
