// Several listeners on one UDP port of one machine: inputs of one program, and several programs.
#include "drivers/net/port_holders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/artnet_sink.h"
#include "drivers/net/artnet_source.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_port.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::drain;
using testing::enter_private_network;
using testing::KeepingReceiver;
using testing::must;
using testing::send_bytes;
using testing::stranger;
using testing::universes_from;
using Bytes = std::vector<std::uint8_t>;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kThisMachine = 0x7F00'0001;
constexpr std::uint32_t kEverybodyHere = 0x7FFF'FFFF;
constexpr int kSenders = 64;  // each with its own address and UDP port, so with different hashes

ArtnetSourceOptions artnet_options(int first_universe, int count = 1) {
  ArtnetSourceOptions options;
  options.name = "artnet:test";
  options.universes = universes_from(first_universe, count, first_universe);
  options.kernel_stamps = false;
  options.request_names = false;
  return options;
}

SacnSourceOptions sacn_options(int universe) {
  SacnSourceOptions options;
  options.name = "sacn:test";
  options.universes = universes_from(universe, 1, universe);
  options.interface_names = {"lo"};
  options.kernel_stamps = false;
  return options;
}

void send_artnet(int universe, std::uint32_t to = kThisMachine) {
  const Bytes slots(4, 7);
  ArtnetDmx dmx;
  dmx.port_address = artnet_port_address(universe);
  dmx.slots = slots;
  Bytes packet(kArtnetDmxBytesMax);
  packet.resize(build_artnet_dmx(dmx, packet));
  for (std::uint32_t i = 0; i < kSenders; ++i) {
    REQUIRE(send_bytes(stranger(kThisMachine + 1 + i, 0), to, kArtnetPort, packet));
  }
}

void send_sacn(int universe, std::uint32_t to = kThisMachine, std::uint8_t sequence = 0) {
  const Bytes slots(4, 7);
  SacnData data;
  data.universe = universe;
  data.sequence = sequence;
  data.slots = slots;
  for (int i = 0; i < kSenders; ++i) {
    data.cid.fill(static_cast<std::uint8_t>(i + 1));
    std::array<std::uint8_t, kSacnDataBytesMax> packet;
    const std::size_t size = build_sacn_data(data, packet);
    REQUIRE(send_bytes(must(open_sender({"test", is_multicast(to) ? 1 : 0})), to, kSacnPort,
                       std::span(packet).first(size)));
  }
}

// Processor time of this thread, which does not grow while other threads run.
TimeNs processor_ns() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

// The number of frames that the source has now.
int count_frames(Source& source) {
  KeepingReceiver receiver;
  REQUIRE(drain(source, kStartNs, receiver));
  return static_cast<int>(receiver.frames.size());
}

// Another process with this source, in the network of the test. It answers each line with the number of frames received
// since.
class OtherProgram {
 public:
  explicit OtherProgram(const std::function<Result<std::unique_ptr<Source>>()>& open) {
    int to_it[2], from_it[2];
    REQUIRE(pipe(to_it) == 0);
    REQUIRE(pipe(from_it) == 0);
    pid_ = fork();
    REQUIRE(pid_ >= 0);
    if (pid_ == 0) {
      close(to_it[1]);
      const auto source = open();
      int count = source ? 0 : -1;
      char line = 0;
      do {
        if (write(from_it[1], &count, sizeof count) != sizeof count || count < 0) break;
        if (read(to_it[0], &line, 1) != 1) break;
        KeepingReceiver receiver;
        count = drain(**source, kStartNs, receiver) ? static_cast<int>(receiver.frames.size()) : -1;
      } while (true);
      _exit(0);
    }
    close(to_it[0]);
    close(from_it[1]);
    to_ = Fd(to_it[1]);
    from_ = Fd(from_it[0]);
    REQUIRE(answer() == 0);
  }
  ~OtherProgram() {
    to_.reset();
    waitpid(pid_, nullptr, 0);
  }
  OtherProgram(const OtherProgram&) = delete;
  OtherProgram& operator=(const OtherProgram&) = delete;

  int count() {
    REQUIRE(write(to_.get(), "\n", 1) == 1);
    return answer();
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  int answer() {
    int count = -1;
    REQUIRE(read(from_.get(), &count, sizeof count) == sizeof count);
    return count;
  }
  pid_t pid_ = -1;
  Fd to_, from_;
};

}  // namespace

