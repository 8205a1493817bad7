// The driver against the model in this process. Time stands still unless a test moves it.
#include "drivers/mock/nodle_model.h"
#include "tests/support/device_bench.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::NodleModel;
using testing::DeviceBench;
using testing::FrameKeeper;
using testing::line_frame_of;
using testing::some_snapshot;

struct Bench : DeviceBench {
  Bench() : DeviceBench("nodle") { input_line = 1; }
  template <class F>
  auto with(F&& f) {
    return usb->with_model<NodleModel>(std::forward<F>(f));
  }
  std::uint64_t blocks() {
    return with([](NodleModel& model) { return model.block_count; });
  }
  int mode() {
    return with([](NodleModel& model) { return model.mode; });
  }
  void receive(const Bytes& slots) {
    usb->with_model([&](auto& model) { model.receive_line_frame(1, line_frame_of(slots)); });
  }
  // Until `count` frames have come in all. The pause that ends a frame is time, which has to be moved.
  bool frames_come(DeviceSource& source, FrameKeeper& keeper, std::size_t count) {
    return advance_until([&] {
      (void)source.poll(clock.now_ns(), keeper);
      return keeper.kept.size() >= count;
    });
  }
};

TEST_SUITE_BEGIN("nodle");

TEST_CASE("a look reaches the output with every slot, and the mode says output only") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(4));
  CHECK(bench.shows(some_snapshot(4)));
  CHECK(bench.mode() == 2);
  CHECK(sink->rate_hz_max() == doctest::Approx(44.0));
}

TEST_CASE("only blocks that have changed are sent, and all of them once a second") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(4));
  REQUIRE(bench.shows(some_snapshot(4)));
  CHECK(bench.blocks() == 16);
  Bytes snapshot = some_snapshot(4);
  snapshot[100] ^= 1;
  bench.send(*sink, snapshot);
  REQUIRE(bench.shows(snapshot));
  CHECK(bench.blocks() == 17);
  bench.advance_ns(999 * kNsPerMs);
  snapshot[511] ^= 1;
  bench.send(*sink, snapshot);
  REQUIRE(bench.shows(snapshot));
  CHECK(bench.blocks() == 18);
  bench.advance_ns(kNsPerMs);
  snapshot[0] ^= 1;  // changes all the time do not put the refresh off
  bench.send(*sink, snapshot);
  CHECK(bench.usb->wait_for<NodleModel>([](const NodleModel& model) { return model.block_count == 34; }));
}

TEST_CASE("a device that lost its memory without an unplug has the look back within a second") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(4));
  REQUIRE(bench.shows(some_snapshot(4)));
  bench.with([](NodleModel& model) { model.memory.fill(0); });
  bench.advance_ns(kNsPerS);
  CHECK(bench.shows(some_snapshot(4)));
}

TEST_CASE("a slow device says how long a look takes in which everything changes") {
  Bench bench;
  bench.with([](NodleModel& model) { model.interval_ms = 4; });
  const auto sink = bench.open_sink();
  REQUIRE(sink->link().remarks().size() == 1);
  CHECK(sink->link().remarks()[0] == "a frame in which all 16 blocks of 32 slots change takes 64 ms: 15.6 a second");
}

TEST_CASE("frames of the input are handed over with every slot") {
  Bench bench;
  const auto source = bench.open_source();
  CHECK(bench.mode() == 4);
  FrameKeeper keeper;
  for (std::uint8_t i = 0; i < 5; ++i) {
    bench.receive(some_snapshot(static_cast<std::uint8_t>(10 * i)));
    REQUIRE(bench.frames_come(*source, keeper, i + 1u));
    CHECK(keeper.kept[i].slots == some_snapshot(static_cast<std::uint8_t>(10 * i)));
  }
  CHECK(source->counters().rejected == 0);
}

TEST_CASE("blocks of two frames do not mix: a number that does not go up begins the next") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  Bytes first = some_snapshot(1), second = some_snapshot(2);
  bench.usb->with_model([&](auto& model) {
    model.receive_line_frame(1, line_frame_of(first));
    model.receive_line_frame(1, line_frame_of(second));
  });
  // The first frame is handed over though no pause has come: nobody moves time here.
  REQUIRE(testing::poll_until(
      *source, [&] { (void)source->poll(bench.clock.now_ns(), keeper); }, [&] { return !keeper.kept.empty(); }));
  CHECK(keeper.kept[0].slots == first);
  REQUIRE(bench.frames_come(*source, keeper, 2));
  CHECK(keeper.kept[1].slots == second);
}

