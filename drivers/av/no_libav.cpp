#include "drivers/av/libav.h"

namespace footlight::drivers {

Status load_libav() {
  return fail(ErrorCode::kUnsupported, "this build has no libav, which sound files and videos need");
}

}  // namespace footlight::drivers
