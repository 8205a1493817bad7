#include "tools/footlight/preview/compared_log.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace footlight::tools {
namespace {

constexpr DurationNs kReadOnNs = 5 * kNsPerS;  // a seek costs as much as reading on by about this much

}  // namespace

ComparedLog::ComparedLog(LogReader reader, std::string name, std::vector<Universe> universes)
    : reader_(std::move(reader)),
      name_(std::move(name)),
      duration_ns_(reader_.info().duration_ns),
      changes_(reader_.again(), universes) {
  moment_.levels.resize(universes.size() * kSlotCountMax);
  moment_.universes = std::move(universes);
  next_.universe = -1;
}

Result<ComparedLog> ComparedLog::open(const std::string& path, std::vector<Universe> universes) {
  FL_ASSIGN(LogReader reader, LogReader::open(path));
  ComparedLog log(std::move(reader), std::filesystem::path(path).filename().string(), std::move(universes));
  FL_TRY(log.go_to(0));
  return log;
}

Status ComparedLog::set_universes(std::vector<Universe> universes) {
  const TimeNs now_ns = now_ns_;
  *this = ComparedLog(reader_.again(), std::move(name_), std::move(universes));
  return go_to(now_ns);
}

Status ComparedLog::go_to(TimeNs time_ns) {
  time_ns = std::clamp<TimeNs>(time_ns, 0, duration_ns_);
  if (time_ns < now_ns_ || time_ns > now_ns_ + kReadOnNs || now_ns_ < 0) {
    FL_TRY(changes_.seek(time_ns));
    changes_.read_levels(moment_.levels);
    next_.universe = -1;
    at_end_ = false;
  }
  while (!at_end_) {
    if (next_.universe < 0) {
      FL_ASSIGN(const bool more, changes_.next(next_));
      at_end_ = !more;
      if (at_end_) break;
    }
    if (next_.at_ns > time_ns) break;
    std::copy(next_.levels.begin(), next_.levels.end(),
              moment_.levels.begin() + std::ptrdiff_t{next_.universe} * kSlotCountMax);
    next_.universe = -1;
  }
  now_ns_ = time_ns;
  return {};
}

}  // namespace footlight::tools
