// The driver's threads with the model in this process. Time stands still unless a test moves it; waits end by
// notification.
#include "drivers/widgets/enttec_pro.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <numeric>

#include "drivers/device/device.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/ports_factory.h"
#include "sim/system_clock.h"
#include "tests/support/usb_port_test.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::EnttecProModel;
using mock::MockUsb;
using testing::FrameKeeper;
using testing::line_frame_of;
using testing::poll_until;
using testing::some_snapshot;
using testing::wait_for_state;

constexpr Universe kUniverse = 3;

// NaN if the widget has no figure of that name, or none was requested yet.
template <class Port>
double figure(const Port& port, std::string_view name) {
  for (const WidgetFigure& one : port.link().figures())
    if (one.name == name) return one.value;
  return std::nan("");
}

struct Bench {
  testing::SharedFakeClock clock;
  std::shared_ptr<MockUsb> usb = std::make_shared<MockUsb>(std::make_unique<EnttecProModel>(), "mock:enttec-pro");
  DevicePortConfig port{.name = "mock:enttec-pro", .lines = {{.line = 0, .universe = kUniverse}}};
  EnttecProConfig config;
  DurationNs retry_ns = 250 * kNsPerMs;

  DevicePlan plan(Clock& by) const {
    return {
        .widget = std::make_unique<EnttecPro>(config), .opener = mock::make_mock_opener(usb, by), .retry_ns = retry_ns};
  }
  std::unique_ptr<DeviceSink> open_sink() {
    auto sink = DeviceSink::open(plan(clock), port, clock);
    REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
    return std::move(*sink);
  }
  std::unique_ptr<DeviceSource> open_source() {
    auto source = DeviceSource::open(plan(clock), port, clock);
    REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
    return std::move(*source);
  }
  void send(Sink& sink, const Bytes& slots, Universe universe = kUniverse) {
    const FrameView frame{.universe = universe, .stamp_ns = clock.now_ns(), .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  bool widget_shows(const Bytes& slots) {
    return usb->wait_for<EnttecProModel>(
        [&](const EnttecProModel& model) { return model.line(0).frame == line_frame_of(slots); });
  }
  void advance_ns(DurationNs by_ns) {
    clock.advance_ns(by_ns);
    usb->clock_moved();
  }
  bool has_trouble(Sink& sink, std::string_view words) {
    return poll_until(
        sink, [&] { (void)sink.poll(clock.now_ns()); },
        [&] { return sink.trouble().find(words) != std::string::npos; });
  }
  // Polls until that many frames have been delivered in all.
  bool frames_come(DeviceSource& source, FrameKeeper& keeper, std::size_t count) {
    return poll_until(
        source, [&] { (void)source.poll(clock.now_ns(), keeper); }, [&] { return keeper.kept.size() >= count; });
  }
};

TEST_SUITE_BEGIN("enttec_pro");

TEST_CASE("a sink has the widget's serial numbers, parameters and rate after opening") {
  Bench bench;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.rate_hz = 30; });
  const auto sink = bench.open_sink();
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->link().identity() == "serial number 2172589, firmware 1.68");
  CHECK(poll_until(
      *sink, [] {}, [&] { return figure(*sink, "break_us") == 96.0; }));
  CHECK(sink->rate_hz_max() == 30.0);
  CHECK(sink->name() == "mock:enttec-pro");
  REQUIRE(sink->universes().size() == 1);
  CHECK(sink->universes()[0] == kUniverse);
}

TEST_CASE("a frame reaches the widget with start code 0 and 512 slots") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  CHECK(bench.widget_shows(some_snapshot(7)));
}

TEST_CASE("a short frame does not change the slots past its end") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  bench.send(*sink, Bytes{255, 255});
  Bytes expected = some_snapshot(7);
  expected[0] = expected[1] = 255;
  CHECK(bench.widget_shows(expected));
}

TEST_CASE("frames of other universes and terminated ones are not sent") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1), kUniverse + 1);
  const FrameView ended{.universe = kUniverse, .terminated = true, .slots = {}};
  REQUIRE(sink->send(0, {&ended, 1}));
  bench.send(*sink, some_snapshot(2));
  CHECK(bench.widget_shows(some_snapshot(2)));
  CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame_count; }) == 1);
}

