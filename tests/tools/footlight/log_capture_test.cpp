// `footlight log convert`, `diff`, `timing` and `info` of captures that are made here: pcap, pcapng and sigrok's .sr.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/drivers/capture/line_signal.h"
#include "tests/drivers/capture/packets.h"
#include "tests/drivers/capture/zip_writer.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

using Json = nlohmann::json;
using packets::Bytes;

constexpr std::int64_t kStartNs = 1'700'000'000'123'456'000;
constexpr int kFrames = 8;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

void write(const std::string& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

struct Packet {
  std::int64_t unix_ns = 0;
  Bytes bytes;
};

// One console on universe 3, every 25 ms: 24 slots with the number of the frame, and an ARP packet.
// `changed`: one slot of the sixth is 9 higher; `left_out`: that frame is missing; `late_ns`: delay of the last one.
struct Difference {
  bool changed = false;
  int left_out = -1;
  std::int64_t late_ns = 0;
};
std::vector<Packet> traffic(const Difference& difference = {}) {
  std::vector<Packet> all = {{kStartNs, packets::ethernet(0x0806, Bytes(28, 0))}};
  for (int i = 0; i < kFrames; ++i) {
    if (i == difference.left_out) continue;
    std::vector<std::uint8_t> slots(24, static_cast<std::uint8_t>(i + 1));
    if (difference.changed && i == 5) slots[10] = static_cast<std::uint8_t>(slots[10] + 9);
    const auto payload = packets::sacn_data({.universe = 3, .sequence = static_cast<std::uint8_t>(i)}, slots);
    all.push_back({kStartNs + 10'000'000 + i * 25'000'000LL + (i + 1 == kFrames ? difference.late_ns : 0),
                   packets::ethernet(0x0800, packets::ipv4(packets::udp(5568, payload)))});
  }
  return all;
}

Bytes pcap_of(const std::vector<Packet>& all) {
  packets::Pcap pcap(1, true, false);
  for (const Packet& packet : all) pcap.add(packet.unix_ns, packet.bytes);
  return pcap.bytes();
}

// draft-ietf-opsawg-pcapng: a section, an interface of Ethernet with times to a nanosecond, a block for each packet.
Bytes pcapng_of(const std::vector<Packet>& all) {
  Bytes file;
  const auto put = [](Bytes& to, std::uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto block = [&](std::uint32_t type, const Bytes& body) {
    put(file, type, 4);
    put(file, 12 + body.size(), 4);
    file.insert(file.end(), body.begin(), body.end());
    put(file, 12 + body.size(), 4);
  };
  Bytes section;
  put(section, 0x1A2B3C4D, 4);
  put(section, 1, 2);
  put(section, 0, 2);
  put(section, ~std::uint64_t{0}, 8);
  block(0x0A0D0D0A, section);
  Bytes interface;
  put(interface, 1, 4);       // Ethernet
  put(interface, 65'535, 4);  // of a packet at most
  put(interface, 9, 2);       // if_tsresol
  put(interface, 1, 2);
  put(interface, 9, 4);  // 10^-9 s, and padding
  put(interface, 0, 4);  // no more options
  block(1, interface);
  for (const Packet& packet : all) {
    Bytes body;
    put(body, 0, 4);
    put(body, static_cast<std::uint64_t>(packet.unix_ns) >> 32, 4);
    put(body, static_cast<std::uint64_t>(packet.unix_ns) & 0xFFFFFFFF, 4);
    put(body, packet.bytes.size(), 4);
    put(body, packet.bytes.size(), 4);
    body.insert(body.end(), packet.bytes.begin(), packet.bytes.end());
    while (body.size() % 4 != 0) body.push_back(0);
    block(6, body);
  }
  return file;
}

// Three frames of 24 slots with a break of 100 us, a mark of 12 us and slots of 44 us, sampled at 1 MHz. A fourth with
// a mark of 2 us is not a frame.
Bytes line_capture(bool with_bad_frame) {
  LineSignal signal(1'000'000);
  signal.mark(1e5);
  for (int i = 0; i < (with_bad_frame ? 4 : 3); ++i) {
    Bytes bytes(25, static_cast<std::uint8_t>(i + 1));
    bytes[0] = 0;
    LineProfile profile;
    if (i == 3) profile.mab_ns = 2'000;
    signal.frame(bytes, profile);
    signal.mark(5e5);
  }
  signal.mark(2e6);
  ZipWriter zip;
  zip.add("version", "2");
  zip.add("metadata",
          "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes=1\nsamplerate=1 MHz\n"
          "total analog=0\nprobe1=DMX+\nunitsize=1\n");
  zip.add("logic-1-1", signal.samples());
  return zip.finish();
}

// A successful command prints nothing on standard error.
Json json_of(const Outcome& outcome, int exit_code = 0) {
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == exit_code);
  CHECK(outcome.err.empty());
  REQUIRE(Json::accept(outcome.out));
  return Json::parse(outcome.out);
}

void check_refused(const Outcome& outcome, const std::vector<std::string>& words) {
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code != 0);
  CHECK(outcome.out.empty());
  for (const std::string& word : words) CHECK(contains(outcome.err, word));
}

}  // namespace

