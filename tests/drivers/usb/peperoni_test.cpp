#include "drivers/widgets/peperoni_frame.h"

#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/peperoni_model.h"
#include "tests/support/device_bench.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using testing::DeviceBench;
using testing::some_snapshot;

Slots ramp() {
  Slots slots;
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i * 5 + 3);
  return slots;
}

Bytes line_frame_of(const Slots& snapshot) {
  Bytes frame{0};
  frame.insert(frame.end(), snapshot.begin(), snapshot.end());
  return frame;
}

TEST_SUITE_BEGIN("peperoni");

TEST_CASE("the firmware's release selects the transfer format") {
  CHECK(peperoni_frames(0x0101) == PeperoniFrames::kControl);
  CHECK(peperoni_frames(0x03FF) == PeperoniFrames::kControl);
  CHECK(peperoni_frames(0x0400) == PeperoniFrames::kBulk);
  CHECK(peperoni_frames(0x0499) == PeperoniFrames::kBulk);
  CHECK(peperoni_frames(0x0500) == PeperoniFrames::kBulkWithStatus);
}

TEST_CASE("the short message starts with its four bytes, and has another request for the second universe") {
  const auto first = encode_peperoni_bulk(0, ramp());
  REQUIRE(first.size() == 516);
  CHECK(Bytes(first.begin(), first.begin() + 6) == Bytes{0x01, 0x00, 0x00, 0x02, 3, 8});
  CHECK(encode_peperoni_bulk(1, ramp())[1] == 0x04);
}

TEST_CASE("the long message has the same bytes as the maker's software") {
  const auto message = encode_peperoni_with_status(1, ramp());
  REQUIRE(message.size() == 532);
  CHECK(Bytes(message.begin(), message.begin() + 22) == Bytes{0x02, 0x4D, 0x6B, 0x32, 0x00, 0x01, 0x07, 0x02,
                                                              0x82, 50,   0,    181,  250,  0x02, 0x4D, 0x6B,
                                                              0x32, 0x01, 0x02, 0x00, 3,    8});
  CHECK(message.back() == ramp().back());
}

TEST_CASE("an answer is eight bytes that start with the magic bytes, and its seventh is the status") {
  CHECK(decode_peperoni_status(Bytes{0x02, 0x4D, 0x6B, 0x32, 1, 2, 0, 0}) == PeperoniStatus::kOk);
  CHECK(decode_peperoni_status(Bytes{0x02, 0x4D, 0x6B, 0x32, 1, 2, 1, 0}) == PeperoniStatus::kTimeout);
  CHECK_FALSE(decode_peperoni_status(Bytes{0x02, 0x4D, 0x6B, 0x33, 1, 2, 0, 0}));
  CHECK_FALSE(decode_peperoni_status(Bytes{0x02, 0x4D, 0x6B, 0x32, 1, 2, 0}));
  CHECK_FALSE(decode_peperoni_status(Bytes{0x02, 0x4D, 0x6B, 0x32, 1, 2, 0, 0, 0}));
  CHECK_FALSE(decode_peperoni_status({}));
}

TEST_CASE("the model accepts the messages of both generations, and only universes that it has") {
  mock::PeperoniModel model;
  model.usb_product = 0x0004;
  model.power_on();
  model.data_out(0x02, encode_peperoni_with_status(1, ramp()));
  CHECK(model.line(1).frame == line_frame_of(ramp()));
  CHECK(decode_peperoni_status(model.data_in(0x82, 64)) == PeperoniStatus::kOk);
  model.data_out(0x02, encode_peperoni_bulk(0, ramp()));
  CHECK(model.line(0).frame == line_frame_of(ramp()));
  CHECK(model.broken_count == 0);

  mock::PeperoniModel one;
  one.power_on();
  one.data_out(0x02, encode_peperoni_with_status(1, ramp()));
  CHECK(decode_peperoni_status(one.data_in(0x82, 64)) == PeperoniStatus::kWrongUniverse);
  one.data_out(0x02, encode_peperoni_bulk(1, ramp()));
  CHECK(one.broken_count == 1);
}

// --- The driver with the model in this process. Time stands still unless a test moves it.

template <class F>
auto with(DeviceBench& bench, F&& f) {
  return bench.usb->with_model<mock::PeperoniModel>(std::forward<F>(f));
}
constexpr std::size_t kTwoUniverses = 5;  // row of the table: USBDMX21

TEST_CASE("a frame reaches devices of all three generations with every slot") {
  for (const int release : {0x0150, 0x0402, 0x0504}) {
    DeviceBench bench("peperoni");
    with(bench, [&](mock::PeperoniModel& model) { model.release = static_cast<std::uint16_t>(release); });
    const auto sink = bench.open_sink();
    bench.send(*sink, some_snapshot(7));
    CHECK(bench.shows(some_snapshot(7)));
    CHECK(with(bench, [](mock::PeperoniModel& model) { return model.broken_count; }) == 0);
    CHECK(with(bench, [](mock::PeperoniModel& model) { return model.start_code; }) == 0);
    CHECK(sink->link().identity() == fmt::format("firmware {:x}.{:02x}", release >> 8, release & 0xFF));
  }
}

