#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "sim/core/check.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/log_input.h"
#include "sim/dmx_log/ola_show.h"

namespace footlight {
namespace {

std::uint64_t file_size(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

bool is_dmxlog_name(const std::string& path) { return path.ends_with(".dmxlog"); }

// Selects the frames of the result and renumbers their universes.
class Choice {
 public:
  Choice(const ConvertOptions& options, ConvertReport& report) : options_(options), report_(report) {}

  Status prepare(const std::string& path) {
    std::set<Universe> given;
    for (const auto& [from, to] : options_.renumber) {
      if (!is_universe(from) || !is_universe(to)) {
        return fail(ErrorCode::kBadInput, "{}: expected universes from 1 to {}, got {} to {}", path, kUniverseMax, from,
                    to);
      }
      if (!renumber_.try_emplace(from, to).second || !given.insert(to).second) {
        return fail(ErrorCode::kBadInput, "{}: universe {} to {}: one of them is named twice", path, from, to);
      }
    }
    return {};
  }

  // Renumbers `frame`; false if it is left out.
  bool take(FrameView& frame) {
    if (!renumber_.empty()) {
      const auto place = renumber_.find(frame.universe);
      if (place == renumber_.end()) {
        ++report_.other_universes;
        return false;
      }
      seen_.insert(place->first);
      frame.universe = place->second;
    }
    if (!options_.changes_only) return true;
    const auto [place, first] = snapshots_.try_emplace(frame.universe, Slots{});
    const bool repeats =
        !first && !frame.terminated && std::equal(frame.slots.begin(), frame.slots.end(), place->second.begin());
    if (!frame.terminated) std::copy(frame.slots.begin(), frame.slots.end(), place->second.begin());
    if (repeats) ++report_.left_out;
    return !repeats;
  }

  void finish() const {
    for (const auto& [from, to] : renumber_) {
      if (!seen_.contains(from)) report_.absent.push_back(from);
    }
  }

 private:
  const ConvertOptions& options_;
  ConvertReport& report_;
  std::map<Universe, Universe> renumber_;
  std::set<Universe> seen_;
  std::map<Universe, Slots> snapshots_;
};

Status for_each(LogInput& in, Choice& choice, const std::function<Status(const FrameView&)>& write) {
  FrameView frame;
  while (true) {
    FL_ASSIGN(const bool any, in.next(frame));
    if (!any) return {};
    if (choice.take(frame)) FL_TRY(write(frame));
  }
}

}  // namespace

Result<LogInfo> read_log_info(const std::string& path, bool check) {
  FL_ASSIGN(LogReader reader, LogReader::open(path));
  if (reader.info().finished && !check) return reader.info();
  std::map<Universe, LogUniverseInfo> universes;
  for (const LogUniverseInfo& universe : reader.info().universes) {
    universes[universe.universe].universe = universe.universe;  // lists the universes of the header, also without
                                                                // frames
  }
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  DurationNs last_ns = 0;
  LogFrame frame;
  while (true) {
    FL_ASSIGN(const bool any, reader.next(frame));
    if (!any) break;
    last_ns = frame.time_ns;
    if (frame.restored) continue;
    LogUniverseInfo& universe = universes[frame.universe];
    if (universe.frames == 0) universe.first_ns = frame.time_ns;
    universe.universe = frame.universe;
    universe.last_ns = frame.time_ns;
    universe.slot_count = std::max(universe.slot_count, frame.slot_count);
    ++universe.frames;
    ++frames;
    if (!frame.changes.empty()) {
      ++universe.changes;
      ++changes;
    }
  }
  LogInfo info = reader.info();
  info.duration_ns = info.finished ? std::max(info.duration_ns, last_ns) : last_ns;
  info.checked = true;
  info.frames = frames;
  info.changes = changes;
  info.universes.clear();
  for (const auto& [number, universe] : universes) info.universes.push_back(universe);
  return info;
}

Result<ConvertReport> convert_log(LogInput& in, const std::string& out, const ConvertOptions& options) {
  std::error_code ignored;
  if (std::filesystem::equivalent(in.path(), out, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is both input and output; name another output", out);
  }
  ConvertReport report;
  report.bytes_in = file_size(in.path());
  Choice choice(options, report);
  FL_TRY(choice.prepare(in.path()));
  const TimeNs origin_ns = in.origin_ns();

  if (is_dmxlog_name(out)) {
    LogWriterOptions writer_options;
    writer_options.overwrite = options.overwrite;
    writer_options.origin_ns = origin_ns;
    writer_options.wall_start_unix_ns = in.wall_start_unix_ns();
    if (options.renumber.empty()) writer_options.universes = in.universes();
    for (const auto& [from, to] : options.renumber) writer_options.universes.push_back(to);
    FL_ASSIGN(LogWriter writer, LogWriter::create(out, writer_options));
    const Status status = for_each(in, choice, [&](const FrameView& frame) {
      ++report.frames;
      return writer.append(frame);
    });
    if (!status) {
      std::filesystem::remove(writer.written_path(), ignored);
      return tl::unexpected<Error>(status.error());
    }
    FL_TRY(writer.close(in.end_ns()));
    report.late_stamps = writer.stats().late_stamps;
    report.duration_ns = in.end_ns() - origin_ns;
  } else {
    FL_ASSIGN(OlaShowWriter writer, OlaShowWriter::create(out, options.overwrite));
    DurationNs last_ns = 0;
    const Status status = for_each(in, choice, [&](const FrameView& frame) -> Status {
      if (frame.terminated) {
        ++report.left_out;
        return {};
      }
      ++report.frames;
      const DurationNs time_ns = frame.stamp_ns - origin_ns;
      if (time_ns < last_ns) ++report.late_stamps;
      last_ns = std::max(last_ns, time_ns);
      return writer.append(last_ns, frame.universe, frame.slots);
    });
    if (!status) {
      std::filesystem::remove(out + ".part", ignored);
      return tl::unexpected<Error>(status.error());
    }
    const DurationNs end_ns = std::max(in.end_ns() - origin_ns, last_ns);
    FL_TRY(writer.close(end_ns));
    report.lead_dropped_ns = writer.lead_ns();
    report.duration_ns = end_ns - writer.lead_ns();
  }
  choice.finish();
  report.bytes_out = file_size(out);
  report.damage_count = in.damage_count();
  report.notes = in.notes();
  return report;
}

}  // namespace footlight
