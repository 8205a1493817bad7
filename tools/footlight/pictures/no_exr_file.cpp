// Stands in for exr_file.cpp in a build without OpenEXR.
#include "tools/footlight/pictures/exr_file.h"

namespace footlight::tools {

Result<fixtures::Bytes> exr_of(const render::RadianceImage&, const ExrHeader&) {
  return fail(ErrorCode::kUnsupported, "this build cannot write OpenEXR");
}

Status check_exr(const std::string& path) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build cannot write OpenEXR; install libopenexr-dev and build again, or write PNG: -o frame.png",
              path);
}

Status write_exr(const std::string& path, const render::RadianceImage&, const ExrHeader&) { return check_exr(path); }

}  // namespace footlight::tools
