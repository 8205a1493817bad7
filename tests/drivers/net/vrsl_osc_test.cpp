// The OSC feed of VRSL's grid node, over real sockets in a network namespace with only "lo".
#include "drivers/net/vrsl_osc.h"

#include <doctest/doctest.h>

#include <map>
#include <string>

#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::frame_of;
using testing::KeepingReceiver;
using testing::must;
using testing::poll_until;
using testing::received;
using testing::receives_nothing;
using testing::send_bytes;
using testing::stranger;
using testing::test_levels;
using testing::universes_from;
using Bytes = std::vector<std::uint8_t>;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kHere = 0x7F00'0001;

Bytes message(const std::string& address, std::vector<std::int32_t> numbers) {
  Bytes out(128);
  out.resize(build_osc(address, numbers, out));
  return out;
}

std::optional<VrslCell> cell_of(const std::string& address, std::vector<std::int32_t> numbers) {
  const Bytes packet = message(address, std::move(numbers));
  std::vector<OscMessage> messages;
  REQUIRE(parse_osc(packet, messages).has_value());
  return vrsl_cell_of(messages.at(0));
}

std::unique_ptr<VrslOscSource> open_source(int count = 9) {
  VrslOscSourceOptions options;
  options.name = "vrsl-osc:test-in";
  options.universes = universes_from(1, count, 1);
  options.kernel_stamps = false;
  return must(VrslOscSource::create(options));
}

std::unique_ptr<VrslOscSink> open_sink(int count) {
  VrslOscSinkOptions options;
  options.name = "vrsl-osc:test-out";
  options.universes = universes_from(1, count, 1);
  return must(VrslOscSink::create(options));
}

// Sends what waits in the sink, 5 ms of its clock after each other. Returns the messages by their channel.
std::map<int, std::vector<int>> sent_by(VrslOscSink& sink, const Fd& to, TimeNs& now_ns) {
  std::map<int, std::vector<int>> cells;
  const auto take = [&] {
    for (const Bytes& bytes : received(to)) {
      std::vector<OscMessage> messages;
      REQUIRE(parse_osc(bytes, messages).has_value());
      const auto cell = vrsl_cell_of(messages.at(0));
      REQUIRE(cell.has_value());
      cells[cell->channel] = std::vector<int>(cell->levels.begin(), cell->levels.begin() + cell->level_count);
    }
  };
  take();
  while (sink.next_deadline_ns() != kTimeNever) {
    now_ns = sink.next_deadline_ns();
    REQUIRE(sink.poll(now_ns).has_value());
    take();
  }
  return cells;
}

}  // namespace

TEST_CASE("a message of one level is a cell of all colours and one of three has a level for each") {
  const auto one = cell_of("/VRSL/ch521", {7});
  REQUIRE(one.has_value());
  CHECK(one->channel == 521);
  CHECK(one->level_count == 1);
  CHECK(one->levels[0] == 7);
  const auto three = cell_of("/VRSL/1560", {1, 2, 255});
  REQUIRE(three.has_value());
  CHECK(three->level_count == 3);
  CHECK(three->levels[2] == 255);
  CHECK(cell_of("/VRSL", {12, 34})->channel == 12);
  CHECK(cell_of("/VRSL/channel", {12, 1, 2, 3})->level_count == 3);
}

TEST_CASE("messages of other addresses, channels and levels are no cells") {
  CHECK_FALSE(cell_of("/VRSL/ch0", {1}));
  CHECK_FALSE(cell_of("/VRSL/ch1561", {1}));
  CHECK_FALSE(cell_of("/VRSL/ch99999999999999999999", {1}));
  CHECK_FALSE(cell_of("/VRSL/ch1", {256}));
  CHECK_FALSE(cell_of("/VRSL/ch1", {-1}));
  CHECK_FALSE(cell_of("/VRSL/ch1", {1, 2}));
  CHECK_FALSE(cell_of("/VRSL/ch1", {}));
  CHECK_FALSE(cell_of("/VRSL", {}));
  CHECK_FALSE(cell_of("/VRSLX/ch1", {1}));
  CHECK_FALSE(cell_of("/other/ch1", {1}));
  CHECK_FALSE(cell_of("/VRSL/Command/Set1", {1}));
}

TEST_CASE("nine universes cross from the sink to the source, every level exact") {
  if (!enter_private_network()) return;
  auto source = open_source();
  auto sink = open_sink(9);
  KeepingReceiver receiver;
  std::map<int, Bytes> got;
  TimeNs now_ns = kStartNs;
  for (int round = 0; round < 2; ++round) {
    std::vector<Bytes> levels;
    std::vector<FrameView> frames;
    for (int u = 1; u <= 9; ++u) levels.push_back(test_levels(u, round));
    for (int u = 1; u <= 9; ++u) frames.push_back(frame_of(u, levels[static_cast<std::size_t>(u - 1)]));
    REQUIRE(sink->send(now_ns, frames).has_value());
    const bool all = poll_until(*source, now_ns, receiver, [&] {
      for (const auto& frame : receiver.frames) got[frame.view.universe] = frame.slots;
      receiver.frames.clear();
      bool equal = true;
      for (int u = 1; u <= 9; ++u) equal = equal && got[u] == levels[static_cast<std::size_t>(u - 1)];
      if (!equal && sink->next_deadline_ns() != kTimeNever) {
        now_ns = sink->next_deadline_ns();
        REQUIRE(sink->poll(now_ns).has_value());
      }
      return equal;
    });
    CHECK(all);
    now_ns += kNsPerS;
  }
  CHECK(source->counters().rejected == 0);
}

