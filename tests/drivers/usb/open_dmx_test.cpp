// A line timed by this machine: with a model of chip and receiver with timing, on a clock that waits advance.
#include "drivers/widgets/open_dmx.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "drivers/mock/mock_usb.h"
#include "drivers/mock/open_dmx_model.h"
#include "drivers/transport/ftdi.h"
#include "tests/support/device_bench.h"
#include "tests/support/fake_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::MockUsb;
using mock::OpenDmxModel;

// The device thread's part, in the test's own thread.
class Context final : public WidgetContext {
 public:
  Context(Transport& transport, Clock& clock, LineUse use) : transport_(transport), clock_(clock), use_(use) {}
  Transport& transport() override { return transport_; }
  TimeNs now_ns() const override { return clock_.now_ns(); }
  void sleep_until_ns(TimeNs deadline_ns) override { clock_.sleep_until_ns(deadline_ns); }
  std::span<const LineUse> lines() const override { return {&use_, 1}; }
  bool stopping() const override { return false; }
  void deliver(int, std::span<const std::uint8_t> line_frame, TimeNs) override {
    frames.emplace_back(line_frame.begin(), line_frame.end());
  }
  void count_rejected(std::uint64_t count) override { rejected += count; }

  std::vector<Bytes> frames;
  std::uint64_t rejected = 0;

 private:
  Transport& transport_;
  Clock& clock_;
  const LineUse use_;
};

struct Bench {
  explicit Bench(MockUsb::BusTime bus = {}, double rate_hz = 40.0, LineUse use = LineUse::kOutput)
      : widget({.rate_hz = rate_hz}) {
    usb->move_clock(bus);
    opener = mock::make_mock_opener(usb, clock);
    auto opened = opener->connect();
    REQUIRE_MESSAGE(opened, (opened ? "" : opened.error().message));
    transport = std::move(*opened);
    context = std::make_unique<Context>(*transport, clock, use);
    auto begun = widget.begin(*context);
    REQUIRE_MESSAGE(begun, (begun ? "" : begun.error().message));
    traits = *begun;
  }
  // Like the device thread: the next frame at its time, or as soon as the last one allows.
  void play(int count) {
    TimeNs due_ns = clock.now_ns();
    for (int i = 0; i < count; ++i) {
      clock.sleep_until_ns(due_ns);
      const bool late = clock.now_ns() >= due_ns + traits.keep_alive_ns;
      due_ns = (late ? clock.now_ns() : due_ns) + traits.keep_alive_ns;
      Slots snapshot;
      std::iota(snapshot.begin(), snapshot.end(), static_cast<std::uint8_t>(i));
      const Status sent = widget.send(*context, 0, snapshot);
      REQUIRE_MESSAGE(sent, (sent ? "" : sent.error().message));
    }
  }
  double figure(std::string_view name) const {
    for (const WidgetFigure& one : widget.figures())
      if (one.name == name) return one.value;
    return -1.0;
  }
  OpenDmxModel& model() {
    return usb->with_model<OpenDmxModel>([](OpenDmxModel& one) -> OpenDmxModel& { return one; });
  }

  testing::FakeClock clock;
  std::shared_ptr<MockUsb> usb = std::make_shared<MockUsb>(std::make_unique<OpenDmxModel>(), "mock:open-dmx");
  std::unique_ptr<Opener> opener;
  std::unique_ptr<Transport> transport;
  OpenDmx widget;
  std::unique_ptr<Context> context;
  WidgetTraits traits;
};

TEST_SUITE_BEGIN("open_dmx");

