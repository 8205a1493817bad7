// libav (FFmpeg), loaded when the first sound file or video is opened.
//
// It brings a hundred libraries of codecs into a process. A bridge without sound files and videos loads none of them.
// The functions of libav that this program calls are defined in libav.cpp: they pass calls on to the loaded library, so
// callers include libav's headers and call it as usual. load_libav() comes first, in whatever opens a file or stream.
#pragma once

#include "sim/core/result.h"

namespace footlight::drivers {

// Loads the libraries of the versions that this program was built with. Errors: kUnsupported, with the packages that
// are missing. Any thread; the second call costs nothing.
[[nodiscard]] Status load_libav();

}  // namespace footlight::drivers
