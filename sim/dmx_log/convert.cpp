#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/format.h"
#include "sim/dmx_log/ola_show.h"

namespace footlight {
namespace {

std::uint64_t file_size(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

struct Summary {
  DurationNs end_ns = 0;
  std::uint64_t damage_count = 0;
};

using TakeFrame = std::function<Status(const LogFrame&)>;

// Runs through an OLA Show as if it were a log; frames that change nothing are told from changes here.
Result<Summary> for_each_ola(const std::string& path, int universe_offset, const TakeFrame& take) {
  FL_ASSIGN(OlaShowReader reader, OlaShowReader::open(path, universe_offset));
  std::map<Universe, Slots> looks;
  OlaShowFrame read;
  std::vector<SlotRun> runs;
  while (true) {
    FL_ASSIGN(const bool any, reader.next(read));
    if (!any) break;
    Slots& look = looks.try_emplace(read.universe, Slots{}).first->second;
    runs.clear();
    for (std::size_t slot = 0; slot < read.slots.size(); ++slot) {
      if (look[slot] != read.slots[slot]) runs.push_back({static_cast<std::uint16_t>(slot), 1});
    }
    std::copy(read.slots.begin(), read.slots.end(), look.begin());
    LogFrame frame;
    frame.time_ns = frame.stamp_ns = read.time_ns;
    frame.universe = read.universe;
    frame.slot_count = static_cast<int>(read.slots.size());
    frame.levels = look;
    frame.changes = runs;
    FL_TRY(take(frame));
  }
  return Summary{reader.time_ns(), 0};
}

Result<Summary> for_each_log(LogReader& reader, const TakeFrame& take) {
  LogFrame frame;
  DurationNs last_ns = 0;
  while (true) {
    FL_ASSIGN(const bool any, reader.next(frame));
    if (!any) break;
    last_ns = frame.time_ns;
    FL_TRY(take(frame));
  }
  const DurationNs end_ns = reader.info().finished ? std::max(reader.info().duration_ns, last_ns) : last_ns;
  return Summary{end_ns, reader.info().damage_count};
}

bool is_dmxlog_name(const std::string& path) { return path.ends_with(".dmxlog"); }

}  // namespace

Result<LogFormat> detect_log_format(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is a directory; name a file", path);
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    return fail(errno == EACCES ? ErrorCode::kPermission : ErrorCode::kNotFound, "{}: cannot open{}", path,
                errno == EACCES ? ": permission denied" : ": no such file");
  }
  char head[8] = {};
  stream.read(head, sizeof head);
  const std::string_view read(head, static_cast<std::size_t>(stream.gcount()));
  if (read.starts_with("OLA Show")) return LogFormat::kOlaShow;
  const std::string_view magic(reinterpret_cast<const char*>(dmx_log::kFileMagic), sizeof dmx_log::kFileMagic);
  if (!read.empty() && magic.starts_with(read)) return LogFormat::kDmxLog;
  return fail(ErrorCode::kBadInput, "{}: expected a DMX log or an OLA Show; {}", path,
              read.empty() ? "it is empty" : "it begins like neither");
}

Result<LogInfo> read_log_info(const std::string& path, bool check, int universe_offset) {
  FL_ASSIGN(const LogFormat format, detect_log_format(path));
  LogInfo info;
  std::map<Universe, LogUniverseInfo> universes;
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  const TakeFrame count = [&](const LogFrame& frame) -> Status {
    if (frame.restored) return {};
    const auto [place, is_new] = universes.try_emplace(frame.universe);
    LogUniverseInfo& universe = place->second;
    if (is_new || universe.frames == 0) universe.first_ns = frame.time_ns;
    universe.universe = frame.universe;
    universe.last_ns = frame.time_ns;
    universe.slot_count = std::max(universe.slot_count, frame.slot_count);
    ++universe.frames;
    ++frames;
    if (!frame.changes.empty()) {
      ++universe.changes;
      ++changes;
    }
    return {};
  };
  if (format == LogFormat::kOlaShow) {
    FL_ASSIGN(const Summary summary, for_each_ola(path, universe_offset, count));
    info.path = path;
    info.format = format;
    info.duration_ns = summary.end_ns;
    info.file_bytes = file_size(path);
    info.finished = info.checked = true;
  } else {
    FL_ASSIGN(LogReader reader, LogReader::open(path));
    if (reader.info().finished && !check) return reader.info();
    for (const LogUniverseInfo& universe : reader.info().universes) {
      universes[universe.universe].universe = universe.universe;  // those of the header, also if never heard
    }
    FL_ASSIGN(const Summary summary, for_each_log(reader, count));
    info = reader.info();
    info.duration_ns = summary.end_ns;
    info.checked = true;
  }
  info.frames = frames;
  info.changes = changes;
  info.universes.clear();
  for (const auto& [number, universe] : universes) info.universes.push_back(universe);
  return info;
}

Result<ConvertReport> convert_log(const std::string& in, const std::string& out, const ConvertOptions& options) {
  FL_ASSIGN(const LogFormat format, detect_log_format(in));
  std::error_code ignored;
  if (std::filesystem::equivalent(in, out, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is both input and output; name another output", out);
  }
  ConvertReport report;
  report.bytes_in = file_size(in);

  std::optional<LogReader> log;
  LogWriterOptions writer_options;
  writer_options.overwrite = options.overwrite;
  if (format == LogFormat::kDmxLog) {
    FL_ASSIGN(log, LogReader::open(in));
    writer_options.origin_ns = log->info().origin_ns;
    writer_options.wall_start_unix_ns = log->info().wall_start_unix_ns;
    for (const LogUniverseInfo& universe : log->info().universes) {
      writer_options.universes.push_back(universe.universe);
    }
  }
  const auto for_each = [&](const TakeFrame& take) {
    return log ? for_each_log(*log, take) : for_each_ola(in, options.universe_offset, take);
  };
  std::set<Universe> heard;
  const auto is_left_out = [&](const LogFrame& frame) {
    const bool first = heard.insert(frame.universe).second;
    return options.changes_only && !first && frame.changes.empty() && !frame.terminated;
  };

  if (is_dmxlog_name(out)) {
    FL_ASSIGN(LogWriter writer, LogWriter::create(out, writer_options));
    const Result<Summary> summary = for_each([&](const LogFrame& frame) -> Status {
      if (is_left_out(frame)) {
        ++report.left_out;
        return {};
      }
      ++report.frames;
      FrameView view;
      view.universe = frame.universe;
      view.stamp_ns = writer_options.origin_ns + frame.time_ns;
      view.sender = frame.sender;
      view.sequence = frame.sequence;
      view.priority = frame.priority;
      view.terminated = frame.terminated;
      // What came of a whole universe out of damage may go beyond the length of the frame that brought it.
      view.slots = frame.restored ? frame.levels : frame.slots();
      return writer.append(view);
    });
    if (!summary) {
      std::filesystem::remove(writer.written_path(), ignored);
      return tl::unexpected<Error>(summary.error());
    }
    FL_TRY(writer.close(writer_options.origin_ns + summary->end_ns));
    report.duration_ns = summary->end_ns;
    report.damage_count = summary->damage_count;
  } else {
    FL_ASSIGN(OlaShowWriter writer, OlaShowWriter::create(out, options.overwrite));
    const Result<Summary> summary = for_each([&](const LogFrame& frame) -> Status {
      if (is_left_out(frame) || frame.terminated) {
        ++report.left_out;
        return {};
      }
      ++report.frames;
      return writer.append(frame.time_ns, frame.universe, frame.restored ? frame.levels : frame.slots());
    });
    if (!summary) {
      std::filesystem::remove(out + ".part", ignored);
      return tl::unexpected<Error>(summary.error());
    }
    FL_TRY(writer.close(summary->end_ns));
    report.lead_dropped_ns = writer.lead_ns();
    report.duration_ns = summary->end_ns - writer.lead_ns();
    report.damage_count = summary->damage_count;
  }
  report.bytes_out = file_size(out);
  return report;
}

}  // namespace footlight
