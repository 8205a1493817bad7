// The driver with the model in this process. Time stands still unless a test moves it.
#include "drivers/mock/dmxcreator_model.h"
#include "tests/support/device_bench.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::DmxCreatorModel;
using testing::DeviceBench;
using testing::some_snapshot;

TEST_SUITE_BEGIN("dmxcreator");

TEST_CASE("the model takes an announcement and its halves, and nothing else") {
  DmxCreatorModel model;
  model.power_on();
  const Bytes half(256, 7);
  model.data_out(0x02, half);  // without an announcement
  CHECK(model.broken_count == 1);
  model.data_out(0x01, Bytes{0x80, 0x01, 0x00, 0x00, 0x00, 0x01});
  model.data_out(0x02, half);
  CHECK(model.line(0).frame_count == 1);
  model.data_out(0x01, Bytes{0x80, 0x01, 0x00, 0x00, 0x00, 0x02});
  model.data_out(0x02, half);
  model.data_out(0x01, Bytes{0x80, 0x01, 0x00, 0x00, 0x00, 0x02});
  CHECK(model.cut_count == 1);
  CHECK(model.line(0).frame_count == 1);
}

TEST_CASE("a frame is sent as the announcement of 512 slots and two halves, and reaches the line with every slot") {
  DeviceBench bench("dmxcreator");
  const auto sink = bench.open_sink();
  bench.send(*sink, some_snapshot(7));
  CHECK(bench.shows(some_snapshot(7)));
  bench.usb->with_model<DmxCreatorModel>([](DmxCreatorModel& model) {
    CHECK(model.broken_count == 0);
    CHECK(model.cut_count == 0);
    CHECK(model.line(0).frame_count == 1);
  });
}

TEST_CASE("after an unplug before any transfer of a frame, the frame reaches the line") {
  DeviceBench bench("dmxcreator");
  testing::check_unplug_at_every_transfer(bench);
}
TEST_CASE("a transfer cut short at any byte loses no frame, and halves of two frames never mix") {
  DeviceBench bench("dmxcreator");
  std::vector<Bytes> frames;
  bench.usb->with_model(
      [&](auto& model) { model.on_frame = [&](int, const Bytes& frame) { frames.push_back(frame); }; });
  testing::check_cut_write(bench, 255);
  for (const Bytes& frame : frames) {
    const Bytes slots(frame.begin() + 1, frame.end());
    REQUIRE(slots == some_snapshot(slots[0]));
  }
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
