// footlight trace: the states of a rig's heads over time as CSV or JSON, without pictures.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "sim/core/counted.h"
#include "sim/file_kind.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/pictures/log_damage.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/stop_signal.h"
#include "tools/footlight/trace/head_trace.h"

namespace footlight::tools {
namespace {

struct Options {
  SceneFiles files;
  std::string out;        // empty: standard output
  DurationNs at_ns = -1;  // -1: not given
  DurationNs every_ns = -1;
  DurationNs from_ns = 0;
  DurationNs until_ns = -1;
  DurationNs exposure_ns = -1;
  std::vector<std::string> fixtures;
  int head = 0;  // 0: all
  std::vector<std::string> sets;
  bool lit = false;
  bool csv = false;
  bool json = false;
};

constexpr DurationNs kStillExposureNs = 20 * kNsPerMs;  // as render has it

Status check_options(const Options& options) {
  const bool many = options.every_ns >= 0;
  if (many == (options.at_ns >= 0)) {
    return fail(ErrorCode::kBadInput, "expected --at TIME for one moment, or --every TIME for many");
  }
  if (many && options.every_ns < 1000) {
    return fail(ErrorCode::kBadInput, "--every {}: expected 1us or more", show_duration(options.every_ns));
  }
  if (many && options.until_ns >= 0 && options.until_ns < options.from_ns) {
    return fail(ErrorCode::kBadInput, "--until {}: lies before --from {}", show_duration(options.until_ns),
                show_duration(options.from_ns));
  }
  if (!many && (options.from_ns > 0 || options.until_ns >= 0)) {
    return fail(ErrorCode::kBadInput, "--from and --until go with --every: expected --every TIME in place of --at");
  }
  if (options.csv && options.json) return fail(ErrorCode::kBadInput, "--csv and --json: expected one of them");
  const bool by_hand = options.lit || !options.sets.empty();
  const bool driven = !options.files.log.empty() || options.files.demo;
  if (by_hand && driven) {
    return fail(ErrorCode::kBadInput, "--lit and --set are for a rig without a log: expected one of them");
  }
  if (!by_hand && !driven) {
    return fail(ErrorCode::kBadInput, "nothing drives the rig: expected --log FILE, --lit or --set, or --demo");
  }
  if (by_hand && many && options.until_ns < 0) {
    return fail(ErrorCode::kBadInput, "--every without a log has no end: expected --until TIME");
  }
  return {};
}

// Standard output, or a file that gets its name once it is whole.
class Output {
 public:
  explicit Output(std::string path) : path_(std::move(path)), part_(path_ + ".part") {}
  ~Output() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    std::remove(part_.c_str());
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  Status open() {
    if (path_.empty()) return {};
    FL_TRY(refuse_pipe_output(path_));
    file_ = std::fopen(part_.c_str(), "wb");
    if (file_ != nullptr) return {};
    return fail(ErrorCode::kIo, "{}: cannot be written ({}); choose a folder that exists and is yours", path_,
                std::strerror(errno));
  }

  // False: nobody reads on, as behind `| head`.
  Result<bool> write(const std::string& text) {
    if (path_.empty()) {
      std::fwrite(text.data(), 1, text.size(), stdout);
      return flush_output();
    }
    if (std::fwrite(text.data(), 1, text.size(), file_) == text.size()) return true;
    return failed();
  }

  Status finish() {
    if (path_.empty()) return {};
    if (std::fflush(file_) != 0) return failed();
    if (std::fclose(std::exchange(file_, nullptr)) != 0) return failed();
    std::error_code trouble;
    std::filesystem::rename(part_, path_, trouble);
    if (!trouble) return {};
    std::remove(part_.c_str());
    return fail(ErrorCode::kIo, "{}: cannot be written: {}", path_, trouble.message());
  }

 private:
  tl::unexpected<Error> failed() const {
    return fail(ErrorCode::kIo, "{}: writing failed ({}); is the disk full?", path_, std::strerror(errno));
  }