TEST_CASE("an unchanged frame is sent again after a second, and not before") {
  Bench bench;
  std::vector<TimeNs> stamps_ns;
  bench.usb->with_model<EnttecProModel>([&](EnttecProModel& model) {
    model.on_frame = [&](int, const Bytes&) { stamps_ns.push_back(bench.clock.now_ns()); };
  });
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  REQUIRE(bench.widget_shows(some_snapshot(7)));
  for (std::uint64_t frames = 2; frames <= 4; ++frames) {
    for (int step = 0; step < 10; ++step) bench.advance_ns(100 * kNsPerMs);
    REQUIRE(bench.usb->wait_for<EnttecProModel>(
        [&](const EnttecProModel& model) { return model.line(0).frame_count == frames; }));
  }
  bench.usb->with_model<EnttecProModel>([&](EnttecProModel&) {
    for (std::size_t i = 1; i < stamps_ns.size(); ++i) CHECK(stamps_ns[i] - stamps_ns[i - 1] >= kNsPerS);
  });
  CHECK(poll_until(
      *sink, [] {}, [&] { return sink->link().stats().keep_alives == 3; }));
}

TEST_CASE("a resting output sends nothing more, and sends equal levels again at the next frame") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  REQUIRE(bench.widget_shows(some_snapshot(7)));
  sink->rest(bench.clock.now_ns());
  for (int second = 0; second < 3; ++second) {
    bench.advance_ns(kNsPerS + kNsPerMs);
    std::promise<void> turned;  // the device's thread has run once more
    sink->link().run_on_device([&](Widget&, WidgetContext*) { turned.set_value(); });
    turned.get_future().wait();
  }
  const auto frames = [](const EnttecProModel& model) { return model.line(0).frame_count; };
  CHECK(bench.usb->with_model<EnttecProModel>(frames) == 1);
  bench.send(*sink, some_snapshot(7));
  CHECK(bench.usb->wait_for<EnttecProModel>([&](const EnttecProModel& model) { return frames(model) == 2; }));
}

TEST_CASE("while the widget accepts nothing the newest frame replaces older ones, and those are counted") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.usb->stall(true);
  for (std::uint8_t i = 1; i <= 50; ++i) bench.send(*sink, some_snapshot(i));
  bench.usb->stall(false);
  CHECK(bench.widget_shows(some_snapshot(50)));
  sink->close(bench.clock.now_ns());
  const PortCounters counters = sink->counters();
  CHECK(counters.frames + counters.dropped == 50);
  CHECK(counters.dropped >= 48);  // one may have been in transfer, and one in the mailbox
  CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame_count; }) ==
        counters.frames);
}

TEST_CASE("an unplugged widget is reported gone, and shows the last frame again when it is back") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  REQUIRE(bench.widget_shows(some_snapshot(7)));
  bench.usb->unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  CHECK(sink->trouble().find("mock:enttec-pro") != std::string::npos);
  CHECK(sink->counters().errors == 1);

  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.power_on(); });
  const TimeNs plugged_ns = bench.clock.now_ns();
  bench.usb->plug();
  CHECK(bench.widget_shows(some_snapshot(7)));
  CHECK(bench.clock.now_ns() == plugged_ns);  // no timeout was needed
  REQUIRE(wait_for_state(*sink, PortState::kWorking));
  CHECK(sink->trouble().empty());
  CHECK(sink->link().stats().connects == 2);
}

TEST_CASE("a frame sent while the widget is gone is the one it shows when it is back") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.widget_shows(some_snapshot(1)));
  bench.usb->unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  bench.send(*sink, some_snapshot(2));
  bench.send(*sink, some_snapshot(3));
  bench.usb->plug();
  CHECK(bench.widget_shows(some_snapshot(3)));
}

TEST_CASE("a widget unplugged in the middle of a frame gets the whole frame when it is back") {
  for (const std::size_t byte_count : {0u, 1u, 4u, 100u, 517u}) {
    CAPTURE(byte_count);
    Bench bench;
    const auto sink = bench.open_sink();
    bench.usb->unplug_after(byte_count);
    bench.send(*sink, some_snapshot(9));
    REQUIRE(wait_for_state(*sink, PortState::kGone));
    CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame_count; }) == 0);
    bench.usb->plug();
    CHECK(bench.widget_shows(some_snapshot(9)));
  }
}

