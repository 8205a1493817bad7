// footlight log: look into a log, or turn one into another format.
#include <cstdio>
#include <ctime>
#include <memory>

#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/log_ports.h"
#include "sim/dmx_log/ola_show.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/json_lines.h"

namespace footlight::tools {
namespace {

struct InfoOptions {
  std::string file;
  bool check = false;
  bool json = false;
  int universe_offset = 0;
};

std::string show_wall_clock(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / kNsPerS;
  std::tm parts = {};
  if (gmtime_r(&seconds, &parts) == nullptr) return "?";
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02} UTC", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

void print(const LogInfo& info) {
  const bool is_log = info.format == LogFormat::kDmxLog;
  fmt::print("{}\n", info.path);
  fmt::print("  format:   {}\n",
             is_log ? fmt::format("DMX log {}.{}", info.version_major, info.version_minor) : "OLA Show");
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
}

Result<int> print_info(const InfoOptions& options) {
  if (options.file.empty())
    return fail(ErrorCode::kBadInput, "log info: expected a file, as in 'footlight log info show.dmxlog'");
  FL_ASSIGN(const LogInfo info, read_log_info(options.file, options.check, options.universe_offset));
  if (options.json) {
    fmt::print("{}\n", json_of_log(info));
  } else {
    print(info);
  }
  if (!info.recovered()) return kExitOk;
  fmt::print(
      stderr, "footlight: {}: {}; 'footlight log convert {} whole.dmxlog' writes what can be read\n", options.file,
      info.damage_count == 0 ? "its writer did not finish it" : fmt::format("{} damaged parts", info.damage_count),
      options.file);
  return kExitFailed;
}

struct ConvertArguments {
  std::string in;
  std::string out;
  ConvertOptions options;
  bool json = false;
};

Result<int> convert(const ConvertArguments& arguments) {
  if (arguments.in.empty() || arguments.out.empty()) {
    return fail(ErrorCode::kBadInput,
                "log convert: expected two files, as in 'footlight log convert foh.show foh.dmxlog'");
  }
  FL_ASSIGN(const ConvertReport report, convert_log(arguments.in, arguments.out, arguments.options));
  if (arguments.json) {
    fmt::print("{}\n", json_of_conversion(arguments.in, arguments.out, report));
  } else {
    fmt::print("{}: {} frames, {}, {} bytes (from {})\n", arguments.out, report.frames,
               show_duration(report.duration_ns), report.bytes_out, report.bytes_in);
    if (report.left_out != 0) fmt::print("  left out: {} frames\n", report.left_out);
    if (report.lead_dropped_ns != 0) {
      fmt::print("  left out: {} of silence before the first frame, which an OLA Show cannot hold\n",
                 show_duration(report.lead_dropped_ns));
    }
  }
  if (report.damage_count == 0) return kExitOk;
  fmt::print(stderr, "footlight: {}: {} damaged parts were left out\n", arguments.in, report.damage_count);
  return kExitFailed;
}

void add(Arguments& arguments) {
  Arguments info = arguments.subcommand("info", "What a log holds: length, universes, rates, damage",
                                        "  footlight log info show.dmxlog\n"
                                        "  footlight log info --check --json show.dmxlog\n"
                                        "Exit code 1 where the log is damaged or was not finished.");
  auto info_options = std::make_shared<InfoOptions>();
  info.word("FILE", info_options->file, "a DMX log, or an OLA Show");
  info.flag("--check", info_options->check, "read every block, not only the index");
  info.option("--universe-offset", info_options->universe_offset, 0, 1, "OLA Show: 1 where it counts universes from 0");
  info.flag("--json", info_options->json, "one JSON object");
  info.job([info_options]() -> Result<int> { return print_info(*info_options); });

  Arguments converter =
      arguments.subcommand("convert", "Turn a log into another format, told by the name of the result",
                           "  footlight log convert foh.show foh.dmxlog          an OLA Show into a DMX log\n"
                           "  footlight log convert show.dmxlog show.txt         a DMX log into an OLA Show\n"
                           "  footlight log convert broken.dmxlog whole.dmxlog   keep what can be read\n"
                           "Exit code 1 where a part of the input was damaged; the rest was written.");
  auto convert_arguments = std::make_shared<ConvertArguments>();
  converter.word("FROM", convert_arguments->in, "a DMX log, or an OLA Show");
  converter.word("TO", convert_arguments->out, ".dmxlog for a DMX log, anything else for an OLA Show");
  converter.flag("--overwrite", convert_arguments->options.overwrite, "replace a file of that name");
  converter.flag("--changes-only", convert_arguments->options.changes_only,
                 "leave out frames that repeat the levels before them");
  converter.option("--universe-offset", convert_arguments->options.universe_offset, 0, 1,
                   "OLA Show: 1 where it counts universes from 0");
  converter.flag("--json", convert_arguments->json, "one JSON object");
  converter.job([convert_arguments]() -> Result<int> { return convert(*convert_arguments); });
}

}  // namespace

extern const CommandInfo log_command{
    .name = "log",
    .help = "Look into a log, or turn it into another format",
    .examples =
        "  footlight log info show.dmxlog\n"
        "  footlight log convert foh.show foh.dmxlog\n",
    .add = add,
};

}  // namespace footlight::tools
