// The source of strobe inputs with a model of a chip, on a clock that stands still unless moved.
#include "drivers/gpio/gpio_source.h"

#include <vector>

#include <doctest/doctest.h>
#include <poll.h>

#include "drivers/gpio/gpio_model.h"
#include "sim/pump.h"
#include "tests/support/fake_clock.h"
#include "tests/support/fake_ports.h"

namespace footlight::drivers {
namespace {

using footlight::testing::FakeClock;
using footlight::testing::FakeSource;
using footlight::testing::FakeWaiter;
using mock::GpioModel;

// Keeps the frames that a source delivers.
class Frames final : public FrameReceiver {
 public:
  struct Frame {
    FrameView view;
    std::vector<std::uint8_t> slots;
  };
  void receive(const FrameView& frame) override {
    frames.push_back({frame, {frame.slots.begin(), frame.slots.end()}});
    (frame.start_code == kStartCodeLevels ? levels : priorities) = frames.back().slots;
  }
  [[nodiscard]] int level(Address address) const {
    return levels.at(static_cast<std::size_t>(slot_of_address(address)));
  }
  [[nodiscard]] int priority(Address address) const {
    return priorities.at(static_cast<std::size_t>(slot_of_address(address)));
  }

  std::vector<Frame> frames;
  std::vector<std::uint8_t> levels, priorities;
};

GpioConfig config_of(std::vector<std::string> lines) {
  GpioConfig config;
  config.chip = "mock";
  config.lines = std::move(lines);
  config.universe = 3;
  config.address = 25;
  config.name = "gpio:mock";
  config.strobe.hold_ns = 0;
  return config;
}

struct Bench {
  explicit Bench(GpioConfig config) {
    auto opened = GpioSource::open(std::move(config), mock::make_model_chips(model), clock);
    REQUIRE_MESSAGE(opened, opened.error().message);
    source = std::move(*opened);
    poll();
  }
  void poll() { REQUIRE(source->poll(clock.now_ns(), frames)); }
  void poll_after(DurationNs by_ns) {
    clock.advance_ns(by_ns);
    poll();
  }
  // Polls at the source's own deadlines for a while, like the pump.
  void run_for(DurationNs duration_ns) {
    const TimeNs end_ns = clock.now_ns() + duration_ns;
    for (;;) {
      const TimeNs next_ns = is_readable() ? clock.now_ns() : source->next_deadline_ns();
      if (next_ns > end_ns) break;
      clock.sleep_until_ns(next_ns);
      poll();
    }
    clock.sleep_until_ns(end_ns);
  }
  [[nodiscard]] bool is_readable() const {
    pollfd fd{.fd = source->poll_fd(), .events = POLLIN, .revents = 0};
    return ::poll(&fd, 1, 0) == 1;
  }

