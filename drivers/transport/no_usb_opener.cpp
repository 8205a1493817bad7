// Takes the place of libusb_opener.cpp in a build without libusb.
#include "drivers/transport/libusb_opener.h"

namespace footlight::drivers {

bool built_with_usb() { return false; }

Result<std::unique_ptr<Opener>> make_libusb_opener(LibusbConfig config, Clock&) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no USB; install libusb-1.0-0-dev and configure with -DFOOTLIGHT_USB=ON",
              config.chooser->driver_id());
}

}  // namespace footlight::drivers
