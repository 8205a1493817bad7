// The Art-Net input as a gateway for RDM: a controller made of a bare socket on one side, modelled lines on the other.
#include "drivers/net/artnet_gateway.h"

#include <doctest/doctest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "drivers/mock/rdm_line_model.h"
#include "drivers/net/artnet_source.h"
#include "drivers/rdm/rdm_parameters.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::KeepingReceiver;
using testing::received;
using testing::send_bytes;
using testing::stranger;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kThisMachine = 0x7F00'0001;
constexpr RdmUid kConsole{0x02B0, 77};
constexpr int kWithLine = 4;  // port address; universe 5 on the wire, 1 of the show

// Shared by the line and the test.
struct Stage {
  std::mutex mutex;
  std::condition_variable changed;
  mock::RdmLineModel line = mock::example_rdm_line();
  bool busy = false;
  bool in_call = false;
  bool gone = false;

  Octets answer(std::span<const std::uint8_t> request) {
    std::unique_lock lock(mutex);
    in_call = true;
    changed.notify_all();
    changed.wait(lock, [this] { return !busy; });
    in_call = false;
    return line.answer(request);
  }
  // Waits shortly if a thread is about to call; false: no call.
  bool is_in_call() {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(10), [this] { return in_call; });
  }
  void set_busy(bool now_busy) {
    const std::lock_guard lock(mutex);
    busy = now_busy;
    changed.notify_all();
  }
};

class StageWire final : public RdmWire {
 public:
  explicit StageWire(std::shared_ptr<Stage> stage) : RdmWire({0x7FF0, 1}), stage_(std::move(stage)) {}

 private:
  Result<Octets> exchange(std::span<const std::uint8_t> request) override { return stage_->answer(request); }
  std::shared_ptr<Stage> stage_;
};

struct Bench {
  Bench() {
    put_line();
    ArtnetSourceOptions options;
    options.name = "artnet:test-in";
    options.universes = {{5, 1}, {6, 2}};
    options.kernel_stamps = false;
    options.request_names = false;
    options.rdm_directory = directory;
    auto made = ArtnetSource::create(options);
    REQUIRE_MESSAGE(made, (made ? "" : made.error().message));
    source = std::move(*made);
    console = stranger(0x7F00'0009, 0);
    REQUIRE(console);
  }
  // Replaces the device with one that uses `stage`.
  void put_line() {
    directory->put(
        1, [on = stage] { return std::make_unique<StageWire>(on); }, [on = stage] { return on->gone; });
  }
  void send(const ArtnetRdmPacket& packet) {
    REQUIRE(send_bytes(console, kThisMachine, kArtnetPort, build_artnet_rdm_packet(packet)));
  }
  // The packets for the console, after at least one has come.
  std::vector<ArtnetRdmPacket> receive() {
    std::vector<ArtnetRdmPacket> packets;
    const TimeNs deadline_ns = testing::real_now_ns() + 10 * kNsPerS;
    while (packets.empty()) {
      REQUIRE(testing::real_now_ns() < deadline_ns);
      pollfd waiting = {source->poll_fd(), POLLIN, 0};
      (void)::poll(&waiting, 1, 100);
      REQUIRE(source->poll(kStartNs, receiver).has_value());
      for (const auto& bytes : received(console)) {
        const auto packet = parse_artnet_rdm_packet(bytes);
        if (packet) packets.push_back(*packet);
      }
    }
    return packets;
  }
  ArtnetRdm request_of(std::uint64_t uid, RdmCommand command, std::uint16_t parameter, Octets data = {}) {
    RdmMessage message;
    message.to = RdmUid::of_number(uid);
    message.from = kConsole;
    message.transaction = ++transaction;
    message.command = command;
    message.parameter = parameter;
    message.data = std::move(data);
    return {kWithLine, build_rdm(message)};
  }

  std::shared_ptr<Stage> stage = std::make_shared<Stage>();
  std::shared_ptr<RdmDirectory> directory = std::make_shared<RdmDirectory>();
  std::unique_ptr<ArtnetSource> source;
  Fd console;
  KeepingReceiver receiver;
  std::uint8_t transaction = 0;
};

}  // namespace

