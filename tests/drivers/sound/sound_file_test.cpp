#include "drivers/sound/sound_file.h"

#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>

#include <doctest/doctest.h>

#include "sim/sound/audio_link.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wav_bytes.h"

namespace footlight::drivers {
namespace {

using testing::must;
using testing::wav_bytes;
using testing::WavForm;

std::vector<float> ramp(std::size_t count) {
  std::vector<float> samples;
  for (std::size_t i = 0; i < count; ++i) samples.push_back(static_cast<float>(static_cast<int>(i % 199) - 99) / 100);
  return samples;
}

std::vector<float> read_all(SoundFile& file) {
  std::vector<float> all;
  std::vector<float> piece;
  while (must(file.read(piece))) all.insert(all.end(), piece.begin(), piece.end());
  return all;
}

std::string refusal(const std::string& path, ErrorCode code) {
  const auto file = SoundFile::open(path);
  REQUIRE_FALSE(file.has_value());
  CHECK(file.error().code == code);
  CHECK(file.error().message.find(path) == 0);
  return file.error().message;
}

TEST_CASE("samples of every form and number of channels are read within half a step of the form") {
  const testing::TempFolder folder;
  const std::vector<float> samples = ramp(8 * 3'000);
  const double steps[] = {0.5 / 128, 0.5 / 32'768, 0.5 / 8'388'608, 1e-7, 0, 0};
  for (const WavForm form :
       {WavForm::kU8, WavForm::kS16, WavForm::kS24, WavForm::kS32, WavForm::kFloat, WavForm::kDouble}) {
    for (const int channels : {1, 2, 8}) {
      const auto file = must(SoundFile::open(folder.write("a.wav", wav_bytes(samples, 22'050, channels, form))));
      CHECK(file->info().rate_hz == 22'050);
      CHECK(file->info().channels == channels);
      const std::vector<float> read = read_all(*file);
      REQUIRE(read.size() == samples.size());
      double worst = 0;
      for (std::size_t i = 0; i < read.size(); ++i) worst = std::max<double>(worst, std::abs(read[i] - samples[i]));
      CAPTURE(static_cast<int>(form));
      CHECK(worst <= steps[static_cast<int>(form)]);
      CHECK(file->damaged_packets() == 0);
    }
  }
}

TEST_CASE("rates from 8 to 192 kHz and 1 to 8 channels are read as they are in the file") {
  const testing::TempFolder folder;
  for (const int rate_hz : {8'000, 11'025, 44'100, 48'000, 96'000, 192'000}) {
    for (int channels = 1; channels <= 8; ++channels) {
      CAPTURE(rate_hz);
      CAPTURE(channels);
      const auto frames = static_cast<std::size_t>(100);
      const std::vector<float> samples = ramp(frames * static_cast<std::size_t>(channels));
      const auto file = must(SoundFile::open(folder.write("a.wav", wav_bytes(samples, rate_hz, channels))));
      CHECK(file->info().rate_hz == rate_hz);
      CHECK(file->info().channels == channels);
      CHECK(read_all(*file).size() == samples.size());
    }
  }
}

TEST_CASE("a file that is cut off is read up to its end") {
  const testing::TempFolder folder;
  const std::string whole = wav_bytes(ramp(40'000), 44'100, 2);
  const auto file = must(SoundFile::open(folder.write("cut.wav", whole.substr(0, whole.size() / 2))));
  const std::size_t read = read_all(*file).size();
  CHECK(read >= 19'000);
  CHECK(read <= 20'000);
}

TEST_CASE("files without sound, folders, devices and odd rates are refused with their name and the reason") {
  const testing::TempFolder folder;
  refusal(folder.file("nothing.wav"), ErrorCode::kNotFound);
  refusal(folder.path().string(), ErrorCode::kBadInput);
  refusal("/dev/zero", ErrorCode::kBadInput);
  refusal(folder.write("text.wav", "this is no sound at all, but it is long enough to be tested as one"),
          ErrorCode::kBadInput);
  refusal(folder.write("empty.wav", ""), ErrorCode::kBadInput);
  CHECK(refusal(folder.write("slow.wav", wav_bytes(ramp(4'000), 4'000, 1)), ErrorCode::kBadInput)
            .find("8000 to 192000") != std::string::npos);
  CHECK(refusal(folder.write("fast.wav", wav_bytes(ramp(4'000), 384'000, 1)), ErrorCode::kBadInput).find("384000") !=
        std::string::npos);
  CHECK(refusal(folder.write("wide.wav", wav_bytes(ramp(10 * 400), 44'100, 10)), ErrorCode::kBadInput)
            .find("10 channels") != std::string::npos);
}

TEST_CASE("samples that are not numbers are passed on as they are in the file") {
  const testing::TempFolder folder;
  std::vector<float> samples = ramp(4'000);
  samples[100] = std::numeric_limits<float>::quiet_NaN();
  samples[200] = std::numeric_limits<float>::infinity();
  const auto file = must(SoundFile::open(folder.write("nan.wav", wav_bytes(samples, 8'000, 1, WavForm::kFloat))));
  const std::vector<float> read = read_all(*file);
  REQUIRE(read.size() == samples.size());
  CHECK(std::isnan(read[100]));
  CHECK(std::isinf(read[200]));
}

// Songs of Debian's package fretsonfire-songs-sectoid, under a free licence.
TEST_CASE("twenty seconds of real songs move every band, have a tempo, and give the same states each time") {
  const std::filesystem::path songs = "/usr/share/games/fretsonfire/data/songs";
  std::error_code missing;
  int count = 0;
  for (std::filesystem::recursive_directory_iterator at(songs, missing), end; !missing && at != end;
       at.increment(missing)) {
    if (at->path().filename() != "song.ogg") continue;
    CAPTURE(at->path().string());
    ++count;
    std::array<float, kSoundBands> most{}, least{1, 1, 1, 1};
    int beats = 0;
    double bpm = 0;
    std::array<std::uint64_t, 2> sums{};
    for (std::uint64_t& sum : sums) {
      const auto file = must(SoundFile::open(at->path().string()));
      AudioLink link({}, file->info().rate_hz, file->info().channels);
      std::vector<float> samples;
      while (link.frames() < 20U * static_cast<unsigned>(file->info().rate_hz) && must(file->read(samples))) {
        link.push(samples, [&](const AudioLinkState& state) {
          beats += state.beat.is_beat ? 1 : 0;
          bpm = state.beat.bpm;
          for (std::size_t band = 0; band < most.size(); ++band) {
            const float level = state.bands[band][0];
            sum = sum * 31 + std::bit_cast<std::uint32_t>(level);
            if (state.step < 450) continue;  // the song has begun
            most[band] = std::max(most[band], level);
            least[band] = std::min(least[band], level);
          }
        });
      }
      CHECK(file->damaged_packets() == 0);
    }
    CHECK(sums[0] == sums[1]);
    for (std::size_t band = 0; band < most.size(); ++band) {
      CHECK(most[band] > 0.5F);
      CHECK(most[band] - least[band] > 0.3F);
    }
    CHECK(bpm >= 55);
    CHECK(bpm <= 200);
    CHECK(beats > 10);
  }
  if (count == 0) MESSAGE("SKIPPED: the package fretsonfire-songs-sectoid is not installed");
}

}  // namespace
}  // namespace footlight::drivers