TEST_CASE("a frame that was cut short is sent again whole, and the widget is not left waiting for the rest") {
  for (const std::size_t byte_count : {1u, 3u, 4u, 5u, 300u, 517u}) {
    CAPTURE(byte_count);
    Bench bench;
    const auto sink = bench.open_sink();
    bench.usb->cut_next_write(byte_count);
    bench.send(*sink, some_snapshot(9));
    CHECK(bench.widget_shows(some_snapshot(9)));
    CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame_count; }) == 1);
  }
}

TEST_CASE("a message that a killed program left unfinished does not keep the next one from opening") {
  Bench bench;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    model.data_out(0x02, Bytes{0x7E, 6, 0x01, 0x02, 0, 1, 2, 3});
  });
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(9));
  CHECK(bench.widget_shows(some_snapshot(9)));
}

TEST_CASE("another widget in the same socket is not used instead of the unplugged one") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.widget_shows(some_snapshot(1)));
  bench.usb->unplug();
  REQUIRE(wait_for_state(*sink, PortState::kGone));
  REQUIRE(bench.usb->obey("serial EN999999"));
  bench.usb->plug();
  REQUIRE(bench.has_trouble(*sink, "EN999999"));
  CHECK(sink->state() == PortState::kGone);

  bench.usb->unplug();
  REQUIRE(bench.usb->obey("serial EN172589"));
  bench.usb->plug();
  CHECK(wait_for_state(*sink, PortState::kWorking));
}

TEST_CASE("a widget that accepts nothing three times is opened again") {
  Bench bench;
  bench.config.write_timeout_ns = bench.retry_ns = 5 * kNsPerMs;
  SystemClock clock;
  auto sink = DeviceSink::open(bench.plan(clock), bench.port, clock);
  REQUIRE(sink);
  bench.usb->stall(true);
  bench.send(**sink, some_snapshot(9));
  REQUIRE(wait_for_state(**sink, PortState::kGone));
  CHECK(bench.has_trouble(**sink, "accepts no data"));
  bench.usb->stall(false);
  CHECK(bench.widget_shows(some_snapshot(9)));
}

TEST_CASE("a device that does not answer like a widget is refused, and the message names the request") {
  Bench bench;
  bench.config.reply_timeout_ns = 5 * kNsPerMs;
  SystemClock clock;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.answers = false; });
  const auto sink = DeviceSink::open(bench.plan(clock), bench.port, clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kTimeout);
  CHECK(sink.error().message.find("label 3") != std::string::npos);
  CHECK_FALSE(bench.usb->claimed());
}

TEST_CASE("a widget with a blank serial number opens") {
  Bench bench;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.widget_serial_bcd = 0xFFFFFFFF; });
  CHECK(bench.open_sink()->link().identity() == "firmware 1.68");
}

TEST_CASE("a widget that sends continuously can be opened") {
  Bench bench;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    for (int i = 0; i < 5; ++i) model.receive_line_frame(0, line_frame_of(some_snapshot(1)));
    model.send_to_host(Bytes{0x7E, 0x05});
  });
  CHECK(bench.open_sink()->state() == PortState::kWorking);
}

TEST_CASE("two ports cannot share one connector of a widget") {
  Bench bench;
  const auto first = bench.open_sink();
  const auto second = DeviceSink::open(bench.plan(bench.clock), bench.port, bench.clock);
  REQUIRE_FALSE(second);
  CHECK(second.error().code == ErrorCode::kPermission);
}

TEST_CASE("a sink without its widget fails to open, or waits for it with wait_for_device") {
  Bench bench;
  bench.usb->unplug();
  const auto refused = DeviceSink::open(bench.plan(bench.clock), bench.port, bench.clock);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::kNotFound);

  bench.port.wait_for_device = true;
  const auto sink = bench.open_sink();
  CHECK(sink->state() == PortState::kGone);
  bench.send(*sink, some_snapshot(4));
  bench.usb->plug();
  CHECK(bench.widget_shows(some_snapshot(4)));
}

TEST_CASE("closing leaves the last frame on the line and releases the widget") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  sink->close(bench.clock.now_ns());  // at once: the frame may still be in the mailbox
  CHECK(sink->state() == PortState::kEnded);
  CHECK_FALSE(bench.usb->claimed());
  CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame; }) ==
        line_frame_of(some_snapshot(7)));
  sink->close(bench.clock.now_ns());  // a second time is harmless
}

TEST_CASE("closing with blackout on exit leaves all slots at 0") {
  Bench bench;
  bench.port.blackout_on_exit = true;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  REQUIRE(bench.widget_shows(some_snapshot(7)));
  sink->close(bench.clock.now_ns());
  CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.line(0).frame; }) ==
        Bytes(513, 0));
}