TEST_SUITE_BEGIN("captures by command");

TEST_CASE("convert makes the same log of a pcap and a pcapng, and prints how many packets were left out, by reason") {
  const TempFolder folder;
  write(folder.file("a.pcap"), pcap_of(traffic()));
  write(folder.file("a.pcapng"), pcapng_of(traffic()));
  const Outcome text = footlight({"log", "convert", folder.file("a.pcap"), folder.file("a.dmxlog")});
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "a.dmxlog: 8 frames, 185 ms, "));
  CHECK(contains(text.out, "note: 1 packets are not UDP over IP"));
  const Json json = json_of(
      footlight({"log", "convert", "--json", "--universes", "3=7", folder.file("a.pcapng"), folder.file("b.dmxlog")}));
  CHECK(json["frames"] == 8);
  CHECK(json["duration_ns"] == 185'000'000);
  CHECK(json["damage_count"] == 0);
  CHECK(json["left_out"] == 0);
  CHECK(json["out"] == folder.file("b.dmxlog"));
  CHECK(json["notes"].size() == 1);

  const Json info = json_of(footlight({"log", "info", "--check", "--json", folder.file("b.dmxlog")}));
  REQUIRE(info["universes"].size() == 1);
  CHECK(info["universes"][0]["universe"] == 7);
  CHECK(info["universes"][0]["frames"] == 8);
  CHECK(info["universes"][0]["slots"] == 24);
  CHECK(info["universes"][0]["first_ns"] == 10'000'000);
  // Both logs and both captures are equal.
  for (const char* other : {"a.pcap", "a.pcapng"}) {
    const Outcome equal = footlight({"log", "diff", "--same-start", folder.file("a.dmxlog"), folder.file(other)});
    CAPTURE(equal.out);
    CHECK(equal.exit_code == 0);
    CHECK(contains(equal.out, "universe 3: 8 pairs, 0 frames only in A, 0 only in B"));
    CHECK(contains(equal.out, "\nequal\n"));
  }
}

