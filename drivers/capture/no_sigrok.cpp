// Replaces sigrok_file.cpp and line_input.cpp in builds without libzip.
#include "drivers/capture/captures.h"

namespace footlight::drivers {
namespace {

tl::unexpected<Error> no_libzip(const std::string& path) {
  return fail(ErrorCode::kUnsupported, "{}: this build reads no sigrok captures; build it with libzip-dev installed",
              path);
}

}  // namespace

Result<std::unique_ptr<LogInput>> open_sigrok(const std::string& path, const CaptureOptions&) {
  return no_libzip(path);
}
Result<LineCaptureInfo> read_line_timing(const std::string& path, const CaptureOptions&) { return no_libzip(path); }

}  // namespace footlight::drivers
