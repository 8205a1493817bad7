#include "drivers/sound/sound_file.h"

namespace footlight::drivers {

Result<std::unique_ptr<SoundFile>> SoundFile::open(const std::string& path) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build reads no sound files; install libavcodec-dev, libavformat-dev, libavutil-dev and "
              "libswscale-dev, and build again",
              path);
}

}  // namespace footlight::drivers
