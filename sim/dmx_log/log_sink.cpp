#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "sim/core/check.h"
#include "sim/core/no_signals.h"
#include "sim/dmx_log/log_ports.h"

namespace footlight {
namespace {

constexpr DurationNs kWakePeriodNs = 250 * kNsPerMs;  // the longest time frames wait for the writing thread
constexpr std::size_t kWakeBytes = 256u << 10;        // and the most bytes of them

// Frames on their way to the writing thread. Their slots are stored end to end.
struct Waiting {
  std::vector<FrameView> frames;  // slots unset
  std::vector<std::uint16_t> slot_counts;
  std::vector<std::uint8_t> slots;

  [[nodiscard]] std::size_t size_bytes() const { return frames.size() * (sizeof(FrameView) + 2) + slots.size(); }
  void clear() {
    frames.clear();
    slot_counts.clear();
    slots.clear();
  }
};

}  // namespace

struct LogSink::Impl {
  Impl(std::string name_in, LogWriter writer_in, const LogSinkOptions& options_in)
      : name(std::move(name_in)),
        options(options_in),
        wanted(static_cast<std::size_t>(kUniverseMax) + 1, false),
        writer(std::move(writer_in)),
        next_wake_ns(options_in.start_ns + kWakePeriodNs) {
    for (const Universe universe : options.universes) wanted[static_cast<std::size_t>(universe)] = true;
    const NoSignals for_the_thread;
    thread = std::thread([this] { run(); });
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { stop(std::nullopt); }

  // Without end_ns the log stays unfinished, with all frames received.
  void stop(std::optional<TimeNs> end_ns) {
    if (!thread.joinable()) return;
    {
      const std::lock_guard lock(mutex);
      stopping = true;
      end_stamp_ns = end_ns;
    }
    wake.notify_one();
    thread.join();
  }

  void run() {
    Waiting taken;
    while (true) {
      bool last = false;
      bool flush = false;
      TimeNs now_ns = 0;
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [this] { return stopping || woken; });
        woken = false;
        flush = std::exchange(flush_wanted, false);
        last = stopping;
        now_ns = newest_ns;
        std::swap(taken, waiting);
      }
      const Status status = write(taken, now_ns, flush, last);
      taken.clear();
      const std::lock_guard lock(mutex);
      writer_stats = writer.stats();
      if (!status && !error) error = status.error();
      if (last) return;
    }
  }

  Status write(const Waiting& taken, TimeNs now_ns, bool flush, bool last) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < taken.frames.size(); ++i) {
      FrameView view = taken.frames[i];
      view.slots = std::span(taken.slots).subspan(at, taken.slot_counts[i]);
      at += taken.slot_counts[i];
      FL_TRY(writer.append(view));
    }
    if (last && end_stamp_ns && !options.keep_empty && writer.stats().frames == 0) {
      writer.discard();
      return {};
    }
    if (!last) return flush ? writer.flush() : writer.tick(now_ns);
    return end_stamp_ns ? writer.close(*end_stamp_ns) : writer.flush();
  }

  const std::string name;
  const LogSinkOptions options;
  std::vector<bool> wanted;

  // Used by the writing thread until it has ended.
  LogWriter writer;

  // Used by the pump's thread.
  TimeNs next_wake_ns;
  TimeNs flush_due_ns = kTimeNever;  // of the open block; kTimeNever: no frame since the last flush
  PortCounters counted;
  bool closed = false;

  mutable std::mutex mutex;  // guards what follows; never held during disk I/O
  std::condition_variable wake;
  Waiting waiting;
  TimeNs newest_ns = 0;
  bool woken = false;
  bool flush_wanted = false;
  bool stopping = false;
  std::optional<TimeNs> end_stamp_ns;
  std::optional<Error> error;
  LogWriterStats writer_stats;

  std::thread thread;
};

LogSink::LogSink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LogSink::~LogSink() = default;

