// Tests of the drivers of serial devices with their own protocols, and of their parsers.
#include <doctest/doctest.h>

#include <numeric>
#include <random>

#include "drivers/device/device.h"
#include "drivers/mock/dmx4all_model.h"
#include "drivers/mock/eurolite_model.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/mock/vince_model.h"
#include "drivers/transport/tty_marks.h"
#include "drivers/widgets/vince_frame.h"
#include "tests/support/usb_port_test.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::Bytes;
using mock::MockUsb;

struct Bench {
  explicit Bench(std::string_view id)
      : driver(*find_driver(id)), usb(std::make_shared<MockUsb>(driver.make_model(), fmt::format("mock:{}", id))) {}
  Result<std::unique_ptr<DeviceSink>> open() {
    auto widget = driver.make_widget({.scheme = std::string(driver.id), .universes = {1}}, {});
    REQUIRE(widget);
    return DeviceSink::open({.widget = std::move(*widget), .opener = mock::make_mock_opener(usb, clock)},
                            {.name = std::string(driver.id), .lines = {{.line = 0, .universe = 1}}}, clock);
  }
  void send(Sink& sink, const Bytes& slots) {
    const FrameView frame{.universe = 1, .slots = slots};
    REQUIRE(sink.send(clock.now_ns(), {&frame, 1}));
  }
  const DriverInfo& driver;
  testing::SharedFakeClock clock;
  std::shared_ptr<MockUsb> usb;
};

TEST_SUITE_BEGIN("serial_drivers");

TEST_CASE("a CDC-ACM model describes its interfaces as Linux requires, and answers only at its data endpoint") {
  mock::Dmx4allModel model;
  const Bytes config = model.config_descriptor();
  CHECK(config.size() == (config[2] | config[3] << 8));
  int unions = 0;
  for (std::size_t at = 0; at < config.size(); at += config[at]) {
    REQUIRE(config[at] >= 2);
    constexpr std::uint8_t kClassInterface = 0x24, kUnion = 0x06;
    if (config[at + 1] == kClassInterface && config[at + 2] == kUnion) ++unions;
  }
  CHECK(unions == 1);
  model.power_on();
  model.send_to_host(Bytes{'G'});
  CHECK_FALSE(model.has_data(0x83));
  CHECK(model.has_data(0x81));
}

TEST_CASE("a DMX4ALL interface is set to 512 slots, and gets only changed slots") {
  Bench bench("dmx4all");
  auto sink = bench.open();
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  CHECK(bench.usb->with_model<mock::Dmx4allModel>([](auto& model) { return model.slot_count; }) == 512);
  Bytes slots(512);
  std::iota(slots.begin(), slots.end(), std::uint8_t{0});
  bench.send(**sink, slots);
  const auto shows = [&] {
    return bench.usb->wait_for([&](const mock::UsbModel& model) {
      return std::equal(slots.begin(), slots.end(), model.line(0).frame.begin() + 1, model.line(0).frame.end());
    });
  };
  REQUIRE(shows());
  const auto commands = [&] {
    return bench.usb->with_model<mock::Dmx4allModel>([](auto& model) { return model.command_count; });
  };
  CHECK(commands() == 2 + 512);
  slots[0] = 200;
  slots[255] = 201;
  slots[256] = 202;
  slots[511] = 203;
  bench.send(**sink, slots);
  REQUIRE(shows());
  CHECK(commands() == 2 + 512 + 4);
  CHECK((*sink)->counters().rejected == 0);
}

TEST_CASE("a device that does not answer G is not accepted as a DMX4ALL interface") {
  Bench bench("dmx4all");
  bench.usb->with_model<mock::Dmx4allModel>([](auto& model) { model.answers = false; });
  bench.usb->move_clock({});
  const auto sink = bench.open();
  REQUIRE_FALSE(sink);
  CHECK(sink.error().code == ErrorCode::kTimeout);
  CHECK(sink.error().message.find("\"C?\"") != std::string::npos);
  CHECK_FALSE(bench.usb->claimed());
}

