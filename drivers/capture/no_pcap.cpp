// Replaces pcap_input.cpp in builds without libpcap.
#include "drivers/capture/captures.h"

namespace footlight::drivers {

Result<std::unique_ptr<LogInput>> open_pcap(const std::string& path, const CaptureOptions&) {
  return fail(ErrorCode::kUnsupported, "{}: this build reads no packet captures; build it with libpcap-dev installed",
              path);
}

}  // namespace footlight::drivers