TEST_CASE("only channels that changed are sent, at most 128 at once, and all after a request") {
  if (!enter_private_network()) return;
  const Fd receiver = stranger(kHere, kVrslOscPort);
  auto sink = open_sink(3);
  TimeNs now_ns = kStartNs;
  Bytes levels = test_levels(2, 0);
  REQUIRE(sink->send(now_ns, std::vector{frame_of(2, levels)}).has_value());
  CHECK(sink->counters().frames == 128);
  CHECK(sent_by(*sink, receiver, now_ns).size() == 512);
  REQUIRE(sink->send(now_ns, std::vector{frame_of(2, levels)}).has_value());
  CHECK(sent_by(*sink, receiver, now_ns).empty());
  levels[9] ^= 0x55;
  levels[511] ^= 0x55;
  now_ns += kNsPerS;
  REQUIRE(sink->send(now_ns, std::vector{frame_of(2, levels)}).has_value());
  CHECK(sent_by(*sink, receiver, now_ns) ==
        std::map<int, std::vector<int>>{{520 + 10, {levels[9]}}, {520 + 512, {levels[511]}}});
  now_ns += kNsPerS;
  REQUIRE(send_bytes(receiver, kHere, kVrslOscPort - 1, message(std::string(kVrslOscRefresh), {0})));
  REQUIRE(sink->poll(now_ns).has_value());
  CHECK(sink->refreshes() == 1);
  CHECK(sent_by(*sink, receiver, now_ns).size() == 512);
}

TEST_CASE("a sink with a universe above 3 sends three levels in a message") {
  if (!enter_private_network()) return;
  const Fd receiver = stranger(kHere, kVrslOscPort);
  auto sink = open_sink(4);
  TimeNs now_ns = kStartNs;
  const Bytes first = {11}, fourth = {44};
  REQUIRE(sink->send(now_ns, std::vector{frame_of(1, first), frame_of(4, fourth)}).has_value());
  CHECK(sent_by(*sink, receiver, now_ns).at(1) == std::vector<int>{11, 44, 0});
}

TEST_CASE("a source asks this machine for all levels when it opens, and a sender when it first sends") {
  if (!enter_private_network()) return;
  const Fd node = stranger(0, kVrslOscPort - 1);
  auto source = open_source();
  const Bytes request = message(std::string(kVrslOscRefresh), {0});
  CHECK(received(node) == std::vector<Bytes>{request});
  const Fd other = stranger(0x7F00'0009, 30'000);
  KeepingReceiver receiver;
  REQUIRE(send_bytes(other, kHere, kVrslOscPort, message("/VRSL/ch1", {1})));
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return !receiver.frames.empty(); }));
  CHECK(received(node) == std::vector<Bytes>{request});
  REQUIRE(send_bytes(other, kHere, kVrslOscPort, message("/VRSL/ch1", {2})));
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() == 2; }));
  CHECK(received(node).empty());
}

TEST_CASE("damaged packets and cells between universes change no level and are counted") {
  if (!enter_private_network()) return;
  auto source = open_source(3);
  const Fd from = stranger(kHere, 30'000);
  KeepingReceiver receiver;
  Bytes damaged = message("/VRSL/ch1", {1});
  damaged.pop_back();
  REQUIRE(send_bytes(from, kHere, kVrslOscPort, damaged));
  REQUIRE(send_bytes(from, kHere, kVrslOscPort, message("/VRSL/ch513", {1})));  // a cell without a slot
  REQUIRE(send_bytes(from, kHere, kVrslOscPort, message("/VRSL/Command/Stop", {})));
  CHECK(receives_nothing(*source, kStartNs, receiver));
  CHECK(source->counters().rejected == 1);
  CHECK(source->other_messages() == 2);
  REQUIRE(send_bytes(from, kHere, kVrslOscPort, message("/VRSL/ch521", {9})));
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return !receiver.frames.empty(); }));
  CHECK(receiver.frames[0].view.universe == 2);
  CHECK(receiver.frames[0].slots[0] == 9);
}

TEST_CASE("a universe above 9 and an interface are refused with the next step") {
  VrslOscSinkOptions options;
  options.name = "vrsl-osc:10";
  options.universes = universes_from(10, 1, 1);
  CHECK(VrslOscSink::create(options).error().message.find("from 1 to 9") != std::string::npos);
  options.universes = universes_from(1, 1, 1);
  options.interface_names = {"lo"};
  CHECK(VrslOscSink::create(options).error().message.find("leave out") != std::string::npos);
}

}  // namespace footlight::drivers
