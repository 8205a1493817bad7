// Packets of a network, as they were captured, to the frames that a source listening there would have given: sACN and
// Art-Net, each sender by itself, before any merge. Bytes only, no file, no library.
//
// Told by their first bytes and not by their UDP port. Left out as a source leaves it out: previews, datagrams that
// come late or twice (a capture on all interfaces sees one datagram several times), the second and third of three that
// end a stream. Left out because a log holds levels: start codes other than 0, per-address priorities (0xDD) among
// them. Synchronisation is not played: a frame counts when it came, not when a synchronisation packet released it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/capture/packet_walk.h"
#include "drivers/net/sequence.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

struct NetCaptureOptions {
  bool sacn = true;
  bool artnet = true;
  bool hear_preview = false;  // sACN: frames for visualisers, too
};

struct NetCaptureCounters {
  std::uint64_t packets = 0;
  std::uint64_t frames = 0;  // given
  // The rest is what was not.
  std::uint64_t not_udp = 0;
  std::uint64_t fragments = 0;
  std::uint64_t cut_short = 0;
  std::uint64_t malformed_packets = 0;
  std::uint64_t other_datagrams = 0;  // UDP, neither sACN nor Art-Net
  std::uint64_t other_protocol = 0;   // sACN or Art-Net that was not asked for
  std::uint64_t malformed_sacn = 0;
  std::uint64_t malformed_artnet = 0;
  std::uint64_t sync = 0;
  std::uint64_t discovery = 0;   // sACN's, and Art-Net's polls and answers
  std::uint64_t priorities = 0;  // start code 0xDD
  std::uint64_t other_start_code = 0;
  std::uint64_t preview = 0;
  std::uint64_t late = 0;
  std::uint64_t ended_already = 0;
};

class NetCapture {
 public:
  explicit NetCapture(const NetCaptureOptions& options = {}) : options_(options) {}

  // One packet, in the order of the capture. `cut`: it was longer on the wire. True where it gave a frame, whose slots
  // look into `packet`.
  bool take(TimeNs stamp_ns, LinkLayer link, std::span<const std::uint8_t> packet, bool cut, FrameView& frame);
  [[nodiscard]] const NetCaptureCounters& counters() const { return counters_; }
  // What was left out, a line for each reason.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  bool take_sacn(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame);
  bool take_artnet(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame);

  NetCaptureOptions options_;
  NetCaptureCounters counters_;
  std::map<std::pair<bool, Universe>, SequenceFilter> filters_;  // sACN or not, universe on the wire
};

}  // namespace footlight::drivers