TEST_CASE("a sink destroyed while its widget accepts nothing does not wait for a timeout") {
  Bench bench;
  auto sink = bench.open_sink();
  bench.usb->stall(true);
  bench.send(*sink, some_snapshot(7));
  sink.reset();  // the clock stands still: a timeout would never end
  CHECK_FALSE(bench.usb->claimed());
}

TEST_CASE("a source delivers frames of the line, address 1 in slot 0") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  bench.advance_ns(5 * kNsPerMs);
  bench.usb->with_model<EnttecProModel>(
      [](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(some_snapshot(1))); });
  REQUIRE(bench.frames_come(*source, keeper, 1));
  CHECK(keeper.kept[0].slots == some_snapshot(1));
  CHECK(keeper.kept[0].view.universe == kUniverse);
  CHECK(keeper.kept[0].view.priority == kPriorityDefault);
  CHECK(keeper.kept[0].view.stamp_ns == bench.clock.now_ns());
  CHECK(keeper.kept[0].view.sender != 0);
  CHECK(source->state() == PortState::kWorking);
}

TEST_CASE("a short line frame is delivered with its own length") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    model.receive_line_frame(0, Bytes{0, 10, 20, 30});
  });
  REQUIRE(bench.frames_come(*source, keeper, 1));
  CHECK(keeper.kept[0].slots == Bytes{10, 20, 30});
}

TEST_CASE("frames are the same when reads return one byte at a time and there is noise between them") {
  Bench bench;
  bench.usb->limit_reads(1);
  const auto source = bench.open_source();
  FrameKeeper keeper;
  for (std::uint8_t i = 0; i < 5; ++i) {
    REQUIRE(bench.usb->obey("garbage 00E7FF7E0AFFFF"));
    bench.usb->with_model<EnttecProModel>(
        [&](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(some_snapshot(i))); });
    REQUIRE(bench.frames_come(*source, keeper, i + 1u));
    CHECK(keeper.kept[i].slots == some_snapshot(i));
  }
  bench.usb->limit_reads(0);
  CHECK(poll_until(
      *source, [] {}, [&] { return figure(*source, "garbage_bytes") == 5 * 7; }, std::chrono::seconds(1)));
  CHECK(source->counters().rejected == 5);
}

TEST_CASE("changes of state build up the whole frame") {
  Bench bench;
  bench.config.receive_mode = ProReceiveMode::kOnChange;
  const auto source = bench.open_source();
  REQUIRE(bench.usb->wait_for<EnttecProModel>([](const EnttecProModel& model) { return model.receive_modes[0] == 1; }));
  FrameKeeper keeper;
  Bytes slots(512, 0);
  slots[0] = 1;
  slots[511] = 9;
  bench.usb->with_model<EnttecProModel>(
      [&](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(slots)); });
  CHECK(poll_until(
      *source, [&] { (void)source->poll(0, keeper); },
      [&] { return !keeper.kept.empty() && keeper.kept.back().slots == slots; }));
  slots[200] = 77;
  bench.usb->with_model<EnttecProModel>(
      [&](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(slots)); });
  CHECK(poll_until(
      *source, [&] { (void)source->poll(0, keeper); }, [&] { return keeper.kept.back().slots == slots; }));
}

TEST_CASE("damaged line frames and those with another start code are counted and not delivered") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    model.receive_line_frame(0, line_frame_of(some_snapshot(1)), 0x01);
    model.receive_line_frame(0, line_frame_of(some_snapshot(2)), 0x02);
    model.receive_line_frame(0, Bytes{0xCC, 1, 2, 3});
    model.receive_line_frame(0, line_frame_of(some_snapshot(4)));
  });
  REQUIRE(bench.frames_come(*source, keeper, 1));
  CHECK(keeper.kept[0].slots == some_snapshot(4));
  CHECK(poll_until(
      *source, [] {}, [&] { return figure(*source, "line_errors") == 2; }, std::chrono::seconds(1)));
  CHECK(source->link().stats().other_start_codes == 1);
  CHECK(source->counters().frames == 1);
  CHECK(source->counters().rejected == 2);
}

