// A sound device as a source of DMX: a thread reads it and computes the levels; the port delivers the newest ones.
//
// If the device vanishes, the port is gone, and the thread opens it again, at intervals that grow from 10 ms to 1 s.
// Threads: create(), poll() and the rest on the pump's thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/sound/sound_device.h"
#include "fixtures/simulate/sound_levels.h"
#include "sim/core/clock.h"
#include "sim/core/ports.h"

namespace footlight::tools {

using OpenSoundDevice = std::function<Result<std::unique_ptr<drivers::SoundDevice>>()>;

struct LiveSoundOptions {
  std::string name;  // the endpoint
  AudioLinkSettings link;
  bool wait_for_device = false;  // start without the device
  int priority = kPriorityDefault;
};

// How long to wait before the next read, so that a device without a clock of its own, such as ALSA's null and file, is
// read at its rate: what `frames` last beyond `elapsed_ns`, both since the device was opened. 0 up to 50 ms, and for a
// card whose clock is fast by up to 0.1 %.
[[nodiscard]] DurationNs read_pause_ns(std::uint64_t frames, int rate_hz, DurationNs elapsed_ns);

// Errors: those of `open`. If it waits for the device, only kUnsupported: no device can be opened later.
[[nodiscard]] Result<std::unique_ptr<Source>> make_live_sound(fixtures::SoundLevels levels, OpenSoundDevice open,
                                                              const LiveSoundOptions& options);

// The device of a map's `sound` or of an endpoint: is_sound_device() must be true.
[[nodiscard]] Result<std::unique_ptr<drivers::SoundDevice>> open_sound_device(const std::string& sound);

// Of a map whose sound is a device.
[[nodiscard]] Result<std::unique_ptr<Source>> open_live_sound(const fixtures::SoundMap& map,
                                                              const LiveSoundOptions& options);

}  // namespace footlight::tools
