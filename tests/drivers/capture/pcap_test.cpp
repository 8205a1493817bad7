#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include <doctest/doctest.h>

#include "drivers/capture/captures.h"
#include "drivers/capture/packet_walk.h"
#include "tests/drivers/capture/packets.h"
#include "tests/sim/dmx_log/support.h"

namespace footlight::drivers {
namespace {

using footlight::testing::all_frames;
using footlight::testing::OwnedFrame;
using footlight::testing::TempFolder;
using namespace footlight::testing::packets;

constexpr std::int64_t kStartNs = 1'700'000'000'123'456'789;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

struct Read {
  std::vector<OwnedFrame> frames;
  std::vector<std::string> notes;
  std::int64_t wall_ns = 0;
  DurationNs duration_ns = 0;
  std::uint64_t damage = 0;

  [[nodiscard]] bool has_note(const std::string& part) const {
    return std::any_of(notes.begin(), notes.end(), [&](const std::string& note) { return contains(note, part); });
  }
};

Read read_capture(const std::string& path, const CaptureOptions& options = {}) {
  auto input = open_any_log(path, options);
  REQUIRE_MESSAGE(input, input.error().message);
  auto reader = read_into_memory(**input);
  REQUIRE_MESSAGE(reader, reader.error().message);
  Read read;
  read.frames = all_frames(*reader);
  read.notes = (*input)->notes();
  read.wall_ns = reader->info().wall_start_unix_ns;
  read.duration_ns = reader->info().duration_ns;
  read.damage = (*input)->damage_count();
  return read;
}

std::string write_pcap(const TempFolder& folder, const std::string& name, const Pcap& pcap) {
  testing::write_bytes(folder.file(name), std::string(pcap.bytes().begin(), pcap.bytes().end()));
  return folder.file(name);
}

// Two desks and an Art-Net node, 25 ms apart, among other traffic.
Pcap traffic(bool nanoseconds, bool big_endian) {
  Pcap pcap(1, nanoseconds, big_endian);
  const auto slots = [](int i) {
    return std::vector<std::uint8_t>(i % 2 == 0 ? 512 : 24, static_cast<std::uint8_t>(i));
  };
  pcap.add(kStartNs, ethernet(0x0806, Bytes(28, 0)));
  for (int i = 0; i < 6; ++i) {
    const std::int64_t at_ns = kStartNs + 1'000'000 + i * 25'000'007LL;
    Sacn sacn;
    sacn.universe = 101;
    sacn.sequence = static_cast<std::uint8_t>(250 + i);
    sacn.cid = static_cast<std::uint8_t>(i % 2);
    sacn.priority = static_cast<std::uint8_t>(100 + 50 * (i % 2));
    pcap.add(at_ns, ethernet(0x0800, ipv4(udp(5568, sacn_data(sacn, slots(i))))));
    pcap.add(at_ns + 1'000,
             ethernet(0x0800, ipv4(udp(6454, artnet_dmx(3, static_cast<std::uint8_t>(i + 1), slots(i))))));
  }
  pcap.add(kStartNs + kNsPerS, ethernet(0x0800, ipv4(udp(53, {1, 2, 3}))));
  return pcap;
}

}  // namespace

TEST_CASE("frames from a pcap keep times, senders, priorities, sequences and levels") {
  const TempFolder folder;
  for (const bool nanoseconds : {true, false}) {
    for (const bool big_endian : {true, false}) {
      CAPTURE(nanoseconds);
      CAPTURE(big_endian);
      const Read read = read_capture(write_pcap(folder, "a.pcap", traffic(nanoseconds, big_endian)));
      REQUIRE(read.frames.size() == 12);
      CHECK(read.damage == 0);
      CHECK(read.wall_ns == (nanoseconds ? kStartNs : kStartNs / 1'000 * 1'000));
      CHECK(read.duration_ns == kNsPerS);
      for (int i = 0; i < 6; ++i) {
        const OwnedFrame& sacn = read.frames[static_cast<std::size_t>(2 * i)];
        const OwnedFrame& artnet = read.frames[static_cast<std::size_t>(2 * i + 1)];
        const DurationNs time_ns = 1'000'000 + i * 25'000'007LL;
        CHECK(std::abs(sacn.time_ns - time_ns) <= (nanoseconds ? 0 : 1'000));
        CHECK(std::abs(artnet.time_ns - time_ns - 1'000) <= (nanoseconds ? 0 : 1'000));
        CHECK(sacn.universe == 101);
        CHECK(artnet.universe == 4);  // port address 3
        CHECK(sacn.sequence == static_cast<std::uint8_t>(250 + i));
        CHECK(sacn.priority == 100 + 50 * (i % 2));
        CHECK(sacn.slots.size() == (i % 2 == 0 ? 512u : 24u));
        CHECK(sacn.slots.back() == i);
        CHECK(artnet.slots == sacn.slots);
      }
      CHECK(read.frames[0].sender != read.frames[2].sender);
      CHECK(read.frames[0].sender == read.frames[4].sender);
      CHECK(read.frames[1].sender == read.frames[3].sender);
      CHECK(read.has_note("1 packets are not UDP over IP"));
      CHECK(read.has_note("1 datagrams are neither sACN nor Art-Net"));
    }
  }
}

TEST_CASE("a capture can be limited to one protocol and renumbered, and universes without frames are listed") {
  const TempFolder folder;
  const std::string path = write_pcap(folder, "a.pcap", traffic(true, false));
  CaptureOptions only;
  only.net.artnet = false;
  const Read read = read_capture(path, only);
  CHECK(read.frames.size() == 6);
  CHECK(read.has_note("6 datagrams use the protocol that was not selected"));

  auto input = open_any_log(path);
  REQUIRE(input);
  ConvertOptions options;
  options.renumber = {{101, 1}, {102, 2}};
  const auto report = convert_log(**input, folder.file("a.dmxlog"), options);
  REQUIRE_MESSAGE(report, report.error().message);
  CHECK(report->frames == 6);
  CHECK(report->other_universes == 6);
  CHECK(report->absent == std::vector<Universe>{102});
  auto log = LogReader::open(folder.file("a.dmxlog"));
  REQUIRE(log);
  CHECK(all_frames(*log).front().universe == 1);
}

TEST_CASE("the datagram is found after VLAN tags, cooked headers, a loopback, raw IP and IPv6") {
  const Bytes datagram = udp(5568, {1, 2, 3, 4});
  const Bytes v4 = ipv4(datagram);
  const Bytes v6 = ipv6(datagram);
  const auto payload_of = [](LinkLayer link, const Bytes& packet) {
    const auto found = find_udp(link, packet, false);
    return found ? Bytes(found->payload.begin(), found->payload.end()) : Bytes{};
  };
  const Bytes expected = {1, 2, 3, 4};
  CHECK(payload_of(LinkLayer::kEthernet, ethernet(0x0800, v4)) == expected);
  CHECK(payload_of(LinkLayer::kEthernet, ethernet(0x86DD, v6)) == expected);
  CHECK(payload_of(LinkLayer::kEthernet, ethernet(0x8100, join({{0, 5, 0x08, 0}, v4}))) == expected);
  CHECK(payload_of(LinkLayer::kEthernet, ethernet(0x88A8, join({{0, 5, 0x81, 0}, {0, 6, 0x86, 0xDD}, v6}))) ==
        expected);
  CHECK(payload_of(LinkLayer::kEthernet, ethernet(0x0800, join({v4, Bytes(18, 0xEE)}))) == expected);  // padding
  Bytes cooked(16, 0);
  cooked[14] = 0x08;
  CHECK(payload_of(LinkLayer::kLinuxCooked, join({cooked, v4})) == expected);
  Bytes cooked2(20, 0);
  cooked2[0] = 0x86;
  cooked2[1] = 0xDD;
  CHECK(payload_of(LinkLayer::kLinuxCooked2, join({cooked2, v6})) == expected);
  CHECK(payload_of(LinkLayer::kRawIp, v4) == expected);
  CHECK(payload_of(LinkLayer::kRawIp, v6) == expected);
  CHECK(payload_of(LinkLayer::kLoopback, join({{2, 0, 0, 0}, v4})) == expected);
  CHECK(payload_of(LinkLayer::kLoopback, join({{0, 0, 0, 30}, v6})) == expected);
  Bytes options = v4;  // IPv4 with four bytes of options
  options[0] = 0x46;
  options[3] = static_cast<std::uint8_t>(options[3] + 4);
  options.insert(options.begin() + 20, {1, 1, 1, 0});
  CHECK(payload_of(LinkLayer::kRawIp, options) == expected);
  Bytes hops = v6;  // IPv6 with a hop-by-hop header
  hops[6] = 0;
  hops[5] = static_cast<std::uint8_t>(hops[5] + 8);
  hops.insert(hops.begin() + 40, {17, 0, 1, 4, 0, 0, 0, 0});
  CHECK(payload_of(LinkLayer::kRawIp, hops) == expected);
  const auto from = find_udp(LinkLayer::kRawIp, v4, false);
  REQUIRE(from);
  CHECK(Bytes(from->from_address.begin(), from->from_address.end()) == Bytes{10, 0, 0, 7});
  CHECK(from->to_port == 5568);

  // Cut at any byte, nothing is found and nothing is read out of bounds.
  const Bytes whole = ethernet(0x8100, join({{0, 5, 0x08, 0}, v4}));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto found = find_udp(LinkLayer::kEthernet, part, true);
    REQUIRE(!found);
    CHECK(found.error() == WalkFault::kCutShort);
  }
}

TEST_CASE("packets without a frame are counted by reason") {
  const TempFolder folder;
  const std::vector<std::uint8_t> slots(512, 9);
  Pcap pcap(1, true, false);
  std::int64_t at_ns = kStartNs;
  const auto add = [&](const Bytes& packet) { pcap.add(at_ns += 1'000'000, packet); };
  const auto add_udp = [&](std::uint16_t port, const Bytes& payload) {
    add(ethernet(0x0800, ipv4(udp(port, payload))));
  };
  Sacn sacn;
  add_udp(5568, sacn_data(sacn, slots));  // the one frame
  add_udp(5568, sacn_data(sacn, slots));  // duplicate, as in a capture on all interfaces
  sacn.sequence = 1;
  sacn.start_code = 0xDD;
  add_udp(5568, sacn_data(sacn, slots));
  sacn.start_code = 0x17;
  add_udp(5568, sacn_data(sacn, slots));
  sacn.start_code = 0;
  sacn.preview = true;
  add_udp(5568, sacn_data(sacn, slots));
  sacn.preview = false;
  sacn.terminated = true;
  for (int i = 0; i < 3; ++i) {
    ++sacn.sequence;
    add_udp(5568, sacn_data(sacn, slots));  // the end of the stream is one frame
  }
  Bytes broken = sacn_data(sacn, slots);
  broken[17] ^= 1;
  add_udp(5568, broken);
  add_udp(6454, {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x52, 0, 14, 0, 0});     // ArtSync
  add_udp(6454, {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x20, 0, 14, 0, 0});     // ArtPoll
  add_udp(6454, {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x50, 0, 14, 0, 0, 0});  // too short
  Bytes fragment = ipv4(udp(5568, sacn_data({}, slots)));
  fragment[6] = 0x20;
  add(ethernet(0x0800, fragment));
  Bytes tcp = ipv4(Bytes(20, 0));
  tcp[9] = 6;
  add(ethernet(0x0800, tcp));
  const Bytes whole = ethernet(0x0800, ipv4(udp(5568, sacn_data({}, slots))));
  pcap.add(at_ns += 1'000'000, Bytes(whole.begin(), whole.begin() + 96), whole.size());

  const Read read = read_capture(write_pcap(folder, "a.pcap", pcap));
  REQUIRE(read.frames.size() == 2);
  CHECK(!read.frames[0].terminated);
  CHECK(read.frames[1].terminated);
  for (const char* note :
       {"1 frames were late or duplicate", "1 sACN frames of per-address priorities; a log holds levels only",
        "1 sACN frames of other start codes", "1 sACN frames are previews", "2 sACN packets repeat the end of a stream",
        "1 datagrams violate sACN", "1 datagrams violate Art-Net",
        "1 synchronisation packets: frames have the time of their arrival", "1 datagrams of discovery",
        "1 packets are fragments", "1 packets are not UDP", "1 packets were cut short by the capture"}) {
    CHECK_MESSAGE(read.has_note(note), note);
  }
  CaptureOptions preview;
  preview.net.hear_preview = true;
  CHECK(read_capture(folder.file("a.pcap"), preview).frames.size() == 3);
}

TEST_CASE("a truncated capture returns the frames before the end, and reports it") {
  const TempFolder folder;
  const Pcap whole = traffic(true, false);
  Bytes bytes = whole.bytes();
  bytes.resize(bytes.size() * 2 / 3);
  testing::write_bytes(folder.file("a.pcap"), std::string(bytes.begin(), bytes.end()));
  const Read read = read_capture(folder.file("a.pcap"));
  CHECK(read.frames.size() > 4);
  CHECK(read.frames.size() < 12);
  CHECK(read.damage == 1);
  CHECK(read.has_note("ends early"));
}

TEST_CASE("the errors for unknown link layers and damaged captures name the file") {
  const TempFolder folder;
  const auto radio = open_any_log(write_pcap(folder, "radio.pcap", Pcap(105, true, false)));
  REQUIRE(!radio);
  CHECK(radio.error().code == ErrorCode::kUnsupported);
  CHECK(contains(radio.error().message, "802.11"));
  testing::write_bytes(folder.file("short.pcap"), "\xD4\xC3\xB2\xA1");
  const auto cut = open_any_log(folder.file("short.pcap"));
  REQUIRE(!cut);
  CHECK(contains(cut.error().message, "short.pcap: not a valid packet capture"));
  const Read empty = read_capture(write_pcap(folder, "empty.pcap", Pcap(1, true, false)));
  CHECK(empty.frames.empty());
  CHECK(empty.duration_ns == 0);
}

TEST_CASE("the same packets as pcapng give the same frames") {
  if (std::system("command -v editcap > /dev/null 2>&1") != 0) {
    MESSAGE("skipped: editcap is not installed");
    return;
  }
  const TempFolder folder;
  const std::string pcap = write_pcap(folder, "a.pcap", traffic(true, false));
  const std::string pcapng = folder.file("a.pcapng");
  REQUIRE(std::system(("editcap -F pcapng " + pcap + " " + pcapng).c_str()) == 0);
  const Read one = read_capture(pcap);
  const Read other = read_capture(pcapng);
  CHECK(detect_log_format(pcapng) == LogFormat::kPacketCapture);
  CHECK(one.frames == other.frames);
  CHECK(one.wall_ns == other.wall_ns);
  CHECK(one.notes == other.notes);
}

}  // namespace footlight::drivers