TEST_CASE("frames without a poll are replaced by the newest and counted") {
  Bench bench;
  const auto source = bench.open_source();
  for (std::uint8_t i = 1; i <= 20; ++i)
    bench.usb->with_model<EnttecProModel>(
        [&](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(some_snapshot(i))); });
  CHECK(poll_until(
      *source, [] {}, [&] { return source->counters().frames == 20; }, std::chrono::seconds(10)));
  FrameKeeper keeper;
  REQUIRE(source->poll(bench.clock.now_ns(), keeper));
  REQUIRE(keeper.kept.size() == 1);
  CHECK(keeper.kept[0].slots == some_snapshot(20));
  CHECK(source->counters().dropped == 19);
}

TEST_CASE("a silent line changes the source to waiting after 1.25 s") {
  Bench bench;
  const auto source = bench.open_source();
  CHECK(source->state() == PortState::kWaiting);
  CHECK(source->next_deadline_ns() == kTimeNever);
  FrameKeeper keeper;
  bench.usb->with_model<EnttecProModel>(
      [](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(some_snapshot(1))); });
  REQUIRE(bench.frames_come(*source, keeper, 1));
  const TimeNs received_ns = bench.clock.now_ns();
  CHECK(source->next_deadline_ns() == received_ns + 1'250 * kNsPerMs);
  bench.advance_ns(1'249 * kNsPerMs);
  REQUIRE(source->poll(bench.clock.now_ns(), keeper));
  CHECK(source->state() == PortState::kWorking);
  bench.advance_ns(kNsPerMs);
  REQUIRE(source->poll(bench.clock.now_ns(), keeper));
  CHECK(source->state() == PortState::kWaiting);
}

TEST_CASE("a source receives again after its widget was replugged") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  bench.usb->unplug();
  REQUIRE(poll_until(
      *source, [&] { (void)source->poll(0, keeper); }, [&] { return source->state() == PortState::kGone; }));
  CHECK_FALSE(source->trouble().empty());
  bench.usb->plug();
  REQUIRE(poll_until(
      *source, [&] { (void)source->poll(0, keeper); }, [&] { return source->state() != PortState::kGone; }));
  bench.usb->with_model<EnttecProModel>(
      [](EnttecProModel& model) { model.receive_line_frame(0, line_frame_of(some_snapshot(5))); });
  REQUIRE(bench.frames_come(*source, keeper, 1));
  CHECK(keeper.kept[0].slots == some_snapshot(5));
}

TEST_CASE("a message without its end delays the next frame only shortly") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  // The head of a full frame and nothing else: the parser would wait for 513 bytes.
  REQUIRE(bench.usb->obey("garbage 7E0502020000"));
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { model.receive_line_frame(0, Bytes{0, 11, 22}); });
  for (int i = 0; i < 1000 && keeper.kept.empty(); ++i) {  // the thread must first get the bytes and then the time
    bench.advance_ns(50 * kNsPerMs);
    pollfd waited{.fd = source->poll_fd(), .events = POLLIN, .revents = 0};
    ::poll(&waited, 1, 10);
    REQUIRE(source->poll(bench.clock.now_ns(), keeper));
  }
  REQUIRE(keeper.kept.size() == 1);
  CHECK(keeper.kept[0].slots == Bytes{11, 22});
}

// --- Second connectors

constexpr SecondPort kSecond{.key = {0x0A, 0x1B, 0x2C, 0x3D},
                             .assign = 200,
                             .send = 201,
                             .receive = 202,
                             .receive_mode = 203,
                             .change_of_state = 204};

struct TwoPorts : Bench {
  explicit TwoPorts(std::optional<SecondPort> key) {
    config = {.line_count = 2, .second_needs_key = true, .second_port = key};
    usb->with_model<EnttecProModel>([](EnttecProModel& model) {
      model.product = "DMX USB PRO Mk2";
      model.second_port = kSecond;
    });
  }
  DevicePortConfig on(std::vector<DeviceLine> lines) const { return {.name = port.name, .lines = std::move(lines)}; }
};

TEST_CASE("an Mk2 sends on both connectors with the user's labels after its key was sent") {
  TwoPorts bench(kSecond);
  auto sink = DeviceSink::open(bench.plan(bench.clock), bench.on({{0, 3}, {1, 4}}), bench.clock);
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  CHECK(std::vector<Universe>((*sink)->universes().begin(), (*sink)->universes().end()) == std::vector<Universe>{3, 4});
  bench.send(**sink, some_snapshot(1), 3);
  bench.send(**sink, some_snapshot(2), 4);
  CHECK(bench.usb->wait_for([](const mock::UsbModel& model) {
    return model.line(0).frame == line_frame_of(some_snapshot(1)) &&
           model.line(1).frame == line_frame_of(some_snapshot(2));
  }));
  CHECK(bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.second_port_open; }));
}

