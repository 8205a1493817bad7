// What a technician needs to know of a sound file before a show: its level, its clipping, and how far each band moves.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "fixtures/simulate/sound_levels.h"
#include "sim/core/result.h"
#include "sim/sound/audio_link.h"

namespace footlight::tools {

struct BandCheck {
  double from_hz = 0;
  double to_hz = 0;
  double mean = 0;  // of its level, 0 to 1
  double max = 0;
  double lit = 0;   // share of the time above 0.05
  double full = 0;  // at 0.99 and above
};

struct SoundCheck {
  std::string sound;
  std::string codec;
  int rate_hz = 0;
  int channels = 0;
  double duration_s = 0;
  double peak_db = 0;  // of the loudest sample, against full scale; -200 in silence
  double rms_db = 0;
  double dc = 0;                 // mean of all samples
  std::uint64_t clipped = 0;     // samples of a run of three or more at full scale
  std::uint64_t not_finite = 0;  // NaN and infinite samples
  std::uint64_t damaged_packets = 0;
  double silent = 0;          // share of the time below -60 dB
  double silent_start_s = 0;  // before the first sound
  double bpm = 0;             // the tempo found most often; 0: none
  double bpm_share = 0;       // of the time, with tempos within 2 percent
  std::uint64_t beats = 0;
  std::array<BandCheck, kSoundBands> bands{};
  std::vector<std::string> advice;  // whole sentences
};

// Errors: those of SoundFile.
[[nodiscard]] Result<SoundCheck> check_sound(const fixtures::SoundMap& map);

}  // namespace footlight::tools
