#include "drivers/sound/sound_device.h"

namespace footlight::drivers {

Result<std::unique_ptr<SoundDevice>> SoundDevice::open(const std::string& name) {
  return fail(ErrorCode::kUnsupported,
              "alsa:{}: this build reads no sound devices; install libasound2-dev, and build again",
              name.empty() ? "default" : name);
}

}  // namespace footlight::drivers
