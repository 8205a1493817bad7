// Where pictures go to and come from: files, windows, devices, streams. A VrslSink encodes for a PictureOutput, a
// VrslSource decodes what a PictureInput gives; both call them on a thread of their own, so that they may block.
//
// A new kind of target is one file with one of these classes, and a line in tools/footlight/vrsl/open_pictures.cpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/vrsl/grid.h"
#include "drivers/vrsl/picture.h"
#include "sim/core/clock.h"
#include "sim/core/endpoint.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// What a factory of outputs or inputs gets. It must refuse options that it does not use: unused_option().
struct PictureTarget {
  std::string endpoint;     // as the user wrote it; starts every error message
  std::string name;         // after "@": a file name, a device, a URL, a word
  double pictures_hz = 30;  // out: the rate of the pictures; in: of files that have none of their own
  int width = 0;            // out: of every picture
  int height = 0;
  bool overwrite = false;               // out: files may be replaced; the option of that name is not among `options`
  std::vector<EndpointOption> options;  // those that the grid does not use (vrsl_options.h)
  GridFormat grid;                      // as named; where it is searched for, only its planes are known
};

// The error for an option that neither the grid nor the target has.
[[nodiscard]] inline tl::unexpected<Error> unused_option(const PictureTarget& target, const std::string& key) {
  return fail(ErrorCode::kBadInput, "{}: \"{}\" is not an option of this target", target.endpoint, key);
}

// All calls on one thread; the destructor may run on another, after the last call.
class PictureOutput {
 public:
  PictureOutput() = default;
  PictureOutput(const PictureOutput&) = delete;
  PictureOutput& operator=(const PictureOutput&) = delete;
  virtual ~PictureOutput() = default;
  // Shows or writes one picture. time_ns: since the first one; grows. May block as long as the target needs. After an
  // error the next picture is tried again. A target that is gone for good says so with kDisconnected: a window that the
  // user closed. The message needs no endpoint.
  virtual Status show(const Picture& picture, DurationNs time_ns) = 0;
  // Ends a file; no picture follows. Not called after kDisconnected.
  virtual Status finish() { return {}; }
};

enum class PictureStep {
  kPicture,  // there is one
  kNothing,  // none within the time
  kEnd,      // none will follow
};

// All calls on one thread; the destructor may run on another, after the last call.
class PictureInput {
 public:
  PictureInput() = default;
  PictureInput(const PictureInput&) = delete;
  PictureInput& operator=(const PictureInput&) = delete;
  virtual ~PictureInput() = default;
  // The next picture, replacing the contents of `picture` and reusing its memory. Waits up to `wait_ns`. `time_ns`:
  // when it is due, since the first one; stays nullopt for live inputs, whose pictures are due when they come. An error
  // ends the input, except kProtocol (one damaged picture: it is left out) and kTimeout and kIo (called again a second
  // later).
  [[nodiscard]] virtual Result<PictureStep> next(Picture& picture, std::optional<DurationNs>& time_ns,
                                                 DurationNs wait_ns) = 0;
};

}  // namespace footlight::drivers