TEST_CASE("one connector of an Mk2 may receive while the other sends, as two ports of one device") {
  TwoPorts bench(kSecond);
  auto sink = DeviceSink::open(bench.plan(bench.clock), bench.on({{0, 3}}), bench.clock);
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  auto source = DeviceSource::open(bench.plan(bench.clock), bench.on({{1, 9}}), bench.clock);
  REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
  bench.send(**sink, some_snapshot(1), 3);
  CHECK(bench.widget_shows(some_snapshot(1)));
  FrameKeeper keeper;
  REQUIRE(bench.usb->wait_for([](const mock::UsbModel& model) { return model.listens(1); }));
  bench.usb->with_model([](mock::UsbModel& model) { model.receive_line_frame(1, line_frame_of(some_snapshot(77))); });
  REQUIRE(bench.frames_come(**source, keeper, 1));
  CHECK(keeper.kept[0].view.universe == 9);
  CHECK(keeper.kept[0].slots == some_snapshot(77));
  // Each may be closed without the other.
  (*source).reset();
  bench.send(**sink, some_snapshot(5), 3);
  CHECK(bench.widget_shows(some_snapshot(5)));
  CHECK(bench.usb->claimed());
  (*sink)->close(bench.clock.now_ns());
  CHECK_FALSE(bench.usb->claimed());
}

TEST_CASE("a connector in use is refused, and its port continues") {
  TwoPorts bench(kSecond);
  auto sink = DeviceSink::open(bench.plan(bench.clock), bench.on({{1, 3}}), bench.clock);
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  const auto again = DeviceSink::open(bench.plan(bench.clock), bench.on({{1, 4}}), bench.clock);
  REQUIRE_FALSE(again);
  CHECK(again.error().message.find("connector 2 is in use") != std::string::npos);
  bench.send(**sink, some_snapshot(5), 3);
  CHECK(bench.usb->wait_for(
      [](const mock::UsbModel& model) { return model.line(1).frame == line_frame_of(some_snapshot(5)); }));
}

TEST_CASE(
    "the error for the second connector of an Mk2 without a key names what is needed, and nothing is sent to it") {
  TwoPorts bench({});
  const auto sink = DeviceSink::open(bench.plan(bench.clock), bench.on({{1, 3}}), bench.clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kUnsupported);
  CHECK(sink.error().message.find("second_port") != std::string::npos);
  CHECK_FALSE(bench.usb->claimed());
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    CHECK(model.newest_label == 0);       // no message
    CHECK(model.false_start_count == 0);  // and no byte outside a message
  });
  // Nothing is sent to it either if connector 1 is in use.
  auto first = DeviceSink::open(bench.plan(bench.clock), bench.on({{0, 3}}), bench.clock);
  REQUIRE_MESSAGE(first, (first ? "" : first.error().message));
  bench.send(**first, some_snapshot(1), 3);
  REQUIRE(bench.widget_shows(some_snapshot(1)));
  const auto sent_so_far = [&] {
    return bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) { return model.byte_count; });
  };
  const std::uint64_t before = sent_so_far();
  CHECK_FALSE(DeviceSink::open(bench.plan(bench.clock), bench.on({{1, 4}}), bench.clock));
  CHECK(sent_so_far() == before);
  bench.send(**first, some_snapshot(2), 3);
  CHECK(bench.widget_shows(some_snapshot(2)));
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    CHECK_FALSE(model.second_port_open);
    CHECK(model.line(1).frame_count == 0);
  });
}

TEST_CASE("a DMXking with two outputs is detected by a request, whatever its USB strings are") {
  Bench bench;
  bench.config.line_count = 2;
  bench.usb->with_model<EnttecProModel>([](EnttecProModel& model) {
    model.manufacturer = "FTDI";
    model.esta_id = 0x6A6B;
    model.device_id = 2;
    model.port_count = 2;
  });
  bench.port.lines = {{.line = 0, .universe = 1}, {.line = 1, .universe = 2}};
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1), 1);
  bench.send(*sink, some_snapshot(2), 2);
  CHECK(bench.usb->wait_for([](const mock::UsbModel& model) {
    return model.line(0).frame == line_frame_of(some_snapshot(1)) &&
           model.line(1).frame == line_frame_of(some_snapshot(2));
  }));
}

