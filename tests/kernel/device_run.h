// Runs the program with one device, as the user `lighting`, fed by frames from a test.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "drivers/mock/usb_model.h"
#include "sim/core/ports.h"
#include "tests/kernel/guest.h"
#include "tests/support/usb_port_test.h"

namespace footlight::testing {

// `footlight run` from sACN universe 1 on loopback to an endpoint; to several with "--out" among the options.
class DeviceRun {
 public:
  explicit DeviceRun(const std::string& endpoint, const std::vector<std::string>& options = {});

  void send(const Snapshot& snapshot);
  // Sends the snapshot every 100 ms until it appears on line 0 of the model. Returns true, or fails the test with the
  // program's output. socket: has wait_for().
  template <class Socket>
  bool shows(Socket& socket, const drivers::mock::UsbModel& model, const Snapshot& snapshot) {
    const auto give_up = std::chrono::steady_clock::now() + kPatience;
    const auto shown = [&] { return model.line(0).frame == line_frame_of(snapshot); };
    do {
      send(snapshot);
      if (socket.wait_for(shown, std::chrono::milliseconds(100))) return true;
    } while (std::chrono::steady_clock::now() < give_up);
    fail();
    return false;
  }
  Footlight& program() { return program_; }
  // Fails the test with the program's output.
  void fail();

 private:
  Footlight program_;
  std::unique_ptr<Sink> sender_;
};

}  // namespace footlight::testing
