#include "tools/footlight/preview/recording.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "sim/core/counted.h"
#include "sim/core/no_signals.h"

namespace footlight::tools {
namespace {

constexpr std::chrono::milliseconds kLookPeriod(100);  // for a block that is due
constexpr int kNamesMax = 1'000;

}  // namespace

std::string recording_path(const std::string& folder, const std::string& rig, std::int64_t unix_ns) {
  namespace fs = std::filesystem;
  const fs::path file = rig.empty() ? fs::path("demo") : fs::path(rig);
  const fs::path place = folder.empty() ? file.parent_path() : fs::path(folder);
  const auto when = fmt::localtime(static_cast<std::time_t>(unix_ns / kNsPerS));
  const std::string stem = fmt::format("{}_{:%Y-%m-%d_%H-%M-%S}", file.stem().string(), when);
  std::error_code unknown;
  for (int number = 1;; ++number) {
    const fs::path path = place / (number == 1 ? stem + ".dmxlog" : fmt::format("{}_{}.dmxlog", stem, number));
    if (number == kNamesMax || (!fs::exists(path, unknown) && !fs::exists(path.string() + ".part", unknown))) {
      return path.string();
    }
  }
}

Recording::Recording(std::unique_ptr<LogSink> log, std::string path, Clock& clock)
    : clock_(clock),
      path_(std::move(path)),
      start_ns_(clock.now_ns()),
      last_(log->universes().size() * kSlotCountMax),
      known_(log->universes().size()),
      log_(std::move(log)) {
  const NoSignals for_the_thread;
  thread_ = std::thread([this] { work(); });
}

Result<std::unique_ptr<Recording>> Recording::start(const std::string& path, std::span<const Universe> universes,
                                                    Clock& clock, std::int64_t unix_ns) {
  if (universes.empty()) {
    return fail(ErrorCode::kBadInput, "nothing to record: no fixture and no display of this rig has an address");
  }
  LogSinkOptions options;
  options.universes.assign(universes.begin(), universes.end());
  options.start_ns = clock.now_ns();
  options.writer.wall_start_unix_ns = unix_ns;
  options.writer.sync_blocks = true;
  FL_ASSIGN(std::unique_ptr<LogSink> log, LogSink::create(path, options));
  return std::unique_ptr<Recording>(new Recording(std::move(log), path, clock));
}

Recording::~Recording() { (void)end(); }

void Recording::work() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    (void)log_->poll(clock_.now_ns());  // see trouble()
    wake_.wait_for(lock, kLookPeriod);
  }
}

void Recording::take(TimeNs at_ns, std::span<const Universe> universes, std::span<const std::uint8_t> levels) {
  const std::lock_guard lock(mutex_);
  if (ending_) return;
  const auto recorded = log_->universes();
  std::vector<FrameView> frames;
  for (std::size_t i = 0; i < universes.size() && (i + 1) * kSlotCountMax <= levels.size(); ++i) {
    const auto at = std::lower_bound(recorded.begin(), recorded.end(), universes[i]);
    if (at == recorded.end() || *at != universes[i]) {
      left_out_ = true;
      continue;
    }
    const auto place = static_cast<std::size_t>(at - recorded.begin());
    const auto now = levels.subspan(i * kSlotCountMax, kSlotCountMax);
    const auto before = last_.begin() + static_cast<std::ptrdiff_t>(place * kSlotCountMax);
    if (known_[place] && std::equal(now.begin(), now.end(), before)) continue;
    known_[place] = true;
    std::copy(now.begin(), now.end(), before);
    FrameView& frame = frames.emplace_back();
    frame.universe = universes[i];
    frame.stamp_ns = std::max(at_ns, start_ns_);
    frame.sender = 1;
    frame.sequence = ++sequence_;
    frame.slots = now;
  }
  if (!frames.empty()) (void)log_->send(frames.front().stamp_ns, frames);  // see trouble()
}

std::string Recording::trouble() const {
  const std::lock_guard lock(mutex_);
  return log_->trouble();
}

Result<std::string> Recording::end() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(ending_, true)) return fail(ErrorCode::kBadInput, "{}: it has ended already", path_);
  }
  wake_.notify_all();
  thread_.join();
  const DurationNs recorded_ns = elapsed_ns();
  log_->close(clock_.now_ns());
  if (const std::string why = log_->trouble(); !why.empty()) {
    return fail(ErrorCode::kIo, "the recording ended: {}; what was written before stays readable", why);
  }
  const LogWriterStats stats = log_->stats();
  const std::uint64_t lost = log_->counters().dropped;
  return fmt::format("recorded {:.1f} s, {}: {}{}{}", static_cast<double>(recorded_ns) * 1e-9,
                     counted(stats.changes, "change"), std::filesystem::absolute(path_).string(),
                     lost == 0 ? "" : fmt::format("; {} lost, the disk was too slow", counted(lost, "frame")),
                     left_out_ ? "; without the universes that an edit has added" : "");
}

}  // namespace footlight::tools
