#include "tools/footlight/preview/compared_log.h"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace footlight::tools {
namespace {

constexpr DurationNs kReadOnNs = 5 * kNsPerS;  // a seek costs as much as reading on by about this much

}  // namespace

ComparedLog::ComparedLog(LogReader reader, std::string name, std::vector<Universe> universes)
    : reader_(std::move(reader)), name_(std::move(name)) {
  moment_.levels.resize(universes.size() * kSlotCountMax);
  moment_.universes = std::move(universes);
}

Result<ComparedLog> ComparedLog::open(LogReader reader, const std::string& path, std::vector<Universe> universes) {
  ComparedLog log(std::move(reader), std::filesystem::path(path).filename().string(), std::move(universes));
  FL_TRY(log.go_to(0));
  return log;
}

Status ComparedLog::set_universes(std::vector<Universe> universes) {
  const TimeNs now_ns = now_ns_;
  *this = ComparedLog(reader_.again(), std::move(name_), std::move(universes));
  return go_to(now_ns);
}

void ComparedLog::take(Universe universe, std::span<const std::uint8_t> levels) {
  const auto at = std::lower_bound(moment_.universes.begin(), moment_.universes.end(), universe);
  if (at == moment_.universes.end() || *at != universe) return;
  std::copy(levels.begin(), levels.end(),
            moment_.levels.begin() + (at - moment_.universes.begin()) * std::ptrdiff_t{kSlotCountMax});
}

Status ComparedLog::go_to(TimeNs time_ns) {
  time_ns = std::clamp<TimeNs>(time_ns, 0, duration_ns());
  if (time_ns < now_ns_ || time_ns > now_ns_ + kReadOnNs || now_ns_ < 0) {
    FL_TRY(reader_.seek(time_ns));
    std::fill(moment_.levels.begin(), moment_.levels.end(), std::uint8_t{0});
    for (const LogSnapshot& each : reader_.snapshot()) take(each.universe, each.levels);
    has_next_ = at_end_ = false;
  }
  while (!at_end_) {
    if (!has_next_) {
      FL_ASSIGN(has_next_, reader_.next(next_));
      at_end_ = !has_next_;
      continue;
    }
    if (next_.time_ns > time_ns) break;  // of any universe, so no log is read to its end
    if (!next_.terminated) take(next_.universe, next_.levels);
    has_next_ = false;
  }
  now_ns_ = time_ns;
  return {};
}

}  // namespace footlight::tools
