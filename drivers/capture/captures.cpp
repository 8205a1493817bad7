#include "drivers/capture/captures.h"

namespace footlight::drivers {

Result<std::unique_ptr<LogInput>> open_any_log(const std::string& path, const CaptureOptions& options) {
  FL_ASSIGN(const LogFormat format, detect_log_format(path));
  switch (format) {
    case LogFormat::kPacketCapture: return open_pcap(path, options);
    case LogFormat::kLineCapture: return open_sigrok(path, options);
    case LogFormat::kDmxLog:
    case LogFormat::kOlaShow:
    case LogFormat::kSound: break;
    case LogFormat::kVideo: break;
  }
  return open_log_input(path, options.universe_offset);
}

Result<LogReader> read_any_log(const std::string& path, const CaptureOptions& options) {
  FL_ASSIGN(const LogFormat format, detect_log_format(path));
  if (format == LogFormat::kDmxLog) return LogReader::open(path);
  FL_ASSIGN(const std::unique_ptr<LogInput> input, open_any_log(path, options));
  return read_into_memory(*input);
}

}  // namespace footlight::drivers
