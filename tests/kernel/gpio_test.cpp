// Edges of a real kernel GPIO line: hid-cp2112 on a model of the chip, libgpiod, and a universe.
#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "drivers/mock/enttec_pro_model.h"
#include "tests/kernel/cp2112_model.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"

namespace footlight::testing {
namespace {

constexpr int kLine = 3;

TEST_CASE("a GPIO chip that the user may not open is ready after the advised command") {
  set_up_well();
  Cp2112Model chip;
  VhciSocket socket(chip);
  socket.plug();
  REQUIRE(eventually([] { return !gpio_chip().is_null(); }));
  CHECK(gpio_chip().at("readiness") == "no-permission");
  must_shell(gpio_chip().at("remedy"));
  const Json found = gpio_chip();
  CAPTURE(found.dump());
  CHECK(found.at("readiness") == "ready");
  CHECK(found.at("lines") == 8);
}

TEST_CASE("each edge at a pin of a CP2112 arrives in the universe and at a widget") {
  set_up_well();
  must_shell("cp udev/71-footlight-gpio.rules /etc/udev/rules.d/ && udevadm control --reload");
  Cp2112Model chip;
  VhciSocket chip_socket(chip, 0);
  chip_socket.plug();
  REQUIRE(eventually([] { return gpio_chip().value("readiness", "") == "ready"; }));
  const std::string name = gpio_chip().at("name");
  drivers::mock::EnttecProModel widget;
  VhciSocket widget_socket(widget, 1);
  widget_socket.plug();
  const std::string endpoint = device_at(widget_socket.port_path()).at("endpoint");
  Footlight bridge(as_user(
      {"run", "--in", fmt::format("gpio:{}/{}=1.25", name, kLine), "--out", endpoint, "--json", "--socket", "none"}));
  bridge.wait_for(R"("event":"ready")");
  for (int i = 1; i <= 20; ++i) {
    CAPTURE(i);
    const std::uint8_t level = i % 2 != 0 ? 255 : 0;
    chip_socket.with_model([&] { chip.pins = static_cast<std::uint8_t>(i % 2 << kLine); });
    REQUIRE(widget_socket.wait_for(
        [&] {
          const auto& frame = widget.line(0).frame;
          return frame.size() == 513 && frame[25] == level;
        },
        kPatience));
  }
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

}  // namespace
}  // namespace footlight::testing