  FakeClock clock;
  std::shared_ptr<GpioModel> model = std::make_shared<GpioModel>(32);
  std::unique_ptr<GpioSource> source;
  Frames frames;
};

TEST_SUITE_BEGIN("gpio source");

TEST_CASE("the first poll delivers the priorities of its slots, then the levels") {
  GpioConfig config = config_of({"17", "4"});
  config.priority = 150;
  Bench bench(config);
  REQUIRE(bench.frames.frames.size() == 2);
  CHECK(bench.frames.frames[0].view.start_code == kStartCodePriorities);
  CHECK(bench.frames.frames[1].view.start_code == kStartCodeLevels);
  for (const auto& frame : bench.frames.frames) {
    CHECK(frame.view.universe == 3);
    CHECK(frame.view.priority == 150);
    CHECK(frame.view.sender == bench.frames.frames[0].view.sender);
    CHECK(frame.view.sender != 0);
    CHECK(frame.view.silence_max_ns > 0);
    CHECK(frame.slots.size() == kSlotCountMax);
  }
  for (Address address = 1; address <= kSlotCountMax; ++address)
    CHECK(bench.frames.priority(address) == (address == 25 || address == 26 ? 150 : 0));
  CHECK(bench.source->universes().size() == 1);
  CHECK(bench.source->state() == PortState::kWorking);
}

TEST_CASE("a strobe input of priority 150 wins its own slots from a desk of priority 100 and no others") {
  FakeClock clock;
  FakeWaiter waiter(clock);
  Universes universes(std::array<Universe, 1>{3});
  Pump pump(universes, clock, waiter);
  GpioConfig config = config_of({"17", "4"});  // addresses 25 and 26
  config.priority = 150;
  const auto model = std::make_shared<GpioModel>(32);
  auto strobe = GpioSource::open(std::move(config), mock::make_model_chips(model), clock);
  REQUIRE(strobe);
  FakeSource desk(waiter, "sacn:3", {3});
  // The descriptors of a model chip are real ones, which this waiter does not support.
  class Polled final : public Source {
   public:
    Polled(Source& source, int fd) : source_(source), fd_(fd) {}
    std::string name() const override { return source_.name(); }
    int poll_fd() const override { return fd_; }
    TimeNs next_deadline_ns() const override { return source_.next_deadline_ns(); }
    PortState state() const override { return source_.state(); }
    PortCounters counters() const override { return source_.counters(); }
    Status poll(TimeNs now_ns, FrameReceiver& receiver) override { return source_.poll(now_ns, receiver); }
    std::span<const Universe> universes() const override { return source_.universes(); }

   private:
    Source& source_;
    const int fd_;
  } polled(**strobe, waiter.make_fd([&] {
    pollfd fd{.fd = (*strobe)->poll_fd(), .events = POLLIN, .revents = 0};
    return ::poll(&fd, 1, 0) == 1;
  }));
  pump.add_source(polled);
  pump.add_source(desk);
  pump.start();
  const auto run_for = [&](DurationNs duration_ns) {
    const TimeNs end_ns = clock.now_ns() + duration_ns;
    waiter.at(end_ns, [&] { waiter.interrupt(); });
    while (clock.now_ns() < end_ns) pump.step();
  };
  const auto check_snapshot = [&](int desk_level, int first, int second) {
    Slots levels;
    FrameStamp stamp;
    universes.snapshot(0, levels, stamp);
    for (Address address = 1; address <= kSlotCountMax; ++address) {
      CAPTURE(address);
      const int expected = address == 25 ? first : address == 26 ? second : desk_level;
      CHECK(levels[static_cast<std::size_t>(slot_of_address(address))] == expected);
    }
  };
  run_for(kNsPerMs);
  desk.give(3, 200);
  run_for(kNsPerMs);
  check_snapshot(200, 0, 0);  // off is a level too: the desk cannot light a slot that the switch has off
  model->drive(17, true, clock.now_ns());
  run_for(kNsPerMs);
  check_snapshot(200, 255, 0);
  desk.give(3, 77);  // the desk controls all other slots
  model->drive(4, true, clock.now_ns());
  run_for(kNsPerMs);
  check_snapshot(77, 255, 255);
  model->drive(17, false, clock.now_ns());
  desk.give(3, 78, 149);  // still below 150
  run_for(100 * kNsPerMs);
  check_snapshot(78, 0, 255);
  desk.give(3, 79, 151);  // above: the desk wins all slots
  run_for(kNsPerMs);
  check_snapshot(79, 79, 79);
  pump.stop();
}

TEST_CASE("an edge makes the descriptor readable and a frame with the stamp of the kernel") {
  Bench bench(config_of({"17", "4"}));
  CHECK_FALSE(bench.is_readable());
  const TimeNs pressed_ns = bench.clock.now_ns() + 10 * kNsPerMs;
  bench.model->drive(4, true, pressed_ns);
  CHECK(bench.is_readable());
  bench.frames.frames.clear();
  bench.poll_after(11 * kNsPerMs);
  REQUIRE(bench.frames.frames.size() == 1);
  CHECK(bench.frames.frames[0].view.stamp_ns == pressed_ns);
  CHECK(bench.frames.level(25) == 0);
  CHECK(bench.frames.level(26) == 255);
  CHECK_FALSE(bench.is_readable());
}

TEST_CASE("a press and a release that are read together are two frames") {
  Bench bench(config_of({"17"}));
  bench.frames.frames.clear();
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.model->drive(17, false, bench.clock.now_ns() + kNsPerMs);
  bench.poll_after(2 * kNsPerMs);
  REQUIRE(bench.frames.frames.size() == 2);
  CHECK(bench.frames.frames[0].slots[24] == 255);
  CHECK(bench.frames.frames[1].slots[24] == 0);
}

TEST_CASE("a bouncing contact makes one flash, at the time of its first edge") {
  GpioConfig config = config_of({"17"});
  config.strobe.mode = StrobeMode::kOneShot;
  config.strobe.hold_ns = 80 * kNsPerMs;
  config.strobe.debounce_ns = 5 * kNsPerMs;
  Bench bench(config);
  bench.run_for(100 * kNsPerMs);
  bench.frames.frames.clear();
  const TimeNs pressed_ns = bench.clock.now_ns();
  bench.model->bounce(17, true, pressed_ns, 9, 300 * kNsPerUs);
  bench.run_for(200 * kNsPerMs);
  REQUIRE(bench.frames.frames.size() == 2);
  CHECK(bench.frames.frames[0].view.stamp_ns == pressed_ns);
  CHECK(bench.frames.frames[0].slots[24] == 255);
  CHECK(bench.frames.frames[1].view.stamp_ns == pressed_ns + 80 * kNsPerMs);
  CHECK(bench.frames.frames[1].slots[24] == 0);
}

TEST_CASE("a queue overflow is detected, and the level is read") {
  GpioConfig config = config_of({"17"});
  config.strobe.flashes_hz_max = 0;
  Bench bench(config);
  bench.model->bounce(17, true, bench.clock.now_ns(), 41, 10 * kNsPerUs);  // ends active; the queue ends inactive
  CHECK(bench.model->lost(17) == 25);
  bench.poll_after(kNsPerMs);
  CHECK(bench.frames.level(25) == 255);
  CHECK(bench.source->counters().rejected == 1);
}

TEST_CASE("the level after a lost edge is found within a second") {
  Bench bench(config_of({"17"}));
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.poll();
  CHECK(bench.frames.level(25) == 255);
  bench.model->lose_edges(17, true);
  bench.model->drive(17, false, bench.clock.now_ns());
  CHECK_FALSE(bench.is_readable());
  bench.run_for(1'001 * kNsPerMs);
  CHECK(bench.frames.level(25) == 0);
}

TEST_CASE("during a storm of edges the line is read ten times a second, and the storm is reported once") {
  GpioConfig config = config_of({"17"});
  config.strobe.flashes_hz_max = 0;
  Bench bench(config);
  int polls = 0;
  std::string notice;
  bool level = false;
  // 20,000 edges a second for a second; the source is polled whenever it is readable.
  for (int edge = 0; edge < 20'000; ++edge) {
    bench.model->drive(17, level = !level, bench.clock.now_ns());
    bench.clock.advance_ns(50 * kNsPerUs);
    if (bench.is_readable() || bench.source->next_deadline_ns() <= bench.clock.now_ns()) {
      bench.poll();
      ++polls;
      while (const auto next = bench.source->take_notice()) notice += next->text;
    }
  }
  CHECK(polls < 3'000);
  CHECK(notice.find("line 17: more than 200 edges in 100 ms") == 0);
  CHECK(notice.find("more than", 30) == std::string::npos);
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.run_for(200 * kNsPerMs);
  CHECK(bench.frames.level(25) == 255);
  CHECK(bench.source->state() == PortState::kWorking);
  bench.model->drive(17, false, bench.clock.now_ns());  // the storm has ended: edges are read again
  CHECK(bench.is_readable());
}

TEST_CASE("the whole frame is repeated before any sender times out") {
  Bench bench(config_of({"17"}));
  bench.frames.frames.clear();
  bench.run_for(10 * kNsPerS);
  REQUIRE(bench.frames.frames.size() >= 20);
  for (std::size_t i = 2; i < bench.frames.frames.size(); ++i)
    CHECK(bench.frames.frames[i].view.stamp_ns - bench.frames.frames[i - 2].view.stamp_ns < kNsPerS);
}

TEST_CASE("unplugged: off at once, gone with the reason, plugged in: back within a second with the current level") {
  GpioConfig config = config_of({"17"});
  config.strobe.flashes_hz_max = 0;
  Bench bench(config);
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.poll();
  CHECK(bench.frames.level(25) == 255);
  bench.model->unplug();
  CHECK(bench.is_readable());
  bench.poll();
  CHECK(bench.frames.level(25) == 0);
  CHECK(bench.source->state() == PortState::kGone);
  CHECK(bench.source->trouble().find("gone") != std::string::npos);
  CHECK_FALSE(bench.is_readable());
  bench.run_for(3 * kNsPerS);
  CHECK(bench.source->state() == PortState::kGone);
  bench.model->plug();
  bench.run_for(kNsPerS);
  CHECK(bench.source->state() == PortState::kWorking);
  CHECK(bench.source->trouble().empty());
  CHECK(bench.frames.level(25) == 255);
  bench.model->drive(17, false, bench.clock.now_ns());
  CHECK(bench.is_readable());
}

TEST_CASE("after a thousand replugs no line is requested twice and none is lost") {
  Bench bench(config_of({"17", "18"}));
  const int fd = bench.source->poll_fd();
  for (int round = 0; round < 1000; ++round) {
    bench.model->unplug();
    bench.poll();
    REQUIRE(bench.source->state() == PortState::kGone);
    bench.model->plug();
    bench.run_for(300 * kNsPerMs);
    REQUIRE(bench.source->state() == PortState::kWorking);
  }
  CHECK(bench.source->poll_fd() == fd);
  CHECK(bench.model->is_requested(17));
  bench.source.reset();
  CHECK_FALSE(bench.model->is_requested(17));
  CHECK_FALSE(bench.model->is_requested(18));
}

TEST_CASE("an unnoticed replug is detected when the levels are read") {
  Bench bench(config_of({"17"}));
  bench.model->unplug();
  bench.model->plug();
  bench.run_for(2 * kNsPerS);
  CHECK(bench.source->state() == PortState::kWorking);
  bench.model->drive(17, true, bench.clock.now_ns());
  CHECK(bench.is_readable());
}

TEST_CASE("a line that cannot be read is off and requested again") {
  Bench bench(config_of({"17"}));
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.poll();
  bench.model->fail_reads(17, true);
  bench.run_for(2 * kNsPerS);
  CHECK(bench.frames.level(25) == 0);
  CHECK(bench.source->state() == PortState::kGone);
  CHECK(bench.source->trouble().find("I/O error") != std::string::npos);
  CHECK(bench.source->counters().errors >= 1);
  bench.model->fail_reads(17, false);
  bench.run_for(kNsPerS);
  CHECK(bench.source->state() == PortState::kWorking);
  CHECK(bench.frames.level(25) == 255);
}

TEST_CASE("a stuck line affects only its own slot") {
  GpioConfig config = config_of({"17", "18"});
  config.strobe.flashes_hz_max = 0;
  Bench bench(config);
  bench.model->drive(17, true, bench.clock.now_ns());
  bench.poll();
  bench.model->stick(17, true);
  for (int i = 0; i < 10; ++i) {
    bench.model->drive(17, i % 2 == 0, bench.clock.now_ns());
    bench.model->drive(18, i % 2 == 0, bench.clock.now_ns());
    bench.poll_after(50 * kNsPerMs);
    CHECK(bench.frames.level(25) == 255);
    CHECK(bench.frames.level(26) == (i % 2 == 0 ? 255 : 0));
  }
}

TEST_CASE("the cap is reported once in ten seconds, with the number of flashes") {
  Bench bench(config_of({"17"}));
  std::vector<std::string> notices;
  for (int press = 0; press < 200; ++press) {  // ten a second for twenty seconds
    bench.model->drive(17, true, bench.clock.now_ns());
    bench.run_for(50 * kNsPerMs);
    bench.model->drive(17, false, bench.clock.now_ns());
    bench.run_for(50 * kNsPerMs);
    while (const auto notice = bench.source->take_notice()) {
      CHECK(notice->id == "flashes-held-back");
      notices.push_back(notice->text);
    }
  }
  REQUIRE(notices.size() == 2);
  CHECK(notices[0].find("line 17: 1 flash held back") == 0);
  CHECK(notices[1].find("at most 4 a second") != std::string::npos);
  CHECK(bench.source->counters().dropped >= 100);
}

TEST_CASE("the error for a failed open names the next step, and no line stays requested") {
  FakeClock clock;
  auto model = std::make_shared<GpioModel>(32);
  const auto error_of = [&](GpioConfig config) {
    auto opened = GpioSource::open(std::move(config), mock::make_model_chips(model), clock);
    REQUIRE_FALSE(opened);
    return opened.error();
  };
  model->hold(18, "spi0 CS0");
  const Error busy = error_of(config_of({"17", "18"}));
  CHECK(busy.code == ErrorCode::kIo);
  CHECK(busy.message.find("gpio:mock: mock line 18: in use by \"spi0 CS0\"") == 0);
  CHECK_FALSE(model->is_requested(17));
  CHECK(error_of(config_of({"99"})).code == ErrorCode::kNotFound);
  GpioConfig too_many = config_of({"1", "2", "3"});
  too_many.address = 511;
  CHECK(error_of(too_many).code == ErrorCode::kBadInput);
  model->forbid(true);
  GpioConfig waiting = config_of({"17"});
  waiting.wait_for_device = true;  // helps if the chip is missing, not if it refuses
  CHECK(error_of(waiting).code == ErrorCode::kPermission);
  model->forbid(false);
  model->unplug();
  CHECK(error_of(config_of({"17"})).code == ErrorCode::kNotFound);
}

TEST_CASE("with wait_for_device it starts without the chip and finds it later") {
  FakeClock clock;
  auto model = std::make_shared<GpioModel>(32);
  model->unplug();
  GpioConfig config = config_of({"17"});
  config.wait_for_device = true;
  auto opened = GpioSource::open(config, mock::make_model_chips(model), clock);
  REQUIRE(opened);
  Frames frames;
  REQUIRE((*opened)->poll(clock.now_ns(), frames));
  CHECK((*opened)->state() == PortState::kGone);
  model->plug();
  model->drive(17, true, clock.now_ns());
  clock.sleep_until_ns((*opened)->next_deadline_ns());
  REQUIRE((*opened)->poll(clock.now_ns(), frames));
  CHECK((*opened)->state() == PortState::kWorking);
  CHECK(frames.level(25) == 255);
}

TEST_CASE("polarity and bias are passed to the chip") {
  GpioConfig config = config_of({"17"});
  config.active_low = true;
  config.bias = GpioBias::kPullUp;
  Bench bench(config);
  CHECK(bench.model->last_request().active_low);
  CHECK(bench.model->last_request().bias == GpioBias::kPullUp);
}

TEST_CASE("the shipped model chip closes line N N times a second, with bounces") {
  FakeClock clock;
  GpioConfig config = config_of({"5", "0"});
  config.strobe.debounce_ns = 5 * kNsPerMs;
  config.strobe.flashes_hz_max = 0;
  auto opened = GpioSource::open(config, mock::make_mock_chips(clock), clock);
  REQUIRE(opened);
  Frames frames;
  const TimeNs end_ns = clock.now_ns() + 10 * kNsPerS;
  while (clock.now_ns() < end_ns) {
    REQUIRE((*opened)->poll(clock.now_ns(), frames));
    clock.sleep_until_ns((*opened)->next_deadline_ns());
  }
  CHECK((*opened)->strobe(0).counters().flashes == 50);
  CHECK((*opened)->strobe(0).counters().bounces == 200);
  CHECK((*opened)->strobe(0).counters().repaired == 0);
  CHECK((*opened)->strobe(1).counters().flashes == 0);
}

TEST_CASE("a stamp of either kernel clock is converted to the pump's clock, and is never in the future") {
  constexpr TimeNs kNow = 5'000 * kNsPerS;
  constexpr std::int64_t kRealtime = 1'700'000'000 * kNsPerS;
  CHECK(monotonic_stamp_ns(kNow - 7, kNow, kRealtime) == kNow - 7);
  CHECK(monotonic_stamp_ns(kRealtime - 7, kNow, kRealtime) == kNow - 7);
  CHECK(monotonic_stamp_ns(kNow + 7, kNow, kRealtime) == kNow);
  CHECK(monotonic_stamp_ns(kRealtime + 7, kNow, kRealtime) == kNow);
  // A machine without a battery: the wall clock starts at 1970 as well, so the two are close.
  CHECK(monotonic_stamp_ns(kNow - 7, kNow, kNow + 20 * kNsPerS) == kNow - 7);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