Result<std::unique_ptr<LogSink>> LogSink::create(const std::string& path, const LogSinkOptions& options) {
  if (options.universes.empty()) {
    return fail(ErrorCode::kBadInput, "log:{}: expected at least one universe to record", path);
  }
  FL_CHECK(options.flush_after_ns > 0);
  LogWriterOptions writer_options = options.writer;
  writer_options.origin_ns = options.start_ns;
  writer_options.universes = options.universes;
  FL_ASSIGN(LogWriter writer, LogWriter::create(path, writer_options));  // also checks the universes
  LogSinkOptions checked = options;
  std::sort(checked.universes.begin(), checked.universes.end());
  checked.universes.erase(std::unique(checked.universes.begin(), checked.universes.end()), checked.universes.end());
  return std::unique_ptr<LogSink>(new LogSink(std::make_unique<Impl>("log:" + path, std::move(writer), checked)));
}

std::string LogSink::name() const { return impl_->name; }
TimeNs LogSink::next_deadline_ns() const {
  return impl_->closed ? kTimeNever : std::min(impl_->next_wake_ns, impl_->flush_due_ns);
}

PortState LogSink::state() const {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->error) return PortState::kGone;
  return impl_->closed ? PortState::kEnded : PortState::kWorking;
}

std::string LogSink::trouble() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->error ? impl_->error->message : std::string{};
}

PortCounters LogSink::counters() const {
  PortCounters counters = impl_->counted;
  const std::lock_guard lock(impl_->mutex);
  counters.errors = impl_->error ? 1 : 0;
  return counters;
}

Status LogSink::send(TimeNs now_ns, std::span<const FrameView> frames) {
  if (impl_->closed) return {};
  bool wake = false;
  {
    const std::lock_guard lock(impl_->mutex);
    Waiting& waiting = impl_->waiting;
    impl_->newest_ns = std::max(impl_->newest_ns, now_ns);
    for (const FrameView& frame : frames) {
      FL_CHECK(is_universe(frame.universe));
      if (!impl_->wanted[static_cast<std::size_t>(frame.universe)]) continue;
      const std::size_t size_bytes = sizeof(FrameView) + 2 + frame.slots.size();
      if (impl_->error || waiting.size_bytes() + size_bytes > impl_->options.waiting_bytes_max) {
        ++impl_->counted.dropped;
        continue;
      }
      FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
      waiting.frames.push_back(frame);
      waiting.frames.back().slots = {};
      waiting.slot_counts.push_back(static_cast<std::uint16_t>(frame.slots.size()));
      waiting.slots.insert(waiting.slots.end(), frame.slots.begin(), frame.slots.end());
      // the writer leaves out the others and counts them
      if (frame.start_code == kStartCodeLevels) ++impl_->counted.frames;
      if (impl_->flush_due_ns == kTimeNever) impl_->flush_due_ns = now_ns + impl_->options.flush_after_ns;
    }
    if (waiting.size_bytes() >= kWakeBytes && !impl_->woken) wake = impl_->woken = true;
  }
  if (wake) impl_->wake.notify_one();
  return {};
}

Status LogSink::poll(TimeNs now_ns) {
  if (now_ns < next_deadline_ns()) return {};
  const bool flush = now_ns >= impl_->flush_due_ns;
  if (flush) impl_->flush_due_ns = kTimeNever;
  impl_->next_wake_ns = now_ns + kWakePeriodNs;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->newest_ns = std::max(impl_->newest_ns, now_ns);
    impl_->woken = true;
    impl_->flush_wanted = impl_->flush_wanted || flush;
  }
  impl_->wake.notify_one();
  return {};
}

std::span<const Universe> LogSink::universes() const { return impl_->options.universes; }

void LogSink::close(TimeNs now_ns) {
  if (impl_->closed) return;
  impl_->stop(now_ns);
  impl_->closed = true;
}

LogWriterStats LogSink::stats() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->writer_stats;
}

}  // namespace footlight
