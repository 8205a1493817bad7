// In place of pcap_input.cpp where libpcap is not there.
#include "drivers/capture/captures.h"

namespace footlight::drivers {

Result<std::unique_ptr<LogInput>> open_pcap(const std::string& path, const CaptureOptions&) {
  return fail(ErrorCode::kUnsupported, "{}: this build reads no packet captures; build it with libpcap-dev installed",
              path);
}

}  // namespace footlight::drivers
