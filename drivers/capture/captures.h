// Captures as logs: packet captures (pcap, pcapng) that hold sACN or Art-Net, and sigrok's captures (.sr) of a DMX
// line.
//
//   FL_ASSIGN(std::unique_ptr<LogInput> input, open_any_log("show.pcapng"));
//   FL_ASSIGN(ConvertReport report, convert_log(*input, "show.dmxlog"));
//
// Time 0 is the first packet or sample of the file. A packet capture has its wall clock from the file. Frames are those
// that came over the wire, each sender by itself; input->notes() says what was left out. Threads: none; one thread at a
// time.
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
  // sigrok: which probe, by its name or its number from 1. Empty: the one that carries the most levels in its first two
  // seconds, as it is or inverted.
  std::string channel;
  bool inverted = false;  // the probe is on DMX-; only with `channel`
  Universe universe = 1;  // that its frames get
};

// Any format that detect_log_format() knows. Errors: those of the formats; kUnsupported where this build lacks the
// library for it.
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_any_log(const std::string& path,
                                                             const CaptureOptions& options = {});
// The same as a log to be played or looked into: a DMX log stays in its file, all else is read into memory.
[[nodiscard]] Result<LogReader> read_any_log(const std::string& path, const CaptureOptions& options = {});

[[nodiscard]] Result<std::unique_ptr<LogInput>> open_pcap(const std::string& path, const CaptureOptions& options);
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_sigrok(const std::string& path, const CaptureOptions& options);

// The timing of a line, frame by frame.
struct LineCaptureInfo {
  std::string channel;  // name of the probe
  bool inverted = false;
  double sample_rate_hz = 0.0;  // times are exact to one sample
  DurationNs duration_ns = 0;
  std::vector<LineFrameTiming> frames;  // sound and rejected, in order
  LineCounters counters;
  std::vector<std::string> notes;  // which channel, what was rejected and why
};
// kBadInput where it is no sigrok capture, or holds no DMX.
[[nodiscard]] Result<LineCaptureInfo> read_line_timing(const std::string& path, const CaptureOptions& options = {});

}  // namespace footlight::drivers
