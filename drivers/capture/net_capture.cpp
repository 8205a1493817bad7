#include "drivers/capture/net_capture.h"

#include <algorithm>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/hash.h"
#include "drivers/net/sacn_packet.h"

namespace footlight::drivers {
namespace {

using namespace std::string_view_literals;

bool has_at(std::span<const std::uint8_t> bytes, std::size_t at, std::string_view text) {
  return bytes.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

}  // namespace

bool NetCapture::take(TimeNs stamp_ns, LinkLayer link, std::span<const std::uint8_t> packet, bool cut,
                      FrameView& frame) {
  ++counters_.packets;
  const auto datagram = find_udp(link, packet, cut);
  if (!datagram) {
    switch (datagram.error()) {
      case WalkFault::kNotUdp: ++counters_.not_udp; break;
      case WalkFault::kFragment: ++counters_.fragments; break;
      case WalkFault::kCutShort: ++counters_.cut_short; break;
      case WalkFault::kMalformed: ++counters_.malformed_packets; break;
    }
    return false;
  }
  const bool is_sacn = has_at(datagram->payload, 4, "ASC-E1.17\0\0\0"sv);
  const bool is_artnet = has_at(datagram->payload, 0, "Art-Net\0"sv);
  if (!is_sacn && !is_artnet) {
    ++counters_.other_datagrams;
    return false;
  }
  if (is_sacn ? !options_.sacn : !options_.artnet) {
    ++counters_.other_protocol;
    return false;
  }
  frame = {};
  frame.stamp_ns = stamp_ns;
  const bool taken = is_sacn ? take_sacn(stamp_ns, *datagram, frame) : take_artnet(stamp_ns, *datagram, frame);
  if (taken) ++counters_.frames;
  return taken;
}

bool NetCapture::take_sacn(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame) {
  const auto packet = parse_sacn_packet(datagram.payload);
  if (!packet) {
    ++counters_.malformed_sacn;
    return false;
  }
  if (std::holds_alternative<SacnSync>(*packet)) {
    ++counters_.sync;
    return false;
  }
  const auto* data = std::get_if<SacnData>(&*packet);
  if (data == nullptr) {
    ++counters_.discovery;
    return false;
  }
  if (data->start_code != kStartCodeLevels) {
    ++(data->start_code == footlight::kStartCodePriorities ? counters_.priorities : counters_.other_start_code);
    return false;
  }
  if (data->preview && !options_.hear_preview) {
    ++counters_.preview;
    return false;
  }
  frame.universe = data->universe;
  frame.sender = sender_hash(data->cid);
  switch (filters_[{true, data->universe}].judge(frame.sender, data->sequence, data->terminated, SequenceRule::kSacn,
                                                 stamp_ns)) {
    case SequenceFilter::Verdict::kLate: ++counters_.late; return false;
    case SequenceFilter::Verdict::kEndedAlready: ++counters_.ended_already; return false;
    case SequenceFilter::Verdict::kNew: break;
  }
  frame.sequence = data->sequence;
  frame.priority = data->priority;
  frame.terminated = data->terminated;
  if (!data->terminated) frame.slots = data->slots;
  return true;
}

bool NetCapture::take_artnet(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame) {
  const auto packet = parse_artnet_packet(datagram.payload);
  if (!packet) {
    ++counters_.malformed_artnet;
    return false;
  }
  if (std::holds_alternative<ArtnetSync>(*packet)) {
    ++counters_.sync;
    return false;
  }
  const auto* dmx = std::get_if<ArtnetDmx>(&*packet);
  if (dmx == nullptr) {
    ++counters_.discovery;
    return false;
  }
  frame.universe = artnet_wire_universe(dmx->port_address);
  frame.sender = sender_hash(datagram.from_address);
  if (dmx->sequence != 0 &&
      filters_[{false, frame.universe}].judge(frame.sender, dmx->sequence, false, SequenceRule::kArtnet, stamp_ns) ==
          SequenceFilter::Verdict::kLate) {
    ++counters_.late;
    return false;
  }
  frame.sequence = dmx->sequence;
  frame.slots = dmx->slots;
  return true;
}

std::vector<std::string> NetCapture::notes() const {
  std::vector<std::string> notes;
  const auto note = [&](std::uint64_t count, const char* what) {
    if (count > 0) notes.push_back(fmt::format("{} {}", count, what));
  };
  note(counters_.not_udp, "packets are not UDP over IP");
  note(counters_.other_datagrams, "datagrams are neither sACN nor Art-Net");
  note(counters_.other_protocol, "datagrams use the protocol that was not selected");
  note(counters_.fragments, "packets are fragments, which are not reassembled");
  note(counters_.cut_short, "packets were cut short by the capture; capture them whole, as with 'tcpdump -s 0'");
  note(counters_.malformed_packets, "packets have lengths that contradict each other");
  note(counters_.malformed_sacn, "datagrams violate sACN");
  note(counters_.malformed_artnet, "datagrams violate Art-Net");
  note(counters_.sync, "synchronisation packets: frames have the time of their arrival, not of their release");
  note(counters_.discovery, "datagrams of discovery, polls and answers");
  note(counters_.priorities, "sACN frames of per-address priorities; a log holds levels only");
  note(counters_.other_start_code, "sACN frames of other start codes; a log holds levels only");
  note(counters_.preview, "sACN frames are previews, meant for visualisers");
  note(counters_.late, "frames were late or duplicate, by their sequence numbers");
  note(counters_.ended_already, "sACN packets repeat the end of a stream");
  return notes;
}

}  // namespace footlight::drivers
