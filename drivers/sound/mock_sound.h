// A model of a sound device: a beat of 120 a minute with a bass, a chord and a hiss, the same each time.
//
// As a card does, read() waits until its 10 ms of samples have been played.
#pragma once

#include <functional>
#include <memory>

#include "drivers/sound/sound_device.h"

namespace footlight::drivers {

// Returns at a time since its first call, or at once if that has passed. The first call is with 0.
using WaitUntil = std::function<void(DurationNs)>;

// `wait`: tests replace the steady clock.
[[nodiscard]] std::unique_ptr<SoundDevice> make_mock_sound(WaitUntil wait = {});

inline constexpr double kMockSoundBpm = 120;

}  // namespace footlight::drivers
