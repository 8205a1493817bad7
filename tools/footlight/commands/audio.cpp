// footlight audio: what is in a sound, and AudioLink's texture of it.
#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "fixtures/gobos/png.h"
#include "sim/core/counted.h"
#include "sim/core/endpoint.h"
#include "sim/sound/audio_texture.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/pictures/numbered_file.h"
#include "tools/footlight/sound/sound_check.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/sound/texture_stream.h"

namespace footlight::tools {
namespace {

constexpr const char* kSoundHelp = "a sound file (FLAC, WAV, MP3, Ogg ...) or a sound map (.toml)";
constexpr int kPicturesMax = 100'000;

// A sound file stands for a map with AudioLink's own settings.
Result<fixtures::SoundMap> map_or_sound(const std::string& path, const char* command, bool device_too = false) {
  if (path.empty()) {
    return fail(ErrorCode::kBadInput, "audio {}: expected a sound file or map, for example 'footlight audio {} {}'",
                command, command, "track.flac");
  }
  FL_ASSIGN(fixtures::SoundMap map, is_sound_log(path) ? sound_map_of(path) : fixtures::plain_sound_map(path, 1, 1));
  if (is_sound_device(map.sound) && !device_too) {
    return fail(ErrorCode::kBadInput, "{}: {} is a device; expected a sound file", path, map.sound);
  }
  return map;
}

std::string json_of(const SoundCheck& check) {
  nlohmann::ordered_json bands;
  for (std::size_t i = 0; i < check.bands.size(); ++i) {
    const BandCheck& band = check.bands[i];
    bands.push_back({{"band", fixtures::sound_signal_words()[i]},
                     {"from_hz", band.from_hz},
                     {"to_hz", band.to_hz},
                     {"mean", band.mean},
                     {"max", band.max},
                     {"lit_share", band.lit},
                     {"full_share", band.full}});
  }
  const nlohmann::ordered_json json = {{"sound", check.sound},
                                       {"codec", check.codec},
                                       {"rate_hz", check.rate_hz},
                                       {"channels", check.channels},
                                       {"duration_s", check.duration_s},
                                       {"peak_db", check.peak_db},
                                       {"rms_db", check.rms_db},
                                       {"dc", check.dc},
                                       {"clipped_samples", check.clipped},
                                       {"not_finite_samples", check.not_finite},
                                       {"damaged_packets", check.damaged_packets},
                                       {"silent_share", check.silent},
                                       {"silent_start_s", check.silent_start_s},
                                       {"bpm", check.bpm},
                                       {"bpm_share", check.bpm_share},
                                       {"beats", check.beats},
                                       {"bands", bands},
                                       {"advice", check.advice}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void print(const SoundCheck& check) {
  fmt::print("{}\n", check.sound);
  fmt::print("  sound:    {}, {} Hz, {} channel{}, {}\n", check.codec, check.rate_hz, check.channels,
             check.channels == 1 ? "" : "s", show_duration(std::llround(check.duration_s * 1e9)));
  fmt::print("  level:    peak {:.1f} dB, mean {:.1f} dB, constant part {:.4f}\n", check.peak_db, check.rms_db,
             check.dc);
  fmt::print("  clipping: {} samples at full scale\n", check.clipped);
  fmt::print("  silence:  {:.1f} % of the time, {:.2f} s before the first sound\n", 100 * check.silent,
             check.silent_start_s);
  if (check.bpm > 0) {
    fmt::print("  tempo:    {:.1f} beats a minute for {:.0f} % of the time; {} beats\n", check.bpm,
               100 * check.bpm_share, check.beats);
  } else {
    fmt::print("  tempo:    none found\n");
  }
  fmt::print("  band           from Hz    to Hz   mean    max    lit   full\n");
  for (std::size_t i = 0; i < check.bands.size(); ++i) {
    const BandCheck& band = check.bands[i];
    fmt::print("  {:<12} {:9.0f} {:8.0f} {:6.2f} {:6.2f} {:4.0f} % {:4.0f} %\n", fixtures::sound_signal_words()[i],
               band.from_hz, band.to_hz, band.mean, band.max, 100 * band.lit, 100 * band.full);
  }
  if (check.not_finite > 0) fmt::print("  {} samples are not numbers\n", check.not_finite);
  if (check.damaged_packets > 0) fmt::print("  {} packets are damaged\n", check.damaged_packets);
  for (const std::string& line : check.advice) fmt::print("  note: {}\n", line);
}

struct CheckOptions {
  std::string file;
  bool json = false;
};

Result<int> check(const CheckOptions& options) {
  FL_ASSIGN(const fixtures::SoundMap map, map_or_sound(options.file, "check"));
  FL_ASSIGN(const SoundCheck found, check_sound(map));
  if (options.json) {
    fmt::print("{}\n", json_of(found));
  } else {
    print(found);
  }
  return kExitOk;
}

struct TextureOptions {
  std::string file;
  std::string out;
  DurationNs at_ns = -1;
  DurationNs every_ns = -1;
  DurationNs for_ns = -1;
  int scale = 1;
};

Status write_texture(const AudioLinkState& state, const fixtures::SoundMap& map, const std::string& path) {
  std::vector<std::uint8_t> bytes;
  for (const float value : audio_texture(state, map.theme)) {
    bytes.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255)));
  }
  const auto png = fixtures::png_of(kAudioTextureWidth, kAudioTextureHeight, 4, bytes);
  return write_picture(path, png);
}

// "frame_%04d.png" with a number.
Result<std::string> numbered(const std::string& pattern, int number) {
  const std::size_t at = pattern.find('%');
  if (at != std::string::npos && pattern.compare(at, 4, "%04d") == 0) {
    return pattern.substr(0, at) + fmt::format("{:04}", number) + pattern.substr(at + 4);
  }
  return fail(ErrorCode::kBadInput, "-o {}: expected a name with %04d, as in frame_%04d.png", pattern);
}

Status check_texture_options(const TextureOptions& options) {
  if ((options.at_ns < 0) == (options.every_ns < 0)) {
    return fail(ErrorCode::kBadInput, "audio texture: expected --at for one picture or --every for many");
  }
  if (options.every_ns == 0) return fail(ErrorCode::kBadInput, "--every: expected more than 0");
  if (options.scale != 1 || options.for_ns >= 0) {
    return fail(ErrorCode::kBadInput, "-o {}: --scale and --for are for streams, as in texture.mkv", options.out);
  }
  if (options.every_ns > 0) FL_TRY(numbered(options.out, 0));
  return {};
}

Result<int> stream_texture(const TextureOptions& options) {
  if (options.out.empty() || options.at_ns >= 0 || options.every_ns < 0) {
    return fail(ErrorCode::kBadInput,
                "audio texture: expected -o texture.png with --at, -o texture_%04d.png or a stream with --every, as in "
                "-o texture.mkv --every 40ms");
  }
  FL_ASSIGN(const fixtures::SoundMap map, map_or_sound(options.file, "texture", true));
  catch_end_signals();
  FL_ASSIGN(const std::uint64_t count,
            write_texture_stream(map, {options.out, options.every_ns, options.for_ns, options.scale},
                                 [] { return end_signal_came(); }));
  // Standard output may be the stream.
  fmt::print(stderr, "{}: {} of {}x{}\n", options.out, counted(count, "picture"), kAudioTextureWidth * options.scale,
             kAudioTextureHeight * options.scale);
  return kExitOk;
}

Result<int> texture(const TextureOptions& options) {
  if (!options.out.ends_with(".png")) return stream_texture(options);
  FL_TRY(check_texture_options(options));
  FL_ASSIGN(const fixtures::SoundMap map, map_or_sound(options.file, "texture"));
  FL_ASSIGN(const auto file, drivers::SoundFile::open(map.sound));
  Status written;
  int count = 0;
  TimeNs due_ns = std::max<TimeNs>(options.at_ns, 0);
  bool more = true;
  AudioLinkState before;  // the state at a time is that of the last step at or before it
  const auto store = [&]() -> Status {
    std::string path = options.out;
    if (options.every_ns > 0) {
      FL_ASSIGN(path, numbered(options.out, count));
    }
    ++count;
    return write_texture(before, map, path);
  };
  const auto on_step = [&](const AudioLinkState& state) {
    while (more && written && step_time_ns(state.step) > due_ns) {
      written = store();
      more = options.every_ns > 0 && count < kPicturesMax;
      due_ns += std::max<DurationNs>(options.every_ns, 0);
    }
    before = state;
  };
  FL_ASSIGN(const std::uint64_t frames, run_sound_file(*file, map.link, on_step, [&](std::span<const float>) {
              return more && written.has_value();
            }));
  FL_TRY(written);
  const DurationNs length_ns = std::llround(static_cast<double>(frames) / file->info().rate_hz * 1e9);
  if (more && due_ns <= length_ns) FL_TRY(store());
  if (count == 0) {
    return fail(ErrorCode::kBadInput, "--at {}: {} ends at {}", show_duration(options.at_ns), map.sound,
                show_duration(length_ns));
  }
  fmt::print("{}: {} picture{} of {}x{}\n", options.out, count, count == 1 ? "" : "s", kAudioTextureWidth,
             kAudioTextureHeight);
  return kExitOk;
}

void add(Arguments& arguments) {
  Arguments checker = arguments.subcommand("check", "Print level, clipping, tempo, and how far each band moves",
                                           "  footlight audio check track.flac\n"
                                           "  footlight audio check map.toml --json\n");
  auto check_options = std::make_shared<CheckOptions>();
  checker.word("FILE", check_options->file, kSoundHelp);
  checker.flag("--json", check_options->json, "one JSON object");
  checker.job([check_options]() -> Result<int> { return check(*check_options); });

  Arguments painter =
      arguments.subcommand("texture", "Write AudioLink's texture of a sound as PNG or as a stream",
                           "  footlight audio texture track.flac --at 12.5s -o texture.png\n"
                           "  footlight audio texture track.flac --every 40ms -o texture_%04d.png\n"
                           "  footlight audio texture track.flac --every 16.667ms -o 'texture.mkv?lossless=yes'\n"
                           "  footlight audio texture audio:alsa:default=1.1 --every 20ms --scale 8 -o /dev/video9\n");
  auto texture_options = std::make_shared<TextureOptions>();
  painter.word("FILE", texture_options->file,
               "a sound file, a sound map (.toml) or, for streams, audio:alsa:DEVICE=1.1");
  painter.option("--out,-o", texture_options->out, "FILE",
                 "texture.png, texture_%04d.png, or a stream: texture.mkv, -, a pipe, /dev/video9, window");
  painter.duration("--at", texture_options->at_ns, "one picture, at this time of the sound");
  painter.duration("--every", texture_options->every_ns, "many pictures, at this interval");
  painter.duration("--for", texture_options->for_ns, "end a stream after this time");
  painter.option("--scale", texture_options->scale, 1, 16, "pixels of a texel of a stream, in both directions [1]");
  painter.job([texture_options]() -> Result<int> { return texture(*texture_options); });
}

}  // namespace

extern const CommandInfo audio_command{
    .name = "audio",
    .help = "Check sound files, and write AudioLink's texture of them",
    .examples =
        "  footlight audio check track.flac\n"
        "  footlight audio texture track.flac --at 12.5s -o texture.png\n"
        "Sound drives lights through a sound map (docs/sound.md):\n"
        "  footlight render rig.toml --log map.toml --at 12.5s -o frame.png\n"
        "  footlight run --in audio:track.flac=1.25 --out sacn:1\n",
    .add = add,
};

}  // namespace footlight::tools
