#include "drivers/net/mvr_xchange_discovery.h"

namespace footlight::drivers {

Result<std::unique_ptr<MvrDiscovery>> open_mvr_discovery() {
  return fail(
      ErrorCode::kUnsupported,
      "this build does not search for MVR-xchange stations; name one with --station ADDRESS:PORT, or build with "
      "libavahi-client-dev installed");
}

}  // namespace footlight::drivers