TEST_CASE("output and input work at the same time on one device, opened once") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  const auto source = bench.open_source();
  CHECK(bench.mode() == 6);
  FrameKeeper keeper;
  for (std::uint8_t i = 1; i <= 5; ++i) {
    bench.receive(some_snapshot(static_cast<std::uint8_t>(100 + i)));
    bench.send(*sink, some_snapshot(i));
    CHECK(bench.shows(some_snapshot(i)));
    REQUIRE(bench.frames_come(*source, keeper, i));
    CHECK(keeper.kept[i - 1u].slots == some_snapshot(static_cast<std::uint8_t>(100 + i)));
  }
  CHECK(bench.with([](NodleModel& model) { return model.power_on_count; }) == 1);
  // An unplug takes both, a replug brings both back.
  bench.usb->unplug();
  REQUIRE(testing::wait_for_state(*sink, PortState::kGone));
  CHECK(source->state() == PortState::kGone);
  bench.usb->plug();
  // The line's record outlives the plug, so the memory of the device tells.
  CHECK(bench.usb->wait_for<NodleModel>([](const NodleModel& model) {
    return model.mode == 6 && std::equal(model.memory.begin(), model.memory.end(), some_snapshot(5).begin());
  }));
  bench.receive(some_snapshot(77));
  REQUIRE(bench.frames_come(*source, keeper, 6));
  CHECK(keeper.kept[5].slots == some_snapshot(77));
}

TEST_CASE("closing the output leaves its look on the line while the input goes on, and the last close ends listening") {
  Bench bench;
  const auto sink = bench.open_sink();
  const auto source = bench.open_source();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  sink->close(bench.clock.now_ns());
  CHECK(bench.mode() == 6);
  CHECK(bench.shows(some_snapshot(1)));
  (void)source;
}

TEST_CASE("a look that is not shown is not believed: it is sent whole after a failed report") {
  Bench bench;
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.shows(some_snapshot(1)));
  bench.usb->cut_next_write(0);
  Bytes snapshot = some_snapshot(1);
  snapshot[0] ^= 1;
  bench.send(*sink, snapshot);
  CHECK(bench.advance_until([&] { return bench.shows(snapshot, std::chrono::milliseconds(1)); }));
  CHECK(bench.usb->wait_for<NodleModel>([](const NodleModel& model) { return model.block_count >= 32; }));
}

TEST_CASE("reports that are no blocks are counted and change nothing") {
  Bench bench;
  const auto source = bench.open_source();
  FrameKeeper keeper;
  bench.usb->with_model([](auto& model) {
    model.send_to_host(Bytes(33, 200));
    model.send_to_host(Bytes(5, 0));
    model.send_to_host(Bytes(64, 1));
  });
  REQUIRE(bench.advance_until([&] {
    (void)source->poll(bench.clock.now_ns(), keeper);
    return source->counters().rejected == 3;
  }));
  CHECK(keeper.kept.empty());
  bench.receive(some_snapshot(3));
  REQUIRE(bench.frames_come(*source, keeper, 1));
  CHECK(keeper.kept[0].slots == some_snapshot(3));
}

TEST_CASE("reports that come in pieces are counted, and none is taken for a block") {
  Bench bench;
  const auto source = bench.open_source();
  bench.usb->limit_reads(1);
  FrameKeeper keeper;
  bench.receive(some_snapshot(3));
  REQUIRE(bench.advance_until([&] {
    (void)source->poll(bench.clock.now_ns(), keeper);
    return source->counters().rejected >= 16;
  }));
  CHECK(keeper.kept.empty());
  bench.usb->limit_reads(0);
  bench.receive(some_snapshot(5));
  REQUIRE(bench.frames_come(*source, keeper, 1));
}

TEST_CASE("reports that come late are handed over all the same") {
  Bench bench;
  const auto source = bench.open_source();
  bench.usb->slow_down(2 * kNsPerMs);
  FrameKeeper keeper;
  bench.receive(some_snapshot(3));
  REQUIRE(bench.advance_until([&] {
    (void)source->poll(bench.clock.now_ns(), keeper);
    return !keeper.kept.empty() && keeper.kept.back().slots == some_snapshot(3);
  }));
}

TEST_CASE("an unplug before any report of a look ends with that look") {
  Bench bench;
  testing::check_unplug_at_every_transfer(bench);
}
TEST_CASE("a report that is cut short at any byte costs no look") {
  Bench bench;
  testing::check_cut_write(bench, 33);
}
TEST_CASE("what the device says is no reason to stop") {
  Bench bench;
  testing::check_garbage(bench);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
