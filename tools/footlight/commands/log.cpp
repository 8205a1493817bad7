// footlight log: shows, converts, compares and times logs. `log compare` is in log_compare.cpp.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "drivers/capture/captures.h"
#include "sim/core/counted.h"
#include "sim/core/endpoint.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/log_diff.h"
#include "sim/dmx_log/log_input.h"
#include "tools/footlight/commands/log_command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/vrsl/video_log.h"
#include "tools/footlight/vrsl/video_reader.h"

namespace footlight::tools {
namespace {

Result<std::unique_ptr<LogInput>> open_input(const std::string& path, const drivers::CaptureOptions& read,
                                             const ReadArguments& arguments) {
  if (is_video_name(path)) {
    FL_ASSIGN(std::unique_ptr<VideoLog> video, open_video_log(path, arguments.grid, "--grid"));
    return video;
  }
  return open_level_log(path, read);
}

}  // namespace

Result<LogReader> read_input(const std::string& path, const drivers::CaptureOptions& read,
                             const ReadArguments& arguments) {
  if (!is_video_name(path)) return read_level_log(path, read);
  FL_ASSIGN(const std::unique_ptr<LogInput> input, open_input(path, read, arguments));
  return read_into_memory(*input);
}

namespace {

struct InfoOptions {
  std::string file;
  bool check = false;
  bool json = false;
  ReadArguments read;
};

std::string show_wall_clock(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / kNsPerS;
  std::tm parts = {};
  if (gmtime_r(&seconds, &parts) == nullptr) return "?";
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02} UTC", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::string format_of(const LogInfo& info) {
  switch (info.format) {
    case LogFormat::kDmxLog: return fmt::format("DMX log {}.{}", info.version_major, info.version_minor);
    case LogFormat::kOlaShow: return "OLA show file";
    case LogFormat::kPacketCapture: return "packet capture";
    case LogFormat::kLineCapture: return "sigrok capture of a line";
    case LogFormat::kSound: return "sound map";
    case LogFormat::kVideo: return "video of a VRSL grid";
  }
  return "?";
}

void print_notes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) fmt::print("  note: {}\n", note);
}

void print(const LogInfo& info) {
  fmt::print("{}\n", info.path);
  fmt::print("  format:   {}\n", format_of(info));
  fmt::print("  length:   {}\n", show_duration(info.duration_ns));
  if (info.wall_start_unix_ns != 0) fmt::print("  recorded: {}\n", show_wall_clock(info.wall_start_unix_ns));
  fmt::print("  frames:   {}, {} of them with changes; {} bytes\n", info.frames, info.changes, info.file_bytes);
  for (const LogUniverseInfo& universe : info.universes) {
    fmt::print("  universe {}: {} frames, {:.2f}/s, {} slots, {} to {}\n", universe.universe, universe.frames,
               universe.rate_hz(), universe.slot_count, show_duration(universe.first_ns),
               show_duration(universe.last_ns));
  }
  for (const LogDamage& part : info.damage) {
    fmt::print("  damage at byte {}, {} bytes: {}\n", part.offset, part.size_bytes, part.what);
  }
  if (info.damage_count > info.damage.size()) {
    fmt::print("  damage in {} more places{}: {} bytes in all\n", info.damage_count - info.damage.size(),
               info.damage_count == kLogDamageCountedMax ? " or more" : "", info.damage_bytes);
  }
}

