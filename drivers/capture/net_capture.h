// Converts captured network packets to the frames that a source in that network would deliver: sACN and Art-Net, per
// sender, before any merge. Bytes only, no file, no library.
//
// Protocols are recognised by their first bytes, not by the UDP port. As in a source, these are left out: previews,
// late and duplicate datagrams (a capture on all interfaces contains a datagram several times), the second and third
// packet that end a stream. A log holds levels, so start codes other than 0 are left out too, including per-address
// priorities (0xDD). Synchronisation is not replayed: a frame has the time of its arrival, not of the synchronisation
// packet that released it.
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
  bool hear_preview = false;  // sACN: also frames for visualisers
};

struct NetCaptureCounters {
  std::uint64_t packets = 0;
  std::uint64_t frames = 0;  // delivered
  // The other counters are of packets without a frame.
  std::uint64_t not_udp = 0;
  std::uint64_t fragments = 0;
  std::uint64_t cut_short = 0;
  std::uint64_t malformed_packets = 0;
  std::uint64_t other_datagrams = 0;  // UDP, neither sACN nor Art-Net
  std::uint64_t other_protocol = 0;   // sACN or Art-Net, but not selected in the options
  std::uint64_t malformed_sacn = 0;
  std::uint64_t malformed_artnet = 0;
  std::uint64_t sync = 0;
  std::uint64_t discovery = 0;   // sACN discovery, and Art-Net polls and replies
  std::uint64_t priorities = 0;  // start code 0xDD
  std::uint64_t other_start_code = 0;
  std::uint64_t preview = 0;
  std::uint64_t late = 0;
  std::uint64_t ended_already = 0;
};

class NetCapture {
 public:
  explicit NetCapture(const NetCaptureOptions& options = {}) : options_(options) {}

  // Takes one packet, in the order of the capture. `cut`: it was longer on the wire. True: `frame` is valid; its slots
  // refer to `packet`.
  bool take(TimeNs stamp_ns, LinkLayer link, std::span<const std::uint8_t> packet, bool cut, FrameView& frame);
  [[nodiscard]] const NetCaptureCounters& counters() const { return counters_; }
  // What was left out, one line per reason.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  bool take_sacn(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame);
  bool take_artnet(TimeNs stamp_ns, const UdpDatagram& datagram, FrameView& frame);

  NetCaptureOptions options_;
  NetCaptureCounters counters_;
  std::map<std::pair<bool, Universe>, SequenceFilter> filters_;  // key: sACN or not, universe on the wire
};

}  // namespace footlight::drivers
