// A driver on an emulated kernel: the real libusb, hidraw or termios on one side, a model of its device on the other. A
// program that uses it must run under libumockdev-preload, see run_under_umockdev().
#pragma once

#include <memory>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "drivers/ports_factory.h"
#include "sim/system_clock.h"
#include "tests/support/umockdev_bed.h"
#include "tests/support/usb_port_test.h"

namespace footlight::testing {

// BusSocket: UsbSocket, HidSocket or TtySocket. DriverClock: SystemClock, or a SharedFakeClock in a test without
// timeouts and repeats: on a clock that stands still none occurs.
template <class BusSocket, class Model, class DriverClock = SystemClock>
struct EmulatedBench {
  // The first plugged-in device of `scheme`; request.target selects another.
  explicit EmulatedBench(std::string scheme) : EmulatedBench(std::move(scheme), std::make_unique<Model>()) {}
  // socket_arguments: of BusSocket, after its model.
  template <class... SocketArguments>
  EmulatedBench(std::string scheme, std::unique_ptr<Model> of, SocketArguments&&... socket_arguments)
      : owned_model(std::move(of)),
        socket(testbed, model, std::forward<SocketArguments>(socket_arguments)...),
        request{.scheme = std::move(scheme), .target = "", .universes = {1}} {}

  DriverClock clock;
  Testbed testbed;
  const std::unique_ptr<Model> owned_model;
  Model& model = *owned_model;
  BusSocket socket;
  drivers::PortRequest request;

  std::unique_ptr<Sink> open_sink() {
    auto sink = drivers::open_sink(request, clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  std::unique_ptr<Source> open_source() {
    auto source = drivers::open_source(request, clock);
    REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
    return std::move(*source);
  }
  void send(Sink& sink, const Snapshot& slots) {
    const FrameView frame{.universe = 1, .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  bool shows(const Snapshot& slots) {
    return socket.wait_for([&] { return model.line(0).frame == line_frame_of(slots); });
  }
  // The device receives this on its line.
  void receive(const Snapshot& slots) {
    socket.with_model([&] { model.receive_line_frame(0, line_frame_of(slots)); });
  }
};

}  // namespace footlight::testing
