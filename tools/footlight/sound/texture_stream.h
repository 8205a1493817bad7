// AudioLink's texture of a sound as a stream of pictures: a video, a pipe, a video device or a window.
#pragma once

#include <functional>
#include <string>

#include "drivers/vrsl/picture.h"
#include "fixtures/simulate/sound_levels.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"
#include "sim/sound/audio_link.h"

namespace footlight::tools {

struct TextureStream {
  std::string target;  // "texture.mkv?lossless=yes": a target of vrsl endpoints, with its options
  DurationNs every_ns = 0;
  DurationNs length_ns = -1;  // of the stream; -1: until the sound ends or it is stopped
  int scale = 1;              // pixels of a texel in both directions, 1 to 16
};

// Texels from 0 to 1 as 0 to 255; AudioLink's fourth number has no place in a video.
void paint_texture(const std::vector<float>& texture, int scale, drivers::Picture& picture);

// Writes the stream of a sound file or a device and returns the number of pictures. Videos and numbered pictures are
// written as fast as they can be; all other targets get each picture at its time. `stopping` ends it. A sound that ends
// with an error leaves a whole video of what came before. Errors: those of the target and of the sound, kBadInput for a
// rate or scale out of range.
[[nodiscard]] Result<std::uint64_t> write_texture_stream(const fixtures::SoundMap& map, const TextureStream& stream,
                                                         const std::function<bool()>& stopping);

}  // namespace footlight::tools