Result<int> print_info(const InfoOptions& options) {
  if (options.file.empty())
    return fail(ErrorCode::kBadInput, "log info: expected a file, for example 'footlight log info show.dmxlog'");
  FL_ASSIGN(const drivers::CaptureOptions read, options.read.read());
  LogFormat format = is_sound_log(options.file) ? LogFormat::kSound : LogFormat::kVideo;
  if (!is_sound_log(options.file) && !is_video_name(options.file)) {
    FL_ASSIGN(format, detect_log_format(options.file));
  }
  LogInfo info;
  std::vector<std::string> notes;
  if (format == LogFormat::kDmxLog) {
    FL_ASSIGN(info, read_log_info(options.file, options.check));
  } else {
    FL_ASSIGN(const std::unique_ptr<LogInput> input, open_input(options.file, read, options.read));
    FL_ASSIGN(info, describe(*input));
    notes = input->notes();
  }
  if (options.json) {
    fmt::print("{}\n", json_of_log(info, notes));
  } else {
    print(info);
    print_notes(notes);
  }
  if (!info.recovered()) return kExitOk;
  fmt::print(
      stderr, "footlight: {}: {}; 'footlight log convert {} whole.dmxlog' writes what can be read\n", options.file,
      info.damage_count == 0 ? "the recording was not finished" : counted(info.damage_count, "damaged part"),
      options.file);
  return kExitFailed;
}

struct ConvertArguments {
  std::string in;
  std::string out;
  ConvertOptions options;
  std::string universes;
  ReadArguments read;
  bool json = false;
};

Result<int> convert(const ConvertArguments& arguments) {
  if (arguments.in.empty() || arguments.out.empty()) {
    return fail(ErrorCode::kBadInput,
                "log convert: expected two files, for example 'footlight log convert foh.show foh.dmxlog'");
  }
  FL_ASSIGN(const drivers::CaptureOptions read, arguments.read.read());
  ConvertOptions options = arguments.options;
  if (!arguments.universes.empty()) {
    const auto renumber = parse_wire_universes(arguments.universes);
    if (!renumber) return fail(ErrorCode::kBadInput, "--universes: {}", renumber.error().message);
    for (const WireUniverse& universe : *renumber) options.renumber.emplace_back(universe.wire, universe.show);
  }
  FL_ASSIGN(const std::unique_ptr<LogInput> input, open_input(arguments.in, read, arguments.read));
  FL_ASSIGN(const ConvertReport report, convert_log(*input, arguments.out, options));
  if (arguments.json) {
    fmt::print("{}\n", json_of_conversion(arguments.in, arguments.out, report));
  } else {
    fmt::print("{}: {} frames, {}, {} bytes (from {})\n", arguments.out, report.frames,
               show_duration(report.duration_ns), report.bytes_out, report.bytes_in);
    if (report.left_out != 0) fmt::print("  left out: {} frames\n", report.left_out);
    if (report.lead_dropped_ns != 0) {
      fmt::print("  left out: {} of silence before the first frame, which an OLA show file cannot store\n",
                 show_duration(report.lead_dropped_ns));
    }
    if (report.other_universes != 0) {
      fmt::print("  left out: {} frames of universes that are not in --universes\n", report.other_universes);
    }
    for (const Universe universe : report.absent) fmt::print("  universe {}: no frames\n", universe);
    if (report.late_stamps != 0) {
      fmt::print("  {} frames had earlier stamps than the frame before; they got its time\n", report.late_stamps);
    }
    print_notes(report.notes);
  }
  if (report.damage_count == 0) return kExitOk;
  fmt::print(stderr, "footlight: {}: left out: {}\n", arguments.in, counted(report.damage_count, "damaged part"));
  return kExitFailed;
}

struct TimingArguments {
  std::string file;
  ReadArguments read;
  bool summary = false;
  bool json = false;
};

// Prints the smallest, median and largest of the values that `value` appends for each valid frame.
template <class Value>
void print_spread(const char* name, const char* unit, double scale, const std::vector<drivers::LineFrameTiming>& frames,
                  Value&& value) {
  std::vector<DurationNs> values;
  for (const drivers::LineFrameTiming& frame : frames) {
    if (frame.fault == drivers::LineFault::kNone) value(frame, values);
  }
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const auto show = [&](DurationNs one) { return static_cast<double>(one) * scale; };
  fmt::print("  {:<7} {:9.2f} {:9.2f} {:9.2f} {}   (min, median, max)\n", name, show(values.front()),
             show(values[values.size() / 2]), show(values.back()), unit);
}