TEST_CASE("an update that a Vince converter refuses is counted and sent again") {
  Bench bench("vince");
  auto sink = bench.open();
  REQUIRE_MESSAGE(sink, (sink ? "" : sink.error().message));
  CHECK(bench.usb->with_model<mock::VinceModel>([](auto& model) { return model.started; }));
  bench.usb->with_model<mock::VinceModel>([](auto& model) { model.status = 0x10; });
  bench.send(**sink, Bytes(512, 7));
  CHECK(testing::poll_until(
      **sink, [] {}, [&] { return (*sink)->counters().rejected > 0; }, std::chrono::seconds(10)));
  bench.usb->with_model<mock::VinceModel>([](auto& model) { model.status = 0; });
  Bytes expected(513, 7);
  expected[0] = 0;
  bool shown = false;
  for (int i = 0; i < 1'000 && !shown; ++i) {
    bench.clock.advance_ns(50 * kNsPerMs);
    bench.usb->clock_moved();
    shown = bench.usb->wait_for([&](const mock::UsbModel& model) { return model.line(0).frame == expected; },
                                std::chrono::milliseconds(20));
  }
  CHECK(shown);
}

TEST_CASE("an update for a Vince converter has its length, its gap and its end") {
  Slots snapshot{};
  snapshot[0] = 1;
  snapshot[511] = 2;
  const auto message = encode_vince_update(snapshot);
  REQUIRE(message.size() == 520);
  const Bytes head(message.begin(), message.begin() + 8);
  CHECK(head == Bytes{0x0F, 0x0F, 0x11, 0x02, 0x02, 0, 0, 1});
  CHECK(message[518] == 2);
  CHECK(message[519] == 0x04);
}

TEST_CASE("replies of a Vince converter are found for any division of the stream and any noise between them") {
  const Bytes reply{0x0F, 0x0F, 0x11, 0x00, 0x00, 0x00, 0x04};
  const Bytes with_data{0x0F, 0x0F, 0x02, 0x01, 0x00, 0x02, 0x0F, 0x0F, 0x04};
  std::mt19937 random(3);
  for (int run = 0; run < 300; ++run) {
    Bytes stream;
    std::size_t wanted = 0;
    for (int i = 0; i < 20; ++i) {
      for (unsigned long n = random() % 5; n > 0; --n)
        stream.push_back(static_cast<std::uint8_t>(0x20 + random() % 200));
      const Bytes& one = random() % 2 == 0 ? reply : with_data;
      stream.insert(stream.end(), one.begin(), one.end());
      ++wanted;
    }
    VinceReplyParser parser;
    std::size_t found = 0;
    for (std::span<const std::uint8_t> rest(stream); !rest.empty();) {
      const std::size_t size = std::min<std::size_t>(1 + random() % 9, rest.size());
      std::span<const std::uint8_t> piece = rest.first(size);
      rest = rest.subspan(size);
      VinceReply got;
      while (parser.next(piece, got)) ++found;
    }
    CHECK(found == wanted);
  }
}

TEST_CASE("the line marks of a tty are decoded for any division of the stream") {
  const Bytes marks{1, 0xFF, 0, 0, 0, 2, 0xFF, 0xFF, 0xFF, 0, 9, 3, 0xFF, 0, 0};
  for (std::size_t cut = 0; cut <= marks.size(); ++cut) {
    TtyMarkParser parser;
    std::vector<LineByte> bytes;
    parser.take(std::span(marks).first(cut), 1, bytes);
    parser.take(std::span(marks).subspan(cut), 1, bytes);
    REQUIRE(bytes.size() == 8);
    CHECK(bytes[0].value == 1);
    CHECK(bytes[1].is_break);
    CHECK(bytes[2].value == 0);
    CHECK_FALSE(bytes[2].is_break);
    CHECK(bytes[3].value == 2);
    CHECK(bytes[4].value == 0xFF);
    CHECK_FALSE(bytes[4].framing_error);
    CHECK(bytes[5].framing_error);
    CHECK(bytes[6].value == 3);
    CHECK(bytes[7].is_break);
  }
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
