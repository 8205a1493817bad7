// Sound as a log: the levels that a sound map makes of a sound file, as if they had been recorded.
//
// So a sound file can be played, converted, rendered and traced like any log, with the same frames each time. The map
// is a TOML file, or "audio:FILE=UNIVERSE.ADDRESS" (sim/core/endpoint.h). Threads: none; one thread at a time.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/capture/captures.h"
#include "drivers/sound/sound_file.h"
#include "fixtures/simulate/sound_levels.h"
#include "sim/dmx_log/log_input.h"
#include "sim/sound/audio_link.h"

namespace footlight::tools {

// True for "audio:..." and for names that end in ".toml": no other log has such a name.
[[nodiscard]] bool is_sound_log(const std::string& path);

// drivers::open_any_log() and read_any_log(), for sound maps too.
[[nodiscard]] Result<std::unique_ptr<LogInput>> open_level_log(const std::string& path,
                                                               const drivers::CaptureOptions& options = {});
// Whether it can be a log at all, without reading all of it: kBadInput for a rig, a definition and anything unknown.
[[nodiscard]] Status check_level_log(const std::string& path);
// A sound is analysed whole: after kLongSoundS of it a line on standard error says so. `stopping` is called meanwhile;
// true ends it with kTimeout.
[[nodiscard]] Result<LogReader> read_level_log(const std::string& path, const drivers::CaptureOptions& options = {},
                                               const std::function<bool()>& stopping = {});
inline constexpr int kLongSoundS = 600;

// The map that the text of an endpoint names. Errors: those of parse_endpoint() and load_sound_map().
[[nodiscard]] Result<fixtures::SoundMap> sound_map_of(const std::string& path);
// The levels of a map, with the rig of its lights.
[[nodiscard]] Result<fixtures::SoundLevels> sound_levels_of(const fixtures::SoundMap& map);

// Runs a sound file from where it is through an AudioLink, and returns the number of frames. `on_samples` gets each
// piece of samples before its steps; false ends the run.
[[nodiscard]] Result<std::uint64_t> run_sound_file(drivers::SoundFile& file, const AudioLinkSettings& settings,
                                                   const AudioLink::OnStep& on_step,
                                                   const std::function<bool(std::span<const float>)>& on_samples);

}  // namespace footlight::tools