double us(DurationNs duration_ns) { return static_cast<double>(duration_ns) * 1e-3; }

Result<int> timing(const TimingArguments& arguments) {
  if (arguments.file.empty()) {
    return fail(ErrorCode::kBadInput, "log timing: expected a file, for example 'footlight log timing desk.sr'");
  }
  FL_ASSIGN(const LogFormat format, detect_log_format(arguments.file));
  if (format != LogFormat::kLineCapture) {
    return fail(ErrorCode::kBadInput,
                "{}: expected a sigrok capture (.sr) of a line; other files store whole frames without breaks",
                arguments.file);
  }
  FL_ASSIGN(const drivers::CaptureOptions read, arguments.read.read());
  FL_ASSIGN(const drivers::LineCaptureInfo info, drivers::read_line_timing(arguments.file, read));
  if (arguments.json) {
    fmt::print("{}\n", json_of_line_timing(arguments.file, info));
    return info.counters.rejected == 0 ? kExitOk : kExitFailed;
  }
  using drivers::LineFrameTiming;
  if (!arguments.summary) {
    fmt::print("    time_ms  break_us   mab_us  code  slots  gap_us: min   mean    max  period_ms\n");
    for (const LineFrameTiming& frame : info.frames) {
      fmt::print("{:11.3f}  {:8.1f} {:8.1f}  0x{:02x}  {:5}  {:11.1f} {:6.1f} {:6.1f}", us(frame.start_ns) * 1e-3,
                 us(frame.break_ns), us(frame.mab_ns), frame.start_code, frame.slot_count, us(frame.gap_min_ns),
                 frame.slot_count == 0 ? 0.0 : us(frame.gap_sum_ns) / frame.slot_count, us(frame.gap_max_ns));
      fmt::print("  {:>9}", frame.period_ns == 0 ? "-" : fmt::format("{:.3f}", us(frame.period_ns) * 1e-3));
      if (frame.unfinished) fmt::print("  the capture ends here");
      if (frame.fault != drivers::LineFault::kNone) fmt::print("  rejected: {}", text_of(frame.fault));
      fmt::print("\n");
    }
  }
  fmt::print("{}: {} frames, {} rejected, {} at {:.6g} MHz\n", arguments.file, info.counters.sound,
             info.counters.rejected, show_duration(info.duration_ns), info.sample_rate_hz * 1e-6);
  using Values = std::vector<DurationNs>;
  print_spread("break", "us", 1e-3, info.frames,
               [](const LineFrameTiming& frame, Values& values) { values.push_back(frame.break_ns); });
  print_spread("mab", "us", 1e-3, info.frames,
               [](const LineFrameTiming& frame, Values& values) { values.push_back(frame.mab_ns); });
  print_spread("slots", "  ", 1.0, info.frames, [](const LineFrameTiming& frame, Values& values) {
    if (!frame.unfinished) values.push_back(frame.slot_count);
  });
  print_spread("gap", "us", 1e-3, info.frames, [](const LineFrameTiming& frame, Values& values) {
    if (frame.slot_count == 0) return;
    values.insert(values.end(), {frame.gap_min_ns, frame.gap_sum_ns / frame.slot_count, frame.gap_max_ns});
  });
  print_spread("pitch", "us", 1e-3, info.frames, [](const LineFrameTiming& frame, Values& values) {
    if (frame.slot_count != 0) values.push_back(frame.pitch_min_ns);
  });
  print_spread("period", "ms", 1e-6, info.frames, [](const LineFrameTiming& frame, Values& values) {
    if (frame.period_ns != 0) values.push_back(frame.period_ns);
  });
  print_notes(info.notes);
  return info.counters.rejected == 0 ? kExitOk : kExitFailed;
}

struct DiffArguments {
  std::string a;
  std::string b;
  LogDiffOptions options;
  bool same_start = false;
  ReadArguments read;
  bool json = false;
};