TEST_CASE("both universes of a device with two are sent to their outputs") {
  for (const int release : {0x0402, 0x0504}) {
    DeviceBench bench("peperoni", kTwoUniverses);
    with(bench, [&](mock::PeperoniModel& model) {
      model.usb_product = 0x0004;
      model.release = static_cast<std::uint16_t>(release);
    });
    DevicePortConfig port = bench.port(0);
    port.lines = {{.line = 0, .universe = 1}, {.line = 1, .universe = 2}};
    const auto sink = DeviceSink::open(bench.plan(), port, bench.clock);
    REQUIRE(sink);
    const Bytes first = some_snapshot(1), second = some_snapshot(2);
    const FrameView frames[] = {{.universe = 1, .slots = first}, {.universe = 2, .slots = second}};
    REQUIRE((*sink)->send(0, frames));
    CHECK(bench.usb->wait_for([&](const auto& model) {
      return model.line(0).frame == testing::line_frame_of(first) &&
             model.line(1).frame == testing::line_frame_of(second);
    }));
  }
}

TEST_CASE("a second universe is refused if the firmware or the model has none, with the alternative") {
  DeviceBench bench("peperoni", kTwoUniverses);
  with(bench, [&](mock::PeperoniModel& model) { model.release = 0x0200; });
  const auto sink = DeviceSink::open(bench.plan(), bench.port(1), bench.clock);
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kUnsupported);
  CHECK(sink.error().message.find("use connector 1") != std::string::npos);
  DeviceBench single("peperoni");
  CHECK_FALSE(DeviceSink::open(single.plan(), single.port(1), single.clock));
}

TEST_CASE("a frame that found the transmitter busy is due again") {
  DeviceBench bench("peperoni");
  const auto sink = bench.open_sink();
  with(bench, [](mock::PeperoniModel& model) { model.status = 1; });
  bench.send(*sink, some_snapshot(1));
  REQUIRE(testing::poll_until(
      *sink, [&] { (void)sink->poll(0); }, [&] { return sink->counters().errors > 0; }, std::chrono::seconds(2)));
  with(bench, [](mock::PeperoniModel& model) { model.status = 0; });
  CHECK(bench.advance_until([&] { return bench.shows(some_snapshot(1), std::chrono::milliseconds(1)); }));
}

TEST_CASE("a device without acknowledgements is opened again repeatedly, and works when it answers") {
  DeviceBench bench("peperoni");
  const auto sink = bench.open_sink();
  with(bench, [](mock::PeperoniModel& model) { model.answers = false; });
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.advance_until([&] { return sink->state() == PortState::kGone; }));
  CHECK(sink->trouble().find("no answer to a frame within 100 ms") != std::string::npos);
  with(bench, [](mock::PeperoniModel& model) { model.answers = true; });
  CHECK(bench.advance_until([&] { return sink->state() == PortState::kWorking; }));
}

TEST_CASE("a late answer is not used for the next frame") {
  DeviceBench bench("peperoni");
  const auto sink = bench.open_sink();
  bench.usb->slow_down(150 * kNsPerMs);
  bench.send(*sink, some_snapshot(1));
  REQUIRE(bench.advance_until([&] { return sink->counters().errors > 0; }));
  bench.usb->slow_down(0);
  with(bench,
       [](mock::PeperoniModel& model) { model.status = 1; });  // if the late answer were used, it would mean success
  const std::uint64_t frames = sink->counters().frames;
  bench.send(*sink, some_snapshot(2));
  CHECK(bench.advance_until([&] { return sink->state() == PortState::kGone || sink->counters().errors > 2; }));
  CHECK(sink->counters().frames == frames);
}

TEST_CASE("answers in pieces and noise are counted, and no frame is lost") {
  DeviceBench bench("peperoni");
  const auto sink = bench.open_sink();
  with(bench, [](mock::PeperoniModel& model) {
    model.send_to_host(Bytes{1, 2, 3});
    model.send_to_host(Bytes(64, 0xFF));
  });
  bench.send(*sink, some_snapshot(1));
  CHECK(bench.advance_until([&] { return bench.shows(some_snapshot(1), std::chrono::milliseconds(1)); }));
  REQUIRE(bench.advance_until([&] { return sink->counters().rejected >= 2; }));
  bench.usb->limit_reads(3);
  bench.send(*sink, some_snapshot(2));
  CHECK(bench.advance_until([&] { return bench.shows(some_snapshot(2), std::chrono::milliseconds(1)); }));
}
TEST_CASE("no answer of the device stops the driver") {
  DeviceBench bench("peperoni");
  testing::check_garbage(bench);
}

TEST_CASE("after an unplug before any transfer of a frame, the frame reaches the line") {
  DeviceBench bench("peperoni");
  testing::check_unplug_at_every_transfer(bench);
}
TEST_CASE("a transfer cut short loses no frame") {
  DeviceBench bench("peperoni");
  testing::check_cut_write(bench, 531);
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