  const std::string path_;
  const std::string part_;
  std::FILE* file_ = nullptr;
};

// The heads that are asked for, in the order of the rig.
Result<std::vector<std::size_t>> chosen_heads(const Options& options, const fixtures::Rig& rig,
                                              const HeadTrace& trace) {
  for (const std::string& name : options.fixtures) {
    const bool known = std::any_of(rig.fixtures.begin(), rig.fixtures.end(),
                                   [&](const fixtures::PatchedFixture& one) { return one.name == name; });
    if (known) continue;
    return fail(ErrorCode::kNotFound, "--fixture {}: no fixture is called so; {}", printable_utf8(name),
                options.files.demo
                    ? "the demo has 'Profile 1' and others"
                    : fmt::format("'footlight rig show {}' lists them", printable_utf8(options.files.rig)));
  }
  std::vector<std::size_t> heads;
  for (std::size_t head = 0; head < trace.head_count(); ++head) {
    const std::string& name = rig.fixtures[trace.fixture_of(head)].name;
    const bool named = options.fixtures.empty() ||
                       std::find(options.fixtures.begin(), options.fixtures.end(), name) != options.fixtures.end();
    if (named && (options.head == 0 || trace.number_of(head) == options.head)) heads.push_back(head);
  }
  if (!heads.empty()) return heads;
  if (options.head == 0) return fail(ErrorCode::kNotFound, "the rig has no fixture with a beam");
  return fail(ErrorCode::kNotFound, "--head {}: no such fixture has so many beams", options.head);
}

// Fixtures without an address get one, and so the levels of --lit and --set reach them.
Result<Timeline> timeline_by_hand(const Options& options, const fixtures::Rig& rig,
                                  const fixtures::CompiledRig& compiled) {
  HandLevels hand(rig, compiled);
  for (const std::string& text : options.sets) FL_TRY(set_by_hand(text, rig, hand));
  return Timeline(hand.levels(), compiled);
}

Result<int> trace_heads(const Options& options) {
  FL_TRY(check_options(options));
  const StopSignal stop;
  FL_ASSIGN(fixtures::Rig rig, load_scene_rig(options.files));
  FL_ASSIGN(std::optional<LogReader> log, open_scene_log(options.files));
  const DamageWarning warning(log);
  const bool by_hand = options.lit || !options.sets.empty();
  if (by_hand) give_hand_addresses(rig);
  FL_ASSIGN(DrivenRig driven, compile_driven(rig, std::move(log)));
  const fixtures::CompiledRig& compiled = driven.compiled;
  if (by_hand) {
    FL_ASSIGN(driven.timeline, timeline_by_hand(options, rig, compiled));
  }
  HeadTrace trace(rig, compiled);
  FL_ASSIGN(const auto heads, chosen_heads(options, rig, trace));

  Output output(options.out);
  FL_TRY(output.open());
  std::int64_t times = 0;
  DurationNs last_ns = 0;
  bool read_on = true;
  const auto take = [&](DurationNs at_ns, DurationNs exposure_ns) -> Status {
    const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
      if (!stop.came()) trace.step(levels, dt_ns, new_exposure);
    };
    FL_TRY(driven.timeline->advance(at_ns, exposure_ns, step));
    if (stop.came()) return {};
    std::string text;
    for (const std::size_t head : heads) {
      const TraceRow row = trace.row(head, at_ns);
      if (text.empty() && times == 0 && !options.json) text += csv_names_of(row);
      text += options.json ? json_line_of(row) : csv_line_of(row);
    }
    FL_ASSIGN(read_on, output.write(text));
    ++times;
    last_ns = at_ns;
    return {};
  };
  if (options.at_ns >= 0) {
    FL_TRY(take(options.at_ns, options.exposure_ns >= 0 ? options.exposure_ns : kStillExposureNs));
  } else {
    const DurationNs end_ns = options.until_ns >= 0 ? options.until_ns : driven.timeline->duration_ns();
    if (options.from_ns > end_ns) {
      return fail(ErrorCode::kBadInput, "--from {}: the log ends at {}", show_duration(options.from_ns),
                  show_duration(end_ns));
    }
    const DurationNs exposure_ns = options.exposure_ns >= 0 ? options.exposure_ns : options.every_ns;
    for (DurationNs at_ns = options.from_ns; at_ns <= end_ns && read_on && !stop.came(); at_ns += options.every_ns) {
      FL_TRY(take(at_ns, exposure_ns));
    }
  }
  if (stop.came() && times == 0) {
    fmt::print(stderr, "footlight: stopped before the first row; nothing was written\n");
    return kExitFailed;
  }
  FL_TRY(output.finish());
  if (stop.came()) {
    fmt::print(stderr, "footlight: stopped at {}; the rows up to there are whole\n", show_duration(last_ns));
  }
  if (!options.out.empty()) {
    fmt::print("{}: {} at {}\n", options.out, counted(heads.size(), "head"), counted(times, "moment"));
  }
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  add_scene_arguments(arguments, options->files);
  arguments.option("--out,-o", options->out, "FILE", "the rows; standard output");
  arguments.duration("--at", options->at_ns, "the rows of one moment of the log");
  arguments.duration("--every", options->every_ns, "rows this far apart");
  arguments.duration("--from", options->from_ns, "with --every: the first moment");
  arguments.duration("--until", options->until_ns, "with --every: no row after this moment; the end of the log");
  arguments.duration("--exposure", options->exposure_ns,
                     "light and shutter are means over so long before each moment; 20ms, or all of --every");
  arguments.list("--fixture", options->fixtures, "NAME", "only this fixture; many times");
  arguments.option("--head", options->head, 0, 10'000, "only this beam of fixtures that have several; 0: all");
  arguments.flag("--lit", options->lit, "without a log: every fixture at full, open and white, its axes in the middle");
  arguments.list("--set", options->sets, "WORDS",
                 "as --lit, and ATTRIBUTE=VALUE of all fixtures or FIXTURE:ATTRIBUTE=VALUE of one; many times");
  arguments.flag("--csv", options->csv, "comma-separated values under a line of names; unless --json is given");
  arguments.flag("--json", options->json, "one JSON object a row");
  arguments.job([options]() -> Result<int> { return trace_heads(*options); });
}

}  // namespace

extern const CommandInfo trace_command{
    .name = "trace",
    .help = "Print what each head does over time: position, light, optics",
    .examples =
        "  footlight trace rig.toml --log show.dmxlog --every 20ms -o heads.csv\n"
        "  footlight trace --demo --at 12.5s --fixture 'Profile 1' --json\n"
        "  footlight trace rig.toml --log show.dmxlog --every 1s --from 10s --until 20s --fixture 'Spot 1'\n"
        "  footlight trace hall.mvr --lit --set Tilt=30 --at 0s      levels by hand\n"
        "The columns are in docs/trace.md. The states are those of the pictures that 'footlight render' makes of the\n"
        "same rig, log and times, in the GPU's float. No renderer is needed.",
    .add = add,
};

}  // namespace footlight::tools