TEST_CASE("convert refuses unreadable inputs and existing outputs, and leaves no file behind") {
  const TempFolder folder;
  write(folder.file("a.pcap"), pcap_of(traffic()));
  write(folder.file("rubbish"), Bytes(300, 'x'));
  Bytes cut = pcap_of(traffic());
  cut.resize(30);  // inside the first packet's header
  write(folder.file("cut.pcap"), cut);
  const std::string out = folder.file("out.dmxlog");
  check_refused(footlight({"log", "convert", folder.file("none.pcap"), out}), {"none.pcap"});
  check_refused(footlight({"log", "convert", folder.file("rubbish"), out}), {"rubbish"});
  check_refused(footlight({"log", "convert", "--protocol", "dmx", folder.file("a.pcap"), out}),
                {"--protocol", "'sacn' or 'artnet'", "'dmx'"});
  check_refused(footlight({"log", "convert", "--universes", "3=", folder.file("a.pcap"), out}), {"--universes"});
  check_refused(footlight({"log", "convert", folder.file("a.pcap")}), {"two files"});
  CHECK_FALSE(std::ifstream(out).good());

  const Outcome damaged = footlight({"log", "convert", folder.file("cut.pcap"), out});
  CAPTURE(damaged.err);
  CHECK(damaged.exit_code == 1);
  CHECK(contains(damaged.err, "cut.pcap"));

  write(folder.file("mine.dmxlog"), {1, 2, 3});
  check_refused(footlight({"log", "convert", folder.file("a.pcap"), folder.file("mine.dmxlog")}), {"mine.dmxlog"});
  std::ifstream mine(folder.file("mine.dmxlog"), std::ios::binary);
  CHECK(std::string(std::istreambuf_iterator<char>(mine), {}) == "\1\2\3");
}

TEST_CASE("diff reports a different level, a missing frame and a late frame separately") {
  const TempFolder folder;
  const std::string a = folder.file("a.pcap"), b = folder.file("b.pcapng");
  write(a, pcap_of(traffic()));
  const auto diff = [&](const Difference& difference, const std::vector<std::string>& options) {
    write(b, pcapng_of(traffic(difference)));
    std::vector<std::string> words = {"log", "diff", "--same-start", a, b};
    words.insert(words.end(), options.begin(), options.end());
    return footlight(words);
  };
  Json json = json_of(diff({.changed = true}, {"--json"}), 1);
  CHECK(json["equal"] == false);
  REQUIRE(json["universes"].size() == 1);
  Json one = json["universes"][0];
  CHECK(one["universe"] == 3);
  CHECK(one["pairs"] == 8);
  CHECK(one["different"] == 1);
  CHECK(one["slots_different"] == 1);
  CHECK(one["level_distance_max"] == 9);
  CHECK(one["first_difference"] == Json({{"time_ns", 135'000'000}, {"address", 11}, {"level_a", 6}, {"level_b", 15}}));
  const Outcome text = diff({.changed = true}, {});
  CHECK(text.exit_code == 1);
  CHECK(contains(text.out, "1 pairs differ, in 1 slots, by at most 9; first at 135 ms, address 11: 6 in A, 15 in B"));
  CHECK(contains(text.out, "\ndifferent\n"));
  CHECK(diff({.changed = true}, {"--values", "9"}).exit_code == 0);
  CHECK(diff({.changed = true}, {"--values", "8"}).exit_code == 1);

  one = json_of(diff({.left_out = 2}, {"--json"}), 1)["universes"][0];
  CHECK(one["frames_b"] == 7);
  CHECK(one["only_a"] == 1);
  CHECK(one["only_b"] == 0);
  CHECK(one["different"] == 0);

  json = json_of(diff({.late_ns = 3'000'000}, {"--json"}), 1);
  CHECK(json["universes"][0]["time_max_ns"] == 3'000'000);
  CHECK(json["universes"][0]["different"] == 0);
  CHECK(json["offset_from"] == "given");
  CHECK(diff({.late_ns = 3'000'000}, {"--time-tolerance", "3ms"}).exit_code == 0);

  check_refused(footlight({"log", "diff", a}), {"two files"});
  check_refused(footlight({"log", "diff", a, folder.file("none.pcap")}), {"none.pcap"});
}