TEST_CASE("two Art-Net inputs of one program each get every unicast frame of their universe") {
  if (!enter_private_network()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto options = artnet_options(1);
  options.own_senders = program;
  auto first = must(ArtnetSource::create(options));
  options.universes = universes_from(2, 1, 2);
  auto second = must(ArtnetSource::create(options));
  send_artnet(1);
  send_artnet(2);
  send_artnet(2, kEverybodyHere);
  CHECK(count_frames(*first) == kSenders);
  CHECK(count_frames(*second) == 2 * kSenders);
  send_artnet(2);
  first.reset();  // like a reload: datagrams that it has not read are passed to the other
  CHECK(count_frames(*second) == kSenders);
  send_artnet(2);
  CHECK(count_frames(*second) == kSenders);
  CHECK(second->counters().dropped == 0);
}

TEST_CASE("two inputs of one program get all unicast frames also if one is bound to that address only") {
  if (!enter_private_network()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto options = artnet_options(1);
  options.own_senders = program;
  auto any = must(ArtnetSource::create(options));
  options.addresses = {"127.0.0.1"};
  options.universes = universes_from(2, 1, 2);
  auto one = must(ArtnetSource::create(options));
  send_artnet(1);
  send_artnet(2);
  send_artnet(2, 0x7F00'0002);  // another address of this machine
  (void)count_frames(*one);
  CHECK(count_frames(*any) == kSenders);
  CHECK(one->counters().frames == kSenders);
}

TEST_CASE("two sACN inputs of one program each get every unicast frame of their universe") {
  if (!enter_private_network()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto options = sacn_options(1);
  options.own_senders = program;
  const auto first = must(SacnSource::create(options));
  options.universes = universes_from(2, 1, 2);
  const auto second = must(SacnSource::create(options));
  send_sacn(1);
  send_sacn(2);
  CHECK(count_frames(*first) == kSenders);
  CHECK(count_frames(*second) == kSenders);
}

TEST_CASE("a yielding listener takes no unicast frame from another one, whichever came first") {
  if (!enter_private_network()) return;
  for (const bool yielding_first : {false, true}) {
    CAPTURE(yielding_first);
    auto watching = artnet_options(1);
    watching.yields = true;
    std::unique_ptr<ArtnetSource> bridge, monitor;
    if (yielding_first) monitor = must(ArtnetSource::create(watching));
    bridge = must(ArtnetSource::create(artnet_options(1)));
    if (!yielding_first) monitor = must(ArtnetSource::create(watching));
    send_artnet(1);
    CHECK(count_frames(*bridge) == kSenders);
    CHECK(count_frames(*monitor) == 0);
    send_artnet(1, kEverybodyHere);
    CHECK(count_frames(*bridge) == kSenders);
    CHECK(count_frames(*monitor) == kSenders);
    bridge.reset();
    send_artnet(1);
    CHECK(count_frames(*monitor) == kSenders);
  }
}

TEST_CASE("an Art-Net output with addresses takes no unicast frame from a listener, whichever came first") {
  if (!enter_private_network()) return;
  ArtnetSinkOptions sending;
  sending.name = "artnet:test";
  sending.universes = universes_from(1, 1, 1);
  sending.addresses = {"127.0.0.9"};
  for (const bool yields : {false, true}) {
    for (const bool output_first : {false, true}) {
      CAPTURE(yields);
      CAPTURE(output_first);
      auto listening = artnet_options(1);
      listening.yields = yields;
      std::unique_ptr<ArtnetSink> output;
      if (output_first) output = must(ArtnetSink::create(sending));
      const auto listener = must(ArtnetSource::create(listening));
      if (!output_first) output = must(ArtnetSink::create(sending));
      send_artnet(1);
      CHECK(count_frames(*listener) == kSenders);
    }
  }
}

TEST_CASE("a yielding listener gets sACN multicast beside another one, and unicast only of its addresses") {
  if (!enter_private_network()) return;
  auto watching = sacn_options(1);
  watching.yields = true;
  auto monitor = must(SacnSource::create(watching));
  {
    const auto bridge = must(SacnSource::create(sacn_options(1)));
    send_sacn(1, sacn_group_ipv4(1));
    CHECK(count_frames(*bridge) == kSenders);
    CHECK(count_frames(*monitor) == kSenders);
  }
  watching.addresses = {"127.0.0.1"};
  watching.interface_names.clear();
  monitor.reset();
  monitor = must(SacnSource::create(watching));
  send_sacn(1, 0x7F00'0002);
  CHECK(count_frames(*monitor) == 0);
  send_sacn(1);
  CHECK(count_frames(*monitor) == kSenders);
}

TEST_CASE("a yielding listener receives universes beyond the 20 groups of its first socket") {
  if (!enter_private_network()) return;
  auto watching = sacn_options(1);
  watching.universes = universes_from(1, 45, 1);
  watching.yields = true;
  const auto monitor = must(SacnSource::create(watching));
  const auto bridge = must(SacnSource::create(sacn_options(45)));
  REQUIRE(monitor->socket_count() == 3);
  for (const int universe : {1, 21, 45}) {
    send_sacn(universe, sacn_group_ipv4(universe));
    CHECK(count_frames(*monitor) == kSenders);
  }
  CHECK(count_frames(*bridge) == kSenders);
}

TEST_CASE("the newest group is left first, so that a source of 63,999 universes closes in linear time") {
  if (!enter_private_network()) return;
  // Time for 8,000 and for 32,000 groups: a factor of four, where a searched list would give sixteen.
  const auto seconds_to_close = [](int count) {
    auto options = sacn_options(1);
    options.universes = universes_from(1, count, 1);
    auto source = must(SacnSource::create(options));
    const TimeNs begin_ns = processor_ns();
    source.reset();
    return static_cast<double>(processor_ns() - begin_ns) * 1e-9;
  };
  const double few_s = seconds_to_close(8'000);
  const double many_s = seconds_to_close(32'000);
  MESSAGE("closing 8,000 groups took " << few_s << " s of processor time, 32,000 groups " << many_s << " s");
  CHECK(many_s < 8 * few_s + 0.05);
}

TEST_CASE("of two yielding listeners the older one keeps all unicast frames") {
  if (!enter_private_network()) return;
  auto watching = artnet_options(1);
  watching.yields = true;
  auto recorder = must(ArtnetSource::create(watching));
  auto monitor = must(ArtnetSource::create(watching));
  send_artnet(1);
  CHECK(count_frames(*recorder) == kSenders);
  CHECK(count_frames(*monitor) == 0);
  recorder.reset();
  send_artnet(1);
  CHECK(count_frames(*monitor) == kSenders);
}

TEST_CASE("a second bridge leaves unicast frames to the first one, and names the program that gets them") {
  if (!enter_private_network()) return;
  OtherProgram bridge([]() -> Result<std::unique_ptr<Source>> { return make_artnet_source(artnet_options(1)); });
  auto second = must(ArtnetSource::create(artnet_options(1)));
  send_artnet(1);
  CHECK(bridge.count() == kSenders);
  CHECK(count_frames(*second) == 0);
  send_artnet(1, kEverybodyHere);
  CHECK(bridge.count() == kSenders);
  CHECK(count_frames(*second) == kSenders);
  const auto notice = second->take_notice();
  REQUIRE(notice.has_value());
  CHECK(notice->level == NoticeLevel::kWarning);
  CHECK(notice->id == "port-shared");
  CAPTURE(notice->text);
  CHECK(notice->text.find("(process " + std::to_string(bridge.pid()) + ")") != std::string::npos);
  CHECK(notice->text.find("UDP port 6454") != std::string::npos);
  CHECK_FALSE(second->take_notice().has_value());
}

TEST_CASE("a second bridge does not take unicast sACN from the first one, and both get multicast") {
  if (!enter_private_network()) return;
  OtherProgram bridge([]() -> Result<std::unique_ptr<Source>> { return make_sacn_source(sacn_options(1)); });
  const auto second = must(SacnSource::create(sacn_options(1)));
  send_sacn(1);
  CHECK(bridge.count() == kSenders);
  CHECK(count_frames(*second) == 0);
  send_sacn(1, sacn_group_ipv4(1), 1);
  CHECK(bridge.count() == kSenders);
  CHECK(count_frames(*second) == kSenders);
}

TEST_CASE("a source alone on its port has no notice, nor do two of one process") {
  if (!enter_private_network()) return;
  const auto first = must(ArtnetSource::create(artnet_options(1)));
  const auto second = must(ArtnetSource::create(artnet_options(2)));
  CHECK_FALSE(first->take_notice().has_value());
  CHECK_FALSE(second->take_notice().has_value());
  CHECK(other_holders(kArtnetPort).empty());
}

TEST_CASE("holders of a port are other processes, with address family, address and process number") {
  if (!enter_private_network()) return;
  OtherProgram any([]() -> Result<std::unique_ptr<Source>> { return make_artnet_source(artnet_options(1)); });
  OtherProgram yielding([]() -> Result<std::unique_ptr<Source>> {
    auto options = artnet_options(1);
    options.yields = true;
    return make_artnet_source(options);
  });
  const auto holders = other_holders(kArtnetPort);
  REQUIRE(holders.size() == 2);
  CHECK(holders[0].is_ipv4);
  CHECK(holders[0].ipv4 == 0);
  CHECK(holders[0].pid == any.pid());
  CHECK_FALSE(holders[0].is_bridge);
  CHECK_FALSE(holders[1].is_ipv4);
  CHECK(holders[1].pid == yielding.pid());
  CHECK(other_holders(kSacnPort).empty());
}

}  // namespace footlight::drivers
