// Takes the place of hid_opener.cpp in a build without hidapi.
#include "drivers/transport/hid_opener.h"

namespace footlight::drivers {

bool built_with_hid() { return false; }

Result<std::unique_ptr<Opener>> make_hid_opener(HidConfig config, Clock&) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no HID; install libhidapi-dev and configure with -DFOOTLIGHT_HID=ON",
              config.driver_id);
}

}  // namespace footlight::drivers
