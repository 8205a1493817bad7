// Arbitrary packets of a capture: link layer, IP, UDP, sACN, Art-Net. The first byte selects the link layer and whether
// the packets were cut short. Then packets follow, each after two bytes of length.
//
// Frames are within the ranges of FrameView, their slots inside the packet, and every packet is counted once.
#include <algorithm>

#include "drivers/capture/net_capture.h"
#include "tests/drivers/capture/packets.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  using namespace footlight::testing::packets;
  const std::vector<std::uint8_t> slots(24, 7);
  Sacn sacn;
  const Bytes datagrams[] = {udp(5568, sacn_data(sacn, slots)), udp(6454, artnet_dmx(3, 1, slots))};
  for (std::uint8_t link = 0; link < 5; ++link) {
    Bytes input = {link};
    for (const Bytes& datagram : datagrams) {
      for (const bool six : {false, true}) {
        const Bytes ip = six ? ipv6(datagram) : ipv4(datagram);
        const std::uint16_t type = six ? 0x86DD : 0x0800;
        Bytes cooked(16, 0);
        cooked[14] = static_cast<std::uint8_t>(type >> 8);
        cooked[15] = static_cast<std::uint8_t>(type);
        Bytes cooked2(20, 0);
        cooked2[0] = cooked[14];
        cooked2[1] = cooked[15];
        const Bytes packets[] = {ethernet(type, ip), join({cooked, ip}), join({cooked2, ip}), ip,
                                 join({{2, 0, 0, 0}, ip})};
        put_be16(input, packets[link].size());
        input.insert(input.end(), packets[link].begin(), packets[link].end());
      }
    }
    seeds.add("link-" + std::to_string(link), input);
  }
  const Bytes tagged = ethernet(0x8100, join({{0, 5, 0x08, 0}, ipv4(datagrams[0])}));
  Bytes input = {0};
  put_be16(input, tagged.size());
  input.insert(input.end(), tagged.begin(), tagged.end());
  seeds.add("vlan", input);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto link = static_cast<LinkLayer>(data[0] % 5);
  const bool cut = data[0] >= 128;
  std::span<const std::uint8_t> left(data + 1, size - 1);
  NetCapture capture({.hear_preview = (data[0] & 64) != 0});
  std::uint64_t packets = 0;
  while (left.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(std::size_t{left[0]} << 8 | left[1], left.size() - 2);
    const auto packet = left.subspan(2, length);
    left = left.subspan(2 + length);
    FrameView frame;
    const bool taken = capture.take(static_cast<TimeNs>(packets) * kNsPerMs, link, packet, cut, frame);
    ++packets;
    if (!taken) continue;
    require(is_universe(frame.universe) && frame.priority <= kPriorityMax && frame.sender != 0);
    require(frame.slots.size() <= kSlotCountMax);
    require(frame.slots.empty() ||
            (frame.slots.data() >= packet.data() && frame.slots.data() + frame.slots.size() <= packet.data() + length));
  }
  const NetCaptureCounters& c = capture.counters();
  require(c.packets == packets);
  require(c.packets == c.frames + c.not_udp + c.fragments + c.cut_short + c.malformed_packets + c.other_datagrams +
                           c.other_protocol + c.malformed_sacn + c.malformed_artnet + c.sync + c.discovery +
                           c.priorities + c.other_start_code + c.preview + c.late + c.ended_already);
  require(capture.notes().size() <= 15);
  return 0;
}
