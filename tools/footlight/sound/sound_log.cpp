#include "tools/footlight/sound/sound_log.h"

#include <cstdio>
#include <deque>

#include "fixtures/files/definition_list.h"
#include "fixtures/files/import/import_rig.h"
#include "fixtures/files/toml/sound_toml.h"
#include "sim/core/endpoint.h"
#include "sim/file_kind.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

constexpr std::string_view kScheme = "audio:";

class SoundInput final : public LogInput {
 public:
  SoundInput(std::string path, std::unique_ptr<drivers::SoundFile> file, const fixtures::SoundMap& map,
             fixtures::SoundLevels levels, std::function<bool(double)> on_seconds)
      : path_(std::move(path)),
        file_(std::move(file)),
        link_(map.link, file_->info().rate_hz, file_->info().channels),
        levels_(std::move(levels)),
        on_seconds_(std::move(on_seconds)) {
    for (const auto& [universe, slots] : levels_.universes()) universes_.push_back(universe);
    keep(0);
  }

  [[nodiscard]] LogFormat format() const override { return LogFormat::kSound; }
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] std::vector<Universe> universes() const override { return universes_; }
  [[nodiscard]] std::uint64_t damage_count() const override { return file_->damaged_packets(); }
  [[nodiscard]] TimeNs end_ns() const override {
    return static_cast<TimeNs>(static_cast<double>(link_.frames()) * 1e9 / file_->info().rate_hz);
  }
  [[nodiscard]] std::vector<std::string> notes() const override {
    if (file_->damaged_packets() == 0) return {};
    return {fmt::format("{} packets of the sound are damaged and left out", file_->damaged_packets())};
  }

  Result<bool> next(FrameView& frame) override {
    if (given_) waiting_.pop_front();
    given_ = false;
    while (waiting_.empty()) {
      if (on_seconds_ && !on_seconds_(static_cast<double>(end_ns()) * 1e-9))
        return fail(ErrorCode::kTimeout, "{}: stopped while the sound was analysed", path_);
      FL_ASSIGN(const bool more, file_->read(samples_));
      if (!more) return false;
      link_.push(samples_, [this](const AudioLinkState& state) {
        levels_.step(state);
        keep(step_time_ns(state.step));
      });
    }
    const Waiting& one = waiting_.front();
    frame = FrameView{};
    frame.universe = one.universe;
    frame.stamp_ns = one.stamp_ns;
    frame.slots = one.slots;
    given_ = true;
    return true;
  }

 private:
  struct Waiting {
    Universe universe = 0;
    TimeNs stamp_ns = 0;
    fixtures::SoundLevels::Slots slots{};
  };
  void keep(TimeNs stamp_ns) {
    for (const auto& [universe, slots] : levels_.universes()) waiting_.push_back({universe, stamp_ns, slots});
  }

  std::string path_;
  std::unique_ptr<drivers::SoundFile> file_;
  AudioLink link_;
  fixtures::SoundLevels levels_;
  std::function<bool(double)> on_seconds_;
  std::vector<Universe> universes_;
  std::vector<float> samples_;
  std::deque<Waiting> waiting_;
  bool given_ = false;  // the first of waiting_ was returned
};

}  // namespace

bool is_sound_log(const std::string& path) { return path.starts_with(kScheme) || path.ends_with(".toml"); }

Result<fixtures::SoundMap> sound_map_of(const std::string& path) {
  if (!path.starts_with(kScheme)) return fixtures::load_sound_map(path);
  FL_ASSIGN(const Endpoint endpoint, parse_endpoint(path, {}));
  if (endpoint.universes.empty()) return fixtures::load_sound_map(endpoint.target);
  return fixtures::plain_sound_map(endpoint.target, endpoint.universes.front().show, endpoint.first_address);
}

Result<fixtures::SoundLevels> sound_levels_of(const fixtures::SoundMap& map) {
  fixtures::Rig rig;
  if (!map.rig.empty()) {
    FL_ASSIGN(rig, fixtures::load_rig(map.rig));
  }
  return fixtures::SoundLevels::create(map, rig);
}

