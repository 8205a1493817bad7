// Programs that share a UDP port with a running bridge on the same machine; and the events of a waiting bridge.
#include <csignal>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "drivers/net/artnet_packet.h"
#include "sim/system_clock.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

constexpr std::uint32_t kThisMachine = 0x7F00'0001;
constexpr int kSenders = 60;
constexpr int kFramesEach = 20;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// 1,200 unicast frames of universe 1, from `senders` addresses and UDP ports.
void send_artnet() {
  const std::vector<std::uint8_t> slots(4, 9);
  drivers::ArtnetDmx dmx;
  dmx.slots = slots;
  std::vector<std::uint8_t> packet(drivers::kArtnetDmxBytesMax);
  packet.resize(drivers::build_artnet_dmx(dmx, packet));
  for (std::uint32_t i = 0; i < kSenders; ++i) {
    const drivers::Fd sender = stranger(kThisMachine + 1 + i, 0);
    for (int k = 0; k < kFramesEach; ++k) REQUIRE(send_bytes(sender, kThisMachine, drivers::kArtnetPort, packet));
  }
}

const std::vector<std::string> kBridge = {"run",    "--in",     "artnet:1-3", "--out",        "mock:enttec-pro",
                                          "--json", "--socket", "none",       "--no-realtime"};

// The number of frames that the bridge has received at its end.
int frames_of(Footlight& bridge) {
  bridge.signal(SIGTERM);
  const Outcome outcome = bridge.wait();
  const std::size_t end = outcome.out.find_last_not_of('\n');
  const std::size_t begin = outcome.out.rfind('\n', end) + 1;
  const auto json = nlohmann::json::parse(outcome.out.substr(begin, end + 1 - begin));
  for (const auto& port : json["ports"])
    if (port["direction"] == "in") return port["frames"];
  return -1;
}

TEST_CASE("a bridge gets all 1,200 unicast frames while monitor, record or a second bridge shares its port") {
  if (!enter_private_network()) return;
  const TempFolder folder;
  const std::vector<std::vector<std::string>> others = {
      {"monitor", "artnet:1-3", "--json", "--period", "100ms"},
      {"record", "--in", "artnet:1-3", "-o", folder.file("a.dmxlog"), "--json"},
      kBridge,
  };
  for (const auto& words : others) {
    CAPTURE(words[0]);
    Footlight bridge(kBridge);
    bridge.wait_for(R"("event":"ready")");
    const std::string named = "footlight run (process " + std::to_string(bridge.pid()) + ")";
    Footlight other(words);
    other.wait_for(R"("event":)");
    send_artnet();
    bridge.wait_for(R"("frames":1200)");
    CHECK(frames_of(bridge) == kSenders * kFramesEach);
    other.signal(SIGTERM);
    const Outcome outcome = other.wait();
    // It reports which program gets the frames: monitor on standard error, the others as an event.
    CHECK(contains(outcome.out + outcome.err, named));
    CHECK(contains(outcome.out + outcome.err, "UDP port 6454"));
  }
}

TEST_CASE("a recording gets all 1,200 unicast frames beside an older bridge that only sends Art-Net to an address") {
  if (!enter_private_network()) return;
  const TempFolder folder;
  Footlight bridge(
      {"run", "--in", "sacn:1%lo", "--out", "artnet:1@127.0.0.9", "--json", "--socket", "none", "--no-realtime"});
  bridge.wait_for(R"("event":"ready")");
  Footlight recorder({"record", "--in", "artnet:1", "-o", folder.file("a.dmxlog"), "--json"});
  recorder.wait_for(R"("event":"ready")");
  send_artnet();
  recorder.wait_for(R"("frames":1200)");
  CHECK_FALSE(recorder.has_printed("port-shared", 1));
  CHECK(frames_of(recorder) == kSenders * kFramesEach);
}

TEST_CASE(
    "a recording beside an older bridge with an output that polls warns that the output may drop unicast frames") {
  if (!enter_private_network()) return;
  const TempFolder folder;
  Footlight bridge({"run", "--in", "sacn:1%lo", "--out", "artnet:1%lo", "--json", "--socket", "none", "--no-realtime"});
  bridge.wait_for(R"("event":"ready")");
  Footlight recorder({"record", "--in", "artnet:1", "-o", folder.file("a.dmxlog"), "--json"});
  recorder.wait_for("port-shared");
  recorder.signal(SIGTERM);
  const Outcome outcome = recorder.wait();
  CHECK(contains(outcome.out, "an output that searches for devices drops them"));
  CHECK(contains(outcome.out, "name the addresses of its devices after @"));
}