TEST_CASE("a gateway searches its line at the first request for the table, and answers later requests at once") {
  if (!enter_private_network()) return;
  Bench bench;
  for (int round = 0; round < 2; ++round) {
    bench.send(ArtnetTodRequest{{kWithLine}});
    const auto packets = bench.receive();
    REQUIRE(packets.size() == 1);
    const auto& data = std::get<ArtnetTodData>(packets[0]);
    CHECK(data.port_address == kWithLine);
    CHECK(data.bind_index == 1);
    CHECK(data.port == 1);
    CHECK(data.total == 3);
    REQUIRE(data.uids.size() == 3);
    CHECK(data.uids[2] == RdmUid{0x7FF0, 0x0001'0000});
  }
  const std::lock_guard lock(bench.stage->mutex);
  CHECK(bench.stage->line.responders[0].request_count < 200);  // searched once
}

TEST_CASE("a flush searches the line again") {
  if (!enter_private_network()) return;
  Bench bench;
  bench.send(ArtnetTodRequest{{kWithLine}});
  CHECK(std::get<ArtnetTodData>(bench.receive()[0]).total == 3);
  {
    const std::lock_guard lock(bench.stage->mutex);
    bench.stage->line.responders.emplace_back().uid = 0x02B0'0000'0009;
  }
  bench.send(ArtnetTodControl{kWithLine, true});
  CHECK(std::get<ArtnetTodData>(bench.receive()[0]).total == 4);
}

TEST_CASE("a message goes to the line, and its answer unchanged to the requester") {
  if (!enter_private_network()) return;
  Bench bench;
  bench.send(bench.request_of(0x7FF0'0000'0002, RdmCommand::kGet, kRdmDeviceLabel));
  auto packets = bench.receive();
  REQUIRE(packets.size() == 1);
  const auto& rdm = std::get<ArtnetRdm>(packets[0]);
  CHECK(rdm.port_address == kWithLine);
  const auto answer = parse_rdm(rdm.message);
  REQUIRE(answer.has_value());
  CHECK(answer->to == kConsole);
  CHECK(answer->from == RdmUid{0x7FF0, 2});
  CHECK(answer->transaction == bench.transaction);
  CHECK(rdm_text(answer->data) == "Spot stage left");
  bench.send(bench.request_of(0x7FF0'0000'0002, RdmCommand::kSet, kRdmDmxStartAddress, {1, 0}));
  packets = bench.receive();
  CHECK(parse_rdm(std::get<ArtnetRdm>(packets[0]).message)->command == RdmCommand::kSetResponse);
  const std::lock_guard lock(bench.stage->mutex);
  CHECK(bench.stage->line.responders[1].start_address == 256);
}

TEST_CASE("frames continue while the line is busy") {
  if (!enter_private_network()) return;
  Bench bench;
  bench.stage->set_busy(true);
  bench.send(bench.request_of(0x7FF0'0000'0001, RdmCommand::kGet, kRdmDeviceLabel));
  REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
  const Octets slots(16, 9);
  ArtnetDmx dmx;
  dmx.port_address = kWithLine;
  dmx.slots = slots;
  Octets packet(kArtnetDmxBytesMax);
  packet.resize(build_artnet_dmx(dmx, packet));
  REQUIRE(send_bytes(bench.console, kThisMachine, kArtnetPort, packet));
  REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
  CHECK(bench.receiver.frames.size() == 1);
  CHECK(received(bench.console).empty());
  bench.stage->set_busy(false);
  CHECK(std::holds_alternative<ArtnetRdm>(bench.receive()[0]));
}

TEST_CASE("the gateway still answers after a device was replaced 70 times while requests waited") {
  if (!enter_private_network()) return;
  Bench bench;
  for (int i = 0; i < 70; ++i) {
    bench.stage->set_busy(true);
    bench.send(bench.request_of(0x7FF0'0000'0001, RdmCommand::kGet, kRdmDeviceLabel));
    REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
    REQUIRE(bench.stage->is_in_call());
    const auto old = std::exchange(bench.stage, std::make_shared<Stage>());
    bench.put_line();
    // The next request makes the gateway use the new line, while the call of the old one still runs.
    bench.send(ArtnetTodRequest{{kWithLine}});
    const auto table = bench.receive();
    CHECK(std::holds_alternative<ArtnetTodData>(table.at(0)));
    CHECK(old->is_in_call());  // the gateway has not waited for it
    old->set_busy(false);
  }
  bench.send(bench.request_of(0x7FF0'0000'0001, RdmCommand::kGet, kRdmDeviceLabel));
  const auto packets = bench.receive();
  REQUIRE(packets.size() == 1);
  CHECK(std::holds_alternative<ArtnetRdm>(packets[0]));
}

TEST_CASE("a controller that waits for the table of a replaced device gets that of the next one") {
  if (!enter_private_network()) return;
  Bench bench;
  bench.stage->set_busy(true);
  bench.send(ArtnetTodRequest{{kWithLine}});
  REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
  const auto old = std::exchange(bench.stage, std::make_shared<Stage>());
  bench.put_line();
  bench.send(ArtnetTodRequest{{kWithLine}});  // a controller repeats the request
  CHECK(std::get<ArtnetTodData>(bench.receive().at(0)).total == 3);
  old->set_busy(false);
}

TEST_CASE("only universes with a line report RDM, and only those answer") {
  if (!enter_private_network()) return;
  Bench bench;
  const auto has_rdm = [&] {
    Octets poll(kArtnetPollBytesMin);
    build_artnet_poll(0, poll);
    REQUIRE(send_bytes(bench.console, kThisMachine, kArtnetPort, poll));
    REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
    REQUIRE(bench.source->poll(kStartNs + kNsPerS, bench.receiver).has_value());
    std::vector<bool> rdm;
    for (const auto& bytes : received(bench.console)) {
      rdm.push_back(std::get<ArtnetPollReply>(parse_artnet(bytes).value()).rdm);
    }
    return rdm;
  };
  CHECK(has_rdm() == std::vector<bool>{true, false});
  bench.send(ArtnetTodRequest{{5, 6}});
  bench.send(ArtnetTodControl{5, true});
  REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
  CHECK(received(bench.console).empty());
  bench.stage->gone = true;
  CHECK(has_rdm() == std::vector<bool>{false, false});
  bench.send(ArtnetTodRequest{{kWithLine}});
  bench.send(bench.request_of(0x7FF0'0000'0001, RdmCommand::kGet, kRdmDeviceLabel));
  REQUIRE(testing::drain(*bench.source, kStartNs, bench.receiver));
  CHECK(received(bench.console).empty());
}

}  // namespace footlight::drivers