std::string offset_of(const LogDiff& diff) {
  const std::string offset =
      fmt::format("{}{}", diff.offset_ns < 0 ? "-" : "", show_duration(std::abs(diff.offset_ns)));
  switch (diff.offset_from) {
    case LogOffsetFrom::kGiven: return "times are compared without an offset";
    case LogOffsetFrom::kChanges:
      return fmt::format("B is {} later, by {} changes of levels that occur once in each", offset, diff.offset_votes);
    case LogOffsetFrom::kFirstFrames:
      return fmt::format("B is {} later, by the first frame of each, because no change of levels is unique", offset);
    case LogOffsetFrom::kNothing: break;
  }
  return "no universe is in both logs";
}

Result<int> diff(const DiffArguments& arguments) {
  if (arguments.a.empty() || arguments.b.empty()) {
    return fail(ErrorCode::kBadInput,
                "log diff: expected two files, for example 'footlight log diff a.dmxlog b.dmxlog'");
  }
  FL_ASSIGN(const drivers::CaptureOptions read, arguments.read.read());
  LogDiffOptions options = arguments.options;
  if (arguments.same_start) options.offset_ns = 0;
  FL_ASSIGN(LogReader a, read_input(arguments.a, read, arguments.read));
  FL_ASSIGN(LogReader b, read_input(arguments.b, read, arguments.read));
  FL_ASSIGN(const LogDiff diff, diff_logs(a, b, options));
  const int exit_code = diff.equal ? kExitOk : kExitFailed;
  if (arguments.json) {
    fmt::print("{}\n", json_of_log_diff(arguments.a, arguments.b, diff));
    return exit_code;
  }
  fmt::print("A: {}, {}\nB: {}, {}\n{}\n", arguments.a, show_duration(diff.duration_a_ns), arguments.b,
             show_duration(diff.duration_b_ns), offset_of(diff));
  for (const LogUniverseDiff& one : diff.universes) {
    fmt::print("universe {}: {} pairs, {} frames only in A, {} only in B\n", one.universe, one.pairs, one.only_a,
               one.only_b);
    if (one.different != 0) {
      fmt::print("  levels: {} pairs differ, in {} slots, by at most {}; first at {}, address {}: {} in A, {} in B\n",
                 one.different, one.slots_different, one.level_distance_max, show_duration(one.first_ns),
                 one.first_address, one.first_level_a, one.first_level_b);
    }
    if (one.pairs == 0) continue;
    fmt::print("  times: apart by {} (median), {} (99 %), {} (max); drift {:.2f} ppm\n",
               show_duration(one.times.p50_ns), show_duration(one.times.p99_ns), show_duration(one.times.max_ns),
               one.drift_ppm);
  }
  fmt::print("{}\n", diff.equal ? "equal" : "different");
  return exit_code;
}

