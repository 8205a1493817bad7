// RDM through an ENTTEC widget's driver and device thread, with the model of the widget and of the line behind it.
#include <doctest/doctest.h>

#include <memory>

#include "drivers/device/device_rdm.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/ports_factory.h"
#include "drivers/rdm/rdm_controller.h"
#include "drivers/rdm/rdm_parameters.h"
#include "drivers/widgets/enttec_pro.h"
#include "sim/system_clock.h"

namespace footlight::drivers {
namespace {

using mock::EnttecProModel;
using mock::MockUsb;

constexpr RdmUid kOwn{0x7FF0, 0x1000'0000};

struct Bench {
  Bench() {
    auto model = std::make_unique<EnttecProModel>();
    model->rdm_line = mock::example_rdm_line();
    usb = std::make_shared<MockUsb>(std::move(model), "mock:enttec-pro");
  }
  std::unique_ptr<DeviceSink> open_sink() {
    DevicePlan plan;
    plan.widget = std::make_unique<EnttecPro>(config);
    plan.opener = mock::make_mock_opener(usb, clock);
    DevicePortConfig port;
    port.name = "mock:enttec-pro";
    port.lines = {{.line = 0, .universe = 1}};
    auto sink = DeviceSink::open(std::move(plan), port, clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  SystemClock clock;
  EnttecProConfig config;
  std::shared_ptr<MockUsb> usb;
};

std::vector<std::uint64_t> uids_of(RdmLine& line) {
  const auto found = line.discover();
  REQUIRE_MESSAGE(found.has_value(), (found ? std::string() : found.error().message));
  std::vector<std::uint64_t> uids;
  for (const RdmFound& one : *found) uids.push_back(one.uid.number());
  return uids;
}

const std::vector<std::uint64_t> kExample = {0x7FF0'0000'0001, 0x7FF0'0000'0002, 0x7FF0'0001'0000};

}  // namespace

TEST_CASE("devices behind a modelled widget are found, read and set through an endpoint") {
  SystemClock clock;
  PortRequest request;
  request.scheme = "mock";
  request.target = "enttec-pro/rdm";
  request.universes = {1};
  auto line = open_rdm_line(request, kOwn, clock);
  REQUIRE_MESSAGE(line, (line ? "" : line.error().message));
  CHECK(uids_of(**line) == kExample);
  RdmController controller(**line, clock, kOwn);
  const RdmUid spot = RdmUid::of_number(kExample[1]);
  CHECK(rdm_text(controller.get(spot, kRdmDeviceLabel, {}, "DEVICE_LABEL").value()) == "Spot stage left");
  REQUIRE(controller.set(spot, kRdmDmxStartAddress, Octets{1, 0}, "DMX_START_ADDRESS").has_value());
  CHECK(controller.get(spot, kRdmDmxStartAddress, {}, "DMX_START_ADDRESS").value() == Octets{1, 0});
  // The dimmer requests time before every answer.
  const RdmUid dimmer = RdmUid::of_number(kExample[2]);
  CHECK(rdm_text(controller.get(dimmer, kRdmDeviceLabel, {}, "DEVICE_LABEL").value()) == "House");
}

TEST_CASE("the last frame is back on the line after an RDM request") {
  Bench bench;
  auto sink = bench.open_sink();
  const Octets slots(512, 77);
  FrameView frame;
  frame.universe = 1;
  frame.slots = slots;
  REQUIRE(sink->send(bench.clock.now_ns(), {&frame, 1}).has_value());
  REQUIRE(
      bench.usb->wait_for<EnttecProModel>([](const EnttecProModel& model) { return model.receive_modes[0] == -1; }));
  DeviceRdmLine line(sink->link().handle(), "mock:enttec-pro", 0, kOwn);
  CHECK(uids_of(line) == kExample);
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    CHECK(model.receive_modes[0] == -1);  // it sends
    CHECK(model.newest_label == 6);
    REQUIRE(model.line(0).frame.size() == 513);
    CHECK(model.line(0).frame[1] == 77);
  });
}

TEST_CASE("a widget that does not report a missing response is waited for, and all devices are found") {
  Bench bench;
  bench.config.rdm_timeout_ns = 3 * kNsPerMs;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.reports_rdm_timeout = false; });
  DeviceRdmLine line(bench.open_sink(), kOwn);
  CHECK(uids_of(line) == kExample);
}

TEST_CASE("the error for a widget with DMX firmware names the firmware and the fix") {
  Bench bench;
  bench.config.rdm_timeout_ns = 3 * kNsPerMs;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.rdm_line.reset(); });
  DeviceRdmLine line(bench.open_sink(), kOwn);
  RdmController controller(line, bench.clock, kOwn);
  const auto label = controller.get(RdmUid::of_number(kExample[0]), kRdmDeviceLabel, {}, "DEVICE_LABEL");
  REQUIRE_FALSE(label.has_value());
  CHECK(label.error().code == ErrorCode::kUnsupported);
  CHECK(label.error().message.find("firmware 1.68 does not support RDM") != std::string::npos);
}

TEST_CASE("a request while the widget is unplugged fails, and one after the replug is answered") {
  Bench bench;
  auto sink = bench.open_sink();
  DeviceRdmLine line(sink->link().handle(), "mock:enttec-pro", 0, kOwn);
  RdmController controller(line, bench.clock, kOwn);
  bench.usb->unplug();
  REQUIRE(bench.usb->wait_for_claim(false));
  const RdmUid spot = RdmUid::of_number(kExample[0]);
  const auto gone = controller.get(spot, kRdmDeviceLabel, {}, "DEVICE_LABEL");
  REQUIRE_FALSE(gone.has_value());
  CHECK(gone.error().message.find("mock:enttec-pro") != std::string::npos);
  bench.usb->plug();
  REQUIRE(bench.usb->wait_for_claim(true));
  CHECK(rdm_text(controller.get(spot, kRdmDeviceLabel, {}, "DEVICE_LABEL").value()) == "Spot");
}

TEST_CASE("the error for an interface without RDM states that") {
  class Plain final : public Widget {
   public:
    int line_count() const override { return 1; }
    Status can(int, LineUse) const override { return {}; }
    Result<WidgetTraits> begin(WidgetContext&) override { return WidgetTraits{}; }
    Status send(WidgetContext&, int, std::span<const std::uint8_t, kSlotCountMax>) override { return {}; }
    Status listen(WidgetContext& context, TimeNs deadline_ns) override {
      std::array<std::uint8_t, 64> unused;
      FL_TRY(context.transport().read(unused, deadline_ns));
      return {};
    }
  };
  Bench bench;
  DevicePlan plan;
  plan.widget = std::make_unique<Plain>();
  plan.opener = mock::make_mock_opener(bench.usb, bench.clock);
  DevicePortConfig port;
  port.name = "plain:1";
  port.lines = {{.line = 0, .universe = 1}};
  auto sink = DeviceSink::open(std::move(plan), port, bench.clock);
  REQUIRE(sink.has_value());
  DeviceRdmLine line(std::move(*sink), kOwn);
  const auto found = line.discover();
  REQUIRE_FALSE(found.has_value());
  CHECK(found.error().code == ErrorCode::kUnsupported);
  CHECK(found.error().message.find("plain:1") != std::string::npos);
}

}  // namespace footlight::drivers