TEST_CASE("timing measures the line as it was made, a rejected frame has its reason and gives exit code 1") {
  const TempFolder folder;
  const std::string good = folder.file("good.sr"), bad = folder.file("bad.sr");
  write(good, line_capture(false));
  write(bad, line_capture(true));
  const Json json = json_of(footlight({"log", "timing", "--json", good}));
  CHECK(json["channel"] == "DMX+");
  CHECK(json["inverted"] == false);
  CHECK(json["sample_rate_hz"] == 1'000'000);
  CHECK(json["sound"] == 3);
  CHECK(json["rejected"] == 0);
  REQUIRE(json["frames"].size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& frame = json["frames"][i];
    CHECK(frame["slots"] == 24);
    CHECK(frame["start_code"] == 0);
    CHECK(frame["sound"] == true);
    CHECK_FALSE(frame.contains("reason"));
    CHECK(std::abs(frame["break_ns"].get<long>() - 100'000) <= 1'000);  // a sample
    CHECK(std::abs(frame["mab_ns"].get<long>() - 12'000) <= 1'000);
  }
  // From break to break: 0.1 ms, 12 us, 25 slots of 44 us, and 0.5 ms.
  CHECK(std::abs(json["frames"][1]["period_ns"].get<long>() - 1'712'000) <= 1'000);

  const Outcome text = footlight({"log", "timing", good});
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "time_ms  break_us   mab_us"));
  CHECK(contains(text.out, "good.sr: 3 frames, 0 rejected"));
  CHECK(contains(text.out, "0x00"));
  const Outcome summary = footlight({"log", "timing", "--summary", good});
  CHECK(summary.exit_code == 0);
  CHECK_FALSE(contains(summary.out, "time_ms"));
  CHECK(contains(summary.out, "  slots       24.00     24.00     24.00"));

  const Json rejected = json_of(footlight({"log", "timing", "--json", bad}), 1);
  CHECK(rejected["sound"] == 3);
  CHECK(rejected["rejected"] == 1);
  CHECK(rejected["frames"].back()["sound"] == false);
  CHECK(rejected["frames"].back()["reason"] == "the mark after break is shorter than 3 us");
  const Outcome shown = footlight({"log", "timing", bad});
  CHECK(shown.exit_code == 1);
  CHECK(contains(shown.out, "rejected: the mark after break is shorter than 3 us"));
}

TEST_CASE("timing of a file that is not a line capture, and of a missing channel, is refused by name") {
  const TempFolder folder;
  write(folder.file("a.pcap"), pcap_of(traffic()));
  write(folder.file("good.sr"), line_capture(false));
  check_refused(footlight({"log", "timing", folder.file("a.pcap")}), {"a.pcap", "expected a sigrok capture"});
  check_refused(footlight({"log", "timing", folder.file("none.sr")}), {"none.sr"});
  check_refused(footlight({"log", "timing"}), {"expected a file"});
  check_refused(footlight({"log", "timing", "--channel", "D9", folder.file("good.sr")}), {"D9", "DMX+"});
  check_refused(footlight({"log", "timing", "--inverted", folder.file("good.sr")}), {"--inverted", "--channel"});
  Bytes cut = line_capture(false);
  cut.resize(cut.size() / 2);
  write(folder.file("cut.sr"), cut);
  check_refused(footlight({"log", "timing", folder.file("cut.sr")}), {"cut.sr"});
}

TEST_CASE("a captured line becomes a log of the given universe, equal to packets with its levels") {
  const TempFolder folder;
  const std::string line = folder.file("line.sr"), log = folder.file("line.dmxlog");
  write(line, line_capture(true));
  const Json json = json_of(footlight({"log", "convert", "--json", "--universe", "9", line, log}));
  CHECK(json["frames"] == 3);
  const Json info = json_of(footlight({"log", "info", "--json", log}));
  CHECK(info["universes"][0]["universe"] == 9);
  CHECK(info["universes"][0]["slots"] == 24);
  CHECK(footlight({"log", "diff", "--same-start", "--universe", "9", line, log}).exit_code == 0);
  const Json other = json_of(footlight({"log", "diff", "--json", "--universe", "8", line, log}), 1);
  CHECK(other["offset_from"] == "nothing");
  CHECK(other["universes"].size() == 2);
}

TEST_SUITE_END();

}  // namespace footlight::testing
