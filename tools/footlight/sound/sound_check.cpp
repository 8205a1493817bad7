#include "tools/footlight/sound/sound_check.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/footlight/sound/sound_log.h"

namespace footlight::tools {
namespace {

constexpr double kSilentDb = -60;
constexpr double kNothingDb = -200;
constexpr float kFullScale = 0.9999F;
constexpr int kClipRun = 3;
constexpr double kLit = 0.05;
constexpr double kFull = 0.99;

double decibels(double value) { return value > 1e-10 ? 20 * std::log10(value) : kNothingDb; }

// Sums over all samples, channel by channel.
class Samples {
 public:
  Samples(int rate_hz, int channels)
      : block_(static_cast<std::uint64_t>(rate_hz / kSoundStepsPerS * channels)),
        runs_(static_cast<std::size_t>(channels)) {}
  void add(std::span<const float> interleaved) {
    for (std::size_t i = 0; i < interleaved.size(); ++i) {
      const double before = power_;
      add(interleaved[i], runs_[i % runs_.size()]);
      block_power_ += power_ - before;
      if (count_ % block_ == 0) end_block();
    }
  }
  void finish(SoundCheck& check) const {
    const auto count = static_cast<double>(std::max<std::uint64_t>(count_, 1));
    check.peak_db = decibels(peak_);
    check.rms_db = decibels(std::sqrt(power_ / count));
    check.dc = sum_ / count;
    check.clipped = clipped_;
    check.not_finite = not_finite_;
    check.silent = static_cast<double>(silent_blocks_) / static_cast<double>(std::max<std::uint64_t>(blocks_, 1));
    const auto frames = static_cast<double>(started_ ? start_ : count_) / static_cast<double>(runs_.size());
    check.silent_start_s = frames / check.rate_hz;
  }

 private:
  // Of about a step: is it silent?
  void end_block() {
    ++blocks_;
    const bool silent = decibels(std::sqrt(block_power_ / static_cast<double>(block_))) < kSilentDb;
    silent_blocks_ += silent ? 1 : 0;
    if (!silent && !started_) start_ = count_ - block_;
    started_ = started_ || !silent;
    block_power_ = 0;
  }
  void add(float sample, int& run) {
    ++count_;
    if (!std::isfinite(sample)) {
      ++not_finite_;
      return;
    }
    sum_ += sample;
    power_ += static_cast<double>(sample) * sample;
    peak_ = std::max<double>(peak_, std::abs(sample));
    run = std::abs(sample) >= kFullScale ? run + 1 : 0;
    if (run == kClipRun) clipped_ += kClipRun;
    if (run > kClipRun) ++clipped_;
  }

  std::uint64_t block_;  // samples
  std::vector<int> runs_;
  std::uint64_t blocks_ = 0;
  std::uint64_t silent_blocks_ = 0;
  std::uint64_t start_ = 0;  // samples before the first block with sound
  bool started_ = false;
  double block_power_ = 0;
  std::uint64_t count_ = 0;
  std::uint64_t clipped_ = 0;
  std::uint64_t not_finite_ = 0;
  double sum_ = 0;
  double power_ = 0;
  double peak_ = 0;
};

// The tempo that most steps have, within 2 percent.
void find_tempo(const std::map<int, std::uint64_t>& tenths, std::uint64_t steps, SoundCheck& check) {
  std::uint64_t most = 0;
  for (const auto& [tenth, count] : tenths) {
    std::uint64_t near = 0;
    double weighted = 0;
    for (const auto& [other, others] : tenths) {
      if (std::abs(other - tenth) * 50 > tenth) continue;
      near += others;
      weighted += static_cast<double>(others) * other;
    }
    if (near <= most) continue;
    most = near;
    check.bpm = weighted / static_cast<double>(near) / 10;
    check.bpm_share = static_cast<double>(near) / static_cast<double>(steps);
  }
}

void advise(SoundCheck& check) {
  auto& advice = check.advice;
  if (check.clipped > 0) advice.emplace_back("The sound is clipped; lower the level where it was recorded.");
  if (check.not_finite > 0) advice.emplace_back("Samples that are not numbers count as silence.");
  if (std::abs(check.dc) > 0.01) advice.emplace_back("The sound has a constant part, which the bands ignore.");
  if (check.peak_db <= kSilentDb) advice.emplace_back("The file is silent.");
  for (std::size_t band = 0; band < check.bands.size() && check.peak_db > kSilentDb; ++band) {
    const BandCheck& one = check.bands[band];
    const std::string& name = fixtures::sound_signal_words()[band];
    if (one.max < 0.5) advice.push_back(fmt::format("{} never reaches a half: lower its threshold.", name));
    if (one.full > 0.5)
      advice.push_back(fmt::format("{} is mostly full: raise its threshold, or lower the gain.", name));
  }
}

}  // namespace

Result<SoundCheck> check_sound(const fixtures::SoundMap& map) {
  FL_ASSIGN(const auto file, drivers::SoundFile::open(map.sound));
  SoundCheck check;
  check.sound = map.sound;
  check.codec = file->info().codec;
  check.rate_hz = file->info().rate_hz;
  check.channels = file->info().channels;
  Samples samples(check.rate_hz, check.channels);
  std::map<int, std::uint64_t> tenths;
  std::uint64_t steps = 0;
  const auto on_step = [&](const AudioLinkState& state) {
    ++steps;
    if (state.beat.bpm > 0) ++tenths[static_cast<int>(std::lround(state.beat.bpm * 10))];
    check.beats = state.beat.count;
    for (std::size_t band = 0; band < check.bands.size(); ++band) {
      const double now = state.bands[band][0];
      check.bands[band].mean += now;
      check.bands[band].max = std::max(check.bands[band].max, now);
      check.bands[band].lit += now > kLit ? 1 : 0;
      check.bands[band].full += now >= kFull ? 1 : 0;
    }
  };
  FL_ASSIGN(const std::uint64_t frames, run_sound_file(*file, map.link, on_step, [&](std::span<const float> piece) {
              samples.add(piece);
              return true;
            }));
  samples.finish(check);
  check.duration_s = static_cast<double>(frames) / check.rate_hz;
  check.damaged_packets = file->damaged_packets();
  const auto count = static_cast<double>(std::max<std::uint64_t>(steps, 1));
  for (int band = 0; band < kSoundBands; ++band) {
    BandCheck& one = check.bands[static_cast<std::size_t>(band)];
    const BandRange range = band_range(map.link, band);
    one.from_hz = range.from_hz;
    one.to_hz = range.to_hz;
    one.mean /= count;
    one.lit /= count;
    one.full /= count;
  }
  find_tempo(tenths, std::max<std::uint64_t>(steps, 1), check);
  advise(check);
  return check;
}

}  // namespace footlight::tools