namespace {

// A DMX log stays in its file; any other recording is read at once, and what of it is damaged is printed.
Result<LogReader> read_capture(const std::string& path, const drivers::CaptureOptions& options) {
  FL_ASSIGN(const LogFormat format, detect_log_format(path));
  if (format == LogFormat::kDmxLog) return LogReader::open(path);
  FL_ASSIGN(const std::unique_ptr<LogInput> input, drivers::open_any_log(path, options));
  FL_ASSIGN(LogReader reader, read_into_memory(*input));
  if (input->damage_count() > 0) {
    for (const std::string& note : input->notes()) {
      fmt::print(stderr, "footlight: {}: {}\n", path, printable_line(note));
    }
  }
  return reader;
}

// `on_seconds`: called with the seconds that were analysed; false stops.
Result<std::unique_ptr<LogInput>> open_sound(const std::string& path, std::function<bool(double)> on_seconds) {
  FL_ASSIGN(const fixtures::SoundMap map, sound_map_of(path));
  if (is_sound_device(map.sound)) {
    return fail(ErrorCode::kBadInput, "{}: {} is a device, which has no end; record it: 'footlight record --in {}'",
                path, map.sound, path.starts_with(kScheme) ? path : fmt::format("audio:{}", path));
  }
  FL_ASSIGN(auto file, drivers::SoundFile::open(map.sound));
  FL_ASSIGN(auto levels, sound_levels_of(map));
  return std::make_unique<SoundInput>(path, std::move(file), map, std::move(levels), std::move(on_seconds));
}

}  // namespace

Result<std::unique_ptr<LogInput>> open_level_log(const std::string& path, const drivers::CaptureOptions& options) {
  return is_sound_log(path) ? open_sound(path, {}) : drivers::open_any_log(path, options);
}

Status check_level_log(const std::string& path) {
  if (path.starts_with(kScheme)) return {};
  FL_TRY(refuse_pipe_input(path));
  Status log;
  if (!is_sound_log(path)) {
    const Result<LogFormat> found = detect_log_format(path);
    if (found) return {};
    log = tl::unexpected<Error>(found.error());
  }
  const std::string format = fixtures::rig_format(path);
  std::string what;
  if (format == "mvr" || format == "qxw" || format == "vrsl") {
    what = "rig";
  } else if (format == "gdtf" || format == "qxf" || format == "ofl" || format == "photometry") {
    what = "definition of a fixture";
  } else if (path.ends_with(".toml") && !fixtures::load_sound_map(path)) {
    if (fixtures::open_definition(path)) {
      what = "definition of a fixture";
    } else if (fixtures::load_rig(path)) {
      what = "rig";
    }
  }
  if (what.empty()) return log;
  return fail(ErrorCode::kBadInput,
              "{}: is a {}; expected a log: .dmxlog, an OLA Show, a capture or a sound map. A rig comes first, as in "
              "'footlight preview RIG --log LOG'",
              path, what);
}

Result<LogReader> read_level_log(const std::string& path, const drivers::CaptureOptions& options,
                                 const std::function<bool()>& stopping) {
  FL_TRY(check_level_log(path));
  if (!is_sound_log(path)) return read_capture(path, options);
  bool told = false;
  const auto on_seconds = [&](double seconds) {
    if (seconds > kLongSoundS && !told) {
      fmt::print(stderr,
                 "footlight: {}: the sound is analysed first; 'footlight log convert {} show.dmxlog' stores that\n",
                 path, path);
      told = true;
    }
    return !stopping || !stopping();
  };
  FL_ASSIGN(const std::unique_ptr<LogInput> input, open_sound(path, on_seconds));
  return read_into_memory(*input);
}

Result<std::uint64_t> run_sound_file(drivers::SoundFile& file, const AudioLinkSettings& settings,
                                     const AudioLink::OnStep& on_step,
                                     const std::function<bool(std::span<const float>)>& on_samples) {
  AudioLink link(settings, file.info().rate_hz, file.info().channels);
  std::vector<float> samples;
  while (true) {
    FL_ASSIGN(const bool more, file.read(samples));
    if (!more || !on_samples(samples)) return link.frames();
    link.push(samples, on_step);
  }
}

}  // namespace footlight::tools