TEST_CASE("a widget with one connector gets no request for a second one") {
  Bench bench;
  bench.config.line_count = 2;
  bench.port.lines = {{.line = 1, .universe = 2}};
  const auto sink = DeviceSink::open(bench.plan(bench.clock), bench.port, bench.clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kUnsupported);
  CHECK(bench.usb->with_model([](mock::UsbModel& model) { return model.line(1).frame_count; }) == 0);
}

TEST_CASE("a function runs on the device's thread between frames, and gets nullptr when the device is gone") {
  Bench bench;
  const auto sink = bench.open_sink();
  std::atomic<int> calls{0};
  std::atomic<bool> had_device{false};
  sink->link().run_on_device([&](Widget&, WidgetContext* context) {
    had_device = context != nullptr && !context->lines().empty();
    ++calls;
  });
  CHECK(poll_until(
      *sink, [] {}, [&] { return calls == 1; }, std::chrono::seconds(10)));
  CHECK(had_device);
  sink->close(bench.clock.now_ns());
  sink->link().run_on_device([&](Widget&, WidgetContext* context) {
    had_device = context != nullptr;
    ++calls;
  });
  CHECK(calls == 2);
  CHECK_FALSE(had_device);
}

TEST_CASE("mock endpoints play a sine as a source and receive frames as a sink") {
  SystemClock clock;
  auto source = open_source({.scheme = "mock", .target = "enttec-pro/sine-test", .universes = {1}}, clock);
  REQUIRE_MESSAGE(source, (source ? "" : source.error().message));
  FrameKeeper keeper;
  REQUIRE(poll_until(
      **source, [&] { (void)(*source)->poll(clock.now_ns(), keeper); }, [&] { return keeper.kept.size() >= 2; }));
  const auto [low, high] = std::minmax_element(keeper.kept[0].slots.begin(), keeper.kept[0].slots.end());
  CHECK(*low == 0);
  CHECK(*high == 255);
  CHECK(keeper.kept[0].slots != keeper.kept[1].slots);

  auto sink = open_sink({.scheme = "mock", .target = "enttec-pro/sink-test", .universes = {2}}, clock);
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  const Bytes slots = some_snapshot(3);
  const FrameView frame{.universe = 2, .slots = slots};
  REQUIRE((*sink)->send(clock.now_ns(), {&frame, 1}));
  const auto usb = mock::mock_of_target("enttec-pro/sink-test", true);
  REQUIRE(usb);
  CHECK(usb->usb->wait_for<EnttecProModel>(
      [&](const EnttecProModel& model) { return model.line(0).frame == line_frame_of(slots); }));
  (*sink)->close(clock.now_ns());
}

TEST_CASE("an invalid port request is refused with what was expected") {
  SystemClock clock;
  const std::string unknown = open_sink({.scheme = "nonesuch", .target = "x", .universes = {1}}, clock).error().message;
  for (const DriverInfo* driver : drivers()) CHECK(unknown.find(driver->id) != std::string::npos);
  CHECK(open_sink({.scheme = "mock", .target = "enttec-pro", .universes = {1, 2}}, clock).error().code ==
        ErrorCode::kBadInput);
  CHECK(open_sink({.scheme = "mock", .target = "enttec-pro", .universes = {0}}, clock).error().code ==
        ErrorCode::kBadInput);
  CHECK(open_source({.scheme = "mock", .target = "teapot", .universes = {1}}, clock)
            .error()
            .message.find("mock:enttec-pro") != std::string::npos);
  CHECK(open_source({.scheme = "mock", .target = "enttec-proX", .universes = {1}}, clock).error().code ==
        ErrorCode::kBadInput);
  CHECK(has_driver("mock"));
  CHECK_FALSE(has_driver("sacn"));
}

TEST_CASE("an invalid mock command is refused with the list of commands") {
  MockUsb usb(std::make_unique<EnttecProModel>());
  for (const char* command :
       {"", "explode", "unplug now", "stall maybe", "garbage 7", "garbage zz", "cut-write -1", "serial "}) {
    CAPTURE(command);
    CHECK_FALSE(usb.obey(command));
  }
  CHECK(usb.obey("explode").error().message.find("limit-reads N") != std::string::npos);
  CHECK(usb.obey("stall on"));
  CHECK(usb.obey("cut-write 7"));
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