TEST_CASE("a recording without a frame leaves no file, and does not change an existing log") {
  if (!enter_private_network()) return;
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  const std::vector<std::string> words = {"record", "--in", "sacn:1%lo", "-o", path, "--for", "10ms"};
  for (int time = 1; time <= 2; ++time) {  // the same command again is not refused
    CHECK(footlight(words).exit_code == 3);
    CHECK(std::filesystem::is_empty(folder.path()));
  }
  std::ofstream(path) << "a good log";
  auto replacing = words;
  replacing.push_back("--overwrite");
  CHECK(footlight(replacing).exit_code == 3);
  std::string text;
  std::getline(std::ifstream(path), text);
  CHECK(text == "a good log");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("a recording without a frame ends with exit code 3 and names the commands that find senders") {
  if (!enter_private_network()) return;
  const TempFolder folder;
  const Outcome outcome = footlight({"record", "--in", "sacn:1-3%lo", "-o", folder.file("a.dmxlog"), "--for", "100ms"});
  CHECK(outcome.exit_code == 3);
  CHECK(contains(outcome.err, "no frames arrived"));
  CHECK(contains(outcome.err, "footlight discover"));
}

TEST_CASE("a bridge with a file as output prints its ports at once, and missing senders within three seconds") {
  if (!enter_private_network()) return;
  SystemClock clock;
  const TimeNs begin_ns = clock.now_ns();
  Footlight bridge(
      {"run", "--in", "sacn:1-3%lo", "--out", "mock:enttec-pro", "--socket", "none", "--no-realtime", "--for", "3s"});
  const Outcome outcome = bridge.wait();
  CHECK(clock.now_ns() - begin_ns >= 3 * kNsPerS);
  const std::size_t started = outcome.err.find("started: from sacn:1-3%lo to mock:enttec-pro");
  const std::size_t waits = outcome.err.find("sacn:1-3%lo: no frames yet; waiting for a sender of universe 1-3");
  CHECK(started != std::string::npos);
  CHECK(waits != std::string::npos);
  CHECK(started < waits);
  CHECK_FALSE(contains(outcome.err.substr(waits + 30), "no frames yet"));  // once
}

TEST_CASE("discover names the interfaces that it uses, and why it does not use the others") {
  if (!enter_private_network(/*loopback_multicast=*/false) || !add_interface("fl0", "10.7.0.1")) return;
  const Outcome all = footlight({"discover", "--for", "10ms"});
  CHECK(all.exit_code == 3);
  CHECK(contains(all.err, "on fl0\n"));
  CHECK(contains(all.err, "not searched on lo (no multicast); select an interface with --interface NAME"));
  const Outcome one = footlight({"discover", "--for", "10ms", "--interface", "lo"});
  CHECK(contains(one.err, "on lo\n"));
  CHECK(contains(one.err, "not searched on fl0 (not selected)"));
}

TEST_CASE("the command that discover prints for a sender has its universe and the selected interfaces") {
  if (!enter_private_network()) return;
  Footlight discover({"discover", "--for", "4s", "--interface", "lo"});
  // An output announces itself one second after its start.
  Footlight sender({"run", "--in", "mock:enttec-pro", "--out", "sacn:1%lo", "--json", "--socket", "none",
                    "--no-realtime", "--for", "4s"});
  const Outcome outcome = discover.wait();
  CAPTURE(outcome.out);
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.out, "footlight run --in sacn:1%lo --out mock:enttec-pro\n"));
  CHECK(sender.wait().exit_code == 0);
}

TEST_CASE("discover names the program that gets the answers of Art-Net devices instead") {
  if (!enter_private_network()) return;
  Footlight bridge(kBridge);
  bridge.wait_for(R"("event":"ready")");
  const Outcome outcome = footlight({"discover", "--for", "10ms", "--interface", "lo"});
  CHECK(contains(outcome.err, "footlight run (process " + std::to_string(bridge.pid()) + ") has UDP port 6454 open"));
}

TEST_CASE("discover does not name a bridge that only sends Art-Net to an address, because it gets no answers") {
  if (!enter_private_network()) return;
  Footlight bridge(
      {"run", "--in", "sacn:1%lo", "--out", "artnet:1@127.0.0.9", "--json", "--socket", "none", "--no-realtime"});
  bridge.wait_for(R"("event":"ready")");
  CHECK_FALSE(contains(footlight({"discover", "--for", "10ms", "--interface", "lo"}).err, "has UDP port 6454 open"));
}

TEST_CASE("a show file beyond 4 MiB is refused with its length, also from an endless pipe") {
  const TempFolder folder;
  const std::string path = folder.file("long.toml");
  std::ofstream(path) << std::string((4 << 20) + 1, '#');
  for (const std::string& place : {path, std::string("/dev/zero")}) {
    const Outcome outcome = footlight({"run", place});
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.err, place + ": longer than 4194304 bytes"));
  }
}

TEST_CASE("SIGTERM ends a bridge while it joins 63,999 groups, with exit code 0") {
  if (!enter_private_network()) return;
  Footlight bridge(
      {"run", "--in", "sacn:1-63999%lo", "--out", "mock:enttec-pro", "--socket", "none", "--no-realtime", "--json"});
  // Its first sockets with groups: it is still opening.
  const std::string folder = fmt::format("/proc/{}/fd", bridge.pid());
  std::error_code error;
  while (std::distance(std::filesystem::directory_iterator(folder, error), {}) < 20) {
  }
  bridge.signal(SIGTERM);
  const Outcome outcome = bridge.wait();
  CHECK(outcome.exit_code == 0);
  CHECK_FALSE(contains(outcome.out, "ready"));
}

}  // namespace
}  // namespace footlight::testing
