// Opens captures as logs: packet captures (pcap, pcapng) with sACN or Art-Net, and sigrok captures (.sr) of a DMX line.
//
//   FL_ASSIGN(std::unique_ptr<LogInput> input, open_any_log("show.pcapng"));
//   FL_ASSIGN(ConvertReport report, convert_log(*input, "show.dmxlog"));
//
// Time 0 is the first packet or sample of the file. A packet capture takes its wall clock from the file. Frames are
// those on the wire, per sender, before any merge; input->notes() lists what was left out. Threads: none; one thread at
// a time.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/capture/dmx_line.h"
#include "drivers/capture/net_capture.h"
#include "sim/core/result.h"
#include "sim/dmx_log/log_input.h"

namespace footlight::drivers {

struct CaptureOptions {
  int universe_offset = 0;  // OLA Show: added to its universes
  NetCaptureOptions net;    // packet captures
  // sigrok: the probe, by its name or its number from 1. Empty: the probe with the most levels in its first two
  // seconds, as it is or inverted.
  std::string channel;
  bool inverted = false;  // the probe is on DMX-; only with `channel`
  Universe universe = 1;  // the universe of its frames
};

// Opens every format that detect_log_format() detects. Errors: those of the formats; kUnsupported if this build lacks
// the library for it.
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_any_log(const std::string& path,
                                                             const CaptureOptions& options = {});
// As open_any_log(), as a log to play or inspect: a DMX log stays in its file, other formats are read into memory.
[[nodiscard]] Result<LogReader> read_any_log(const std::string& path, const CaptureOptions& options = {});

[[nodiscard]] Result<std::unique_ptr<LogInput>> open_pcap(const std::string& path, const CaptureOptions& options);
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_sigrok(const std::string& path, const CaptureOptions& options);

// The timing of a line, frame by frame.
struct LineCaptureInfo {
  std::string channel;  // name of the probe
  bool inverted = false;
  double sample_rate_hz = 0.0;  // times are exact to one sample
  DurationNs duration_ns = 0;
  std::vector<LineFrameTiming> frames;  // valid and rejected, in order
  LineCounters counters;
  std::vector<std::string> notes;  // the channel used, what was rejected and why
};
// kBadInput if it is not a sigrok capture or contains no DMX.
[[nodiscard]] Result<LineCaptureInfo> read_line_timing(const std::string& path, const CaptureOptions& options = {});

}  // namespace footlight::drivers
