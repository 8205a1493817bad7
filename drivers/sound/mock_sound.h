// A model of a sound device: a beat of 120 a minute with a bass, a chord and a hiss, the same each time.
//
// It has no clock: read() returns its samples at once, as ALSA's "null" does, and the caller waits.
#pragma once

#include <memory>

#include "drivers/sound/sound_device.h"

namespace footlight::drivers {

[[nodiscard]] std::unique_ptr<SoundDevice> make_mock_sound();

inline constexpr double kMockSoundBpm = 120;

}  // namespace footlight::drivers
