// Reads a sound device: ALSA, whose "default" leads to PipeWire or PulseAudio where they run.
//
// The library is loaded when the first device is opened, and not before. Threads: none; read() blocks, so a device
// belongs to a thread of its own (tools/footlight/sound/live_sound.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/sound/sound_file.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

class SoundDevice {
 public:
  virtual ~SoundDevice() = default;
  // `name`: as `arecord -L` lists it; empty: "default". Errors: kNotFound, kPermission, kIo (it is in use, or has no
  // usable format), kUnsupported (this build or this machine has no ALSA).
  [[nodiscard]] static Result<std::unique_ptr<SoundDevice>> open(const std::string& name);
  [[nodiscard]] virtual const SoundInfo& info() const = 0;
  // Replaces `interleaved` by the samples that have come; waits for them up to `timeout_ns`. Empty: none came. An error
  // means that the device is gone.
  virtual Status read(std::vector<float>& interleaved, DurationNs timeout_ns) = 0;
  // How often samples were lost because they were not read in time.
  [[nodiscard]] virtual std::uint64_t overruns() const = 0;
};

}  // namespace footlight::drivers
