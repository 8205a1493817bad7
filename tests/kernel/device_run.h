// The program driving one device, as the user `lighting`, from looks that a test sends.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/core/ports.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"
#include "tests/support/usb_port_test.h"

namespace footlight::testing {

// `footlight run` from sACN universe 1 on loopback to an endpoint.
class DeviceRun {
 public:
  explicit DeviceRun(const std::string& endpoint, const std::vector<std::string>& options = {});

  void send(const Look& look);
  // Sends the look again every 100 ms until it is what leaves on line 0 of the model.
  bool shows(VhciSocket& socket, const drivers::mock::UsbModel& model, const Look& look);
  Footlight& program() { return program_; }

 private:
  Footlight program_;
  std::unique_ptr<Sink> sender_;
};

}  // namespace footlight::testing