TEST_CASE("no frame is cut and every break and mark is long enough, at any rate and bus speed") {
  for (const DurationNs control_ns : {0, 50 * 1'000, 125 * 1'000, 1'000 * 1'000, 3'000 * 1'000}) {
    for (const double rate_hz : {1.0, 30.0, 44.0, 1'000.0}) {
      CAPTURE(control_ns);
      CAPTURE(rate_hz);
      Bench bench({.control_ns = control_ns, .bulk_ns = control_ns / 4}, rate_hz);
      bench.play(30);
      OpenDmxModel& model = bench.model();
      CHECK(model.cut_count == 0);
      CHECK(model.bad_break_count == 0);
      REQUIRE(model.timings.size() >= 29);  // the last one ends with the next break
      for (const OpenDmxModel::Timing& frame : model.timings) {
        CHECK(frame.break_ns >= 92 * kNsPerUs);
        CHECK(frame.mark_ns >= 12 * kNsPerUs);
        CHECK(frame.size == 513);
      }
      CHECK(model.line(0).frame_count >= 29);
    }
  }
}

TEST_CASE("a chip slower than its nominal clock is waited for") {
  Bench bench({.control_ns = 125 * kNsPerUs, .bulk_ns = 0}, 44.0);
  bench.model().slot_ns = 46 * kNsPerUs;  // 5 % slow: far outside of E1.11, so that only its status helps
  bench.play(40);
  CHECK(bench.model().cut_count == 0);
  CHECK(bench.figure("waits_for_transmitter") > 0.0);
}

TEST_CASE("a receiver that gets a break too early counts a cut frame, which the test above relies on") {
  Bench bench;
  bench.play(1);
  Transport& line = *bench.transport;
  const TimeNs never = bench.clock.now_ns() + kNsPerS;
  const Bytes frame(513, 0x55);
  REQUIRE(line.set_break(true, never));
  bench.clock.advance_ns(100 * kNsPerUs);
  REQUIRE(line.set_break(false, never));
  bench.clock.advance_ns(20 * kNsPerUs);
  REQUIRE(line.write(frame, never));
  const auto empty = line.transmitter_empty(never);
  REQUIRE(empty);
  CHECK_FALSE(*empty);
  REQUIRE(line.set_break(true, never));
  CHECK(bench.model().cut_count == 1);

  bench.clock.advance_ns(40 * kNsPerUs);  // too short a break
  REQUIRE(line.set_break(false, never));
  bench.clock.advance_ns(20 * kNsPerUs);
  REQUIRE(line.write(frame, never));
  CHECK(bench.model().bad_break_count == 1);
}

TEST_CASE("the requested rate is kept if the bus allows, else the reached rate is reported") {
  Bench quick({.control_ns = 125 * kNsPerUs, .bulk_ns = 0}, 30.0);
  quick.play(91);
  CHECK(quick.figure("requested_hz") == 30.0);
  CHECK(quick.figure("rate_hz") == doctest::Approx(30.0).epsilon(0.001));
  // Each frame takes the line 22.6 ms, and four transfers of 3 ms.
  Bench slow({.control_ns = 3 * kNsPerMs, .bulk_ns = 0}, 44.0);
  slow.play(50);
  CHECK(slow.figure("rate_hz") < 35.0);
  CHECK(slow.figure("rate_hz") > 20.0);
}

TEST_CASE("an output counts frames sent on its line, not frames passed to it") {
  testing::DeviceBench bench("open-dmx");
  bench.usb->with_model<OpenDmxModel>([](OpenDmxModel& model) { model.slot_ns = 0; });
  auto opened = DeviceSink::open(
      {.widget = std::make_unique<OpenDmx>(OpenDmxConfig{}), .opener = mock::make_mock_opener(bench.usb, bench.clock)},
      bench.port(0), bench.clock);
  REQUIRE_MESSAGE(opened, (opened ? "" : opened.error().message));
  DeviceSink& sink = **opened;
  std::uint64_t handed_over = 0;
  REQUIRE(bench.advance_until([&] {
    bench.send(sink, testing::some_snapshot(++handed_over));  // every 10 ms: more than the line can send
    return sink.frames_on_line().value_or(0) >= 20;
  }));
  const std::uint64_t left = sink.frames_on_line().value_or(0);
  CHECK(handed_over > left + left / 2);
  // The model detects the end of a frame by the next break, and the last break may have started.
  const auto ended = bench.usb->with_model<OpenDmxModel>([](OpenDmxModel& model) { return model.timings.size(); });
  CHECK(left - ended <= 1);
  testing::DeviceBench other("peperoni");
  CHECK_FALSE(other.open_sink()->frames_on_line().has_value());  // the device times its line
}

TEST_CASE("an output has every figure that docs/hardware.md lists") {
  Bench bench;
  bench.play(3);
  for (const char* name :
       {"requested_hz", "rate_hz", "break_us_min", "break_us_p50", "break_us_max", "mab_us_min", "mab_us_p50",
        "mab_us_max", "period_us_min", "period_us_p50", "period_us_max", "waits_for_transmitter"}) {
    CAPTURE(name);
    CHECK(bench.figure(name) >= 0.0);
  }
}

TEST_CASE("breaks and marks are reported with their guaranteed minimum") {
  Bench bench({.control_ns = 300 * kNsPerUs, .bulk_ns = 100 * kNsPerUs}, 30.0);
  bench.play(20);
  const auto& timings = bench.model().timings;
  const auto shortest = [&](auto member) {
    DurationNs least_ns = kTimeNever;
    for (const OpenDmxModel::Timing& frame : timings) least_ns = std::min(least_ns, frame.*member);
    return static_cast<double>(least_ns) * 1e-3;
  };
  CHECK(bench.figure("break_us_min") <= shortest(&OpenDmxModel::Timing::break_ns));
  CHECK(bench.figure("break_us_min") >= 110.0);
  CHECK(bench.figure("mab_us_min") <= shortest(&OpenDmxModel::Timing::mark_ns));
  CHECK(bench.figure("break_us_max") >= bench.figure("break_us_p50"));
  CHECK(bench.figure("break_us_p50") >= bench.figure("break_us_min"));
}

// --- Input

struct Input : Bench {
  Input() : Bench({}, 40.0, LineUse::kInput) {}
  void listen() {
    for (int i = 0; i < 200; ++i) {
      const Status listened = widget.listen(*context, clock.now_ns());
      REQUIRE_MESSAGE(listened, (listened ? "" : listened.error().message));
    }
  }
};

TEST_CASE("frames of every length are received, a full one before the next break") {
  Input input;
  Bytes full(513);
  std::iota(full.begin(), full.end(), std::uint8_t{0});
  input.model().receive_line_frame(0, full);
  input.listen();
  REQUIRE(input.context->frames.size() == 1);
  CHECK(input.context->frames[0] == full);
  const Bytes brief{0, 1, 2, 3};
  for (int i = 0; i < 3; ++i) input.model().receive_line_frame(0, brief);
  input.listen();
  REQUIRE(input.context->frames.size() >= 3);
  CHECK(input.context->frames.back() == brief);
  CHECK(input.context->rejected == 0);
  CHECK(input.figure("framing_errors") == 0.0);
}

TEST_CASE("zeros between other slots are slots and not breaks") {
  Input input;
  Bytes full(513, 0);
  for (std::size_t i = 62; i < full.size(); i += 62) full[i] = 9;  // zeros at the ends of packets
  input.model().receive_line_frame(0, full);
  input.listen();
  REQUIRE(input.context->frames.size() == 1);
  CHECK(input.context->frames[0] == full);
}

TEST_CASE("a frame with a damaged or a missing byte is counted and not delivered") {
  Input input;
  OpenDmxModel& model = input.model();
  model.receive_break();
  for (int i = 0; i < 10; ++i) model.receive_byte(static_cast<std::uint8_t>(i), i == 5);
  model.receive_break();
  for (int i = 0; i < 10; ++i) {
    if (i == 7) model.receive_overrun();
    model.receive_byte(static_cast<std::uint8_t>(i));
  }
  model.receive_line_frame(0, Bytes(513, 3));
  input.listen();
  REQUIRE(input.context->frames.size() == 1);
  CHECK(input.context->frames[0] == Bytes(513, 3));
  CHECK(input.context->rejected == 2);
  CHECK(input.figure("framing_errors") == 1.0);
  CHECK(input.figure("overruns") == 1.0);
}

TEST_CASE("for any input, no frame is longer than a line frame and every byte is counted") {
  std::mt19937 random(7);
  for (int run = 0; run < 200; ++run) {
    LineFrameParser parser;
    std::size_t given = 0;
    for (int i = 0; i < 3'000; ++i) {
      const unsigned long dice = random();
      const LineByte byte{.value = static_cast<std::uint8_t>(dice >> 16),
                          .is_break = dice % 600 == 0,
                          .framing_error = dice % 599 == 0,
                          .lost_before = dice % 601 == 0};
      const auto frame = parser.take(byte);
      if (!frame) continue;
      ++given;
      CHECK(frame->bytes.size() >= 1);
      CHECK(frame->bytes.size() <= 513);
    }
    CHECK(parser.counters().frames <= given);
    CHECK(parser.counters().short_frames <= parser.counters().frames);
  }
}

TEST_CASE("the baud rate request matches the kind of chip") {
  using ftdi::baud_request;
  using ftdi::chip_of;
  // 3 MHz / 12, and 12 MHz / 48 with bit 17 of the divisor set; chips with several lines include theirs.
  for (const int release : {0x0200, 0x0400, 0x0600, 0x1000}) {
    const auto request = baud_request(chip_of(static_cast<std::uint16_t>(release)), 250'000);
    CHECK(request.value == 0x000C);
    CHECK(request.index == 0x0000);
  }
  CHECK(baud_request(chip_of(0x0500), 250'000).index == 0x0001);
  CHECK(baud_request(chip_of(0x0900), 250'000).value == 0x0030);
  CHECK(baud_request(chip_of(0x0900), 250'000).index == 0x0200);
  CHECK(baud_request(chip_of(0x0700), 250'000).index == 0x0201);
  CHECK(baud_request(chip_of(0x0800), 250'000).value == 0x0030);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