void add(Arguments& arguments) {
  Arguments info = arguments.subcommand("info", "Show the length, universes, rates and damage of a log",
                                        "  footlight log info show.dmxlog\n"
                                        "  footlight log info --check --json show.dmxlog\n"
                                        "  footlight log info capture.pcapng\n"
                                        "Exit code 1 if the log is damaged or was not finished.");
  auto info_options = std::make_shared<InfoOptions>();
  info.word("FILE", info_options->file, kLogFileHelp);
  info.flag("--check", info_options->check, "DMX log: read every block, not only the index");
  info_options->read.add(info);
  info.flag("--json", info_options->json, "one JSON object");
  info.job([info_options]() -> Result<int> { return print_info(*info_options); });

  Arguments converter = arguments.subcommand(
      "convert", "Convert a log to another format, selected by the name of the result",
      "  footlight log convert foh.show foh.dmxlog          OLA show file to DMX log\n"
      "  footlight log convert show.dmxlog show.txt         DMX log to OLA show file\n"
      "  footlight log convert show.pcapng show.dmxlog      sACN and Art-Net from a packet capture\n"
      "  footlight log convert desk.sr desk.dmxlog          a DMX line from a sigrok capture\n"
      "  footlight log convert broken.dmxlog whole.dmxlog   the readable parts of a damaged log\n"
      "Exit code 1 if a part of the input was damaged; the rest was written.");
  auto convert_arguments = std::make_shared<ConvertArguments>();
  converter.word("FROM", convert_arguments->in, kLogFileHelp);
  converter.word("TO", convert_arguments->out, ".dmxlog for a DMX log, any other name for an OLA show file");
  converter.flag("--overwrite", convert_arguments->options.overwrite, "replace a file of that name");
  converter.flag("--changes-only", convert_arguments->options.changes_only,
                 "leave out frames that repeat the levels before them");
  converter.option("--universes", convert_arguments->universes, "LIST",
                   "only these (1-3), or renumbered (101-103=1-3)");
  convert_arguments->read.add(converter);
  converter.flag("--json", convert_arguments->json, "one JSON object");
  converter.job([convert_arguments]() -> Result<int> { return convert(*convert_arguments); });

  Arguments differ =
      arguments.subcommand("diff", "Compare the levels and times of two logs",
                           "  footlight log diff sent.dmxlog received.dmxlog\n"
                           "  footlight log diff show.dmxlog show.pcapng --changes-only --time-tolerance 5ms\n"
                           "  footlight log diff a.dmxlog b.dmxlog --values 1 --same-start --json\n"
                           "Exit code 0 if every frame has a counterpart and all levels and times are within the\n"
                           "tolerances, else 1.");
  auto diff_arguments = std::make_shared<DiffArguments>();
  differ.word("A", diff_arguments->a, kLogFileHelp);
  differ.word("B", diff_arguments->b, "the same");
  differ.option("--values", diff_arguments->options.level_tolerance, 0, 255, "tolerance of levels");
  differ.duration("--time-tolerance", diff_arguments->options.time_tolerance_ns,
                  "tolerance of times, after the offset is removed [1ms]");
  differ.flag("--same-start", diff_arguments->same_start, "both started at the same moment: use no offset");
  differ.flag("--changes-only", diff_arguments->options.changes_only,
              "leave out frames that repeat the levels before them");
  diff_arguments->read.add(differ);
  differ.flag("--json", diff_arguments->json, "one JSON object");
  differ.job([diff_arguments]() -> Result<int> { return diff(*diff_arguments); });

  add_log_compare(arguments);

  Arguments line =
      arguments.subcommand("timing", "Show break, mark after break, gaps and period of a captured DMX line",
                           "  footlight log timing desk.sr\n"
                           "  footlight log timing desk.sr --summary --channel DMX-  --inverted\n"
                           "  footlight log timing desk.sr --json\n"
                           "Exit code 1 if a frame was rejected.");
  auto timing_arguments = std::make_shared<TimingArguments>();
  line.word("FILE", timing_arguments->file, "a sigrok capture (.sr)");
  line.flag("--summary", timing_arguments->summary, "print only the summary, not each frame");
  timing_arguments->read.add_line(line);
  line.flag("--json", timing_arguments->json, "one JSON object");
  line.job([timing_arguments]() -> Result<int> { return timing(*timing_arguments); });
}

}  // namespace

extern const CommandInfo log_command{
    .name = "log",
    .help = "Show, convert and compare logs and captures",
    .examples =
        "  footlight log info show.dmxlog\n"
        "  footlight log convert foh.show foh.dmxlog\n"
        "  footlight log convert capture.pcapng show.dmxlog\n"
        "  footlight log convert club.mp4 club.dmxlog\n"
        "  footlight log diff sent.dmxlog received.pcapng\n"
        "  footlight log compare show.dmxlog --at 10s --with 25s --rig rig.toml\n"
        "  footlight log timing desk.sr\n",
    .add = add,
};

}  // namespace footlight::tools
