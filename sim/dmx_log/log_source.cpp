#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "sim/core/check.h"
#include "sim/dmx_log/format.h"
#include "sim/dmx_log/log_ports.h"

namespace footlight {
namespace {

constexpr double kSpeedMin = 0.001;
constexpr double kSpeedMax = 1000.0;

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): spreads ids that are close together over 64 bits.
std::uint64_t spread(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15u;
  value = (value ^ value >> 30) * 0xBF58476D1CE4E5B9u;
  value = (value ^ value >> 27) * 0x94D049BB133111EBu;
  return value ^ value >> 31;
}

}  // namespace

struct LogSource::Impl {
  Impl(LogReader reader_in, std::string name_in, const LogSourceOptions& options_in)
      : reader(std::move(reader_in)), name(std::move(name_in)), options(options_in) {}

  Status prepare() {
    if (!(options.speed >= kSpeedMin && options.speed <= kSpeedMax)) {
      return fail(ErrorCode::kBadInput, "{}: expected a speed from {} to {}, got {}", name, kSpeedMin, kSpeedMax,
                  options.speed);
    }
    std::set<Universe> seen;
    for (const LogUniverseInfo& universe : reader.info().universes) seen.insert(universe.universe);
    if (!reader.info().finished) {
      // The header lists the requested universes. Those received are known only from the frames.
      LogFrame any_frame;
      while (true) {
        FL_ASSIGN(const bool any, reader.next(any_frame));
        if (!any) break;
        seen.insert(any_frame.universe);
      }
    }
    for (const auto& [from, to] : options.renumber) {
      if (!is_universe(from) || !is_universe(to)) {
        return fail(ErrorCode::kBadInput, "{}: expected universes from 1 to {}, got {} to {}", name, kUniverseMax, from,
                    to);
      }
      if (!renumber.try_emplace(from, to).second) {
        return fail(ErrorCode::kBadInput, "{}: universe {} is renumbered twice", name, from);
      }
    }
    std::set<Universe> given;
    for (const Universe universe : seen) {
      if (const Universe to = renumbered(universe); to != 0 && !given.insert(to).second) {
        return fail(ErrorCode::kBadInput, "{}: two universes of the log would both become universe {}", name, to);
      }
    }
    universes.assign(given.begin(), given.end());

    log_end_ns = reader.info().duration_ns;
    stop_ns = std::min(options.stop_ns, log_end_ns);
    if (options.start_ns < 0 || options.start_ns > log_end_ns) {
      return fail(ErrorCode::kBadInput, "{}: cannot start at {:.3f} s; the log lasts {:.3f} s", name,
                  static_cast<double>(options.start_ns) * 1e-9, static_cast<double>(log_end_ns) * 1e-9);
    }
    if (options.stop_ns < options.start_ns || (options.loop && stop_ns == options.start_ns)) {
      return fail(ErrorCode::kBadInput, "{}: there is no time between the start at {:.3f} s and the end at {:.3f} s",
                  name, static_cast<double>(options.start_ns) * 1e-9, static_cast<double>(stop_ns) * 1e-9);
    }
    for (const char c : name) salt = spread(salt ^ static_cast<unsigned char>(c));
    return begin_pass();
  }

  // 0: left out.
  Universe renumbered(Universe universe) const {
    const auto place = renumber.find(universe);
    if (place != renumber.end()) return place->second;
    return options.only_renumbered ? 0 : universe;
  }

  Status begin_pass() {
    first_snapshots.clear();
    if (options.start_ns > 0) {
      FL_TRY(reader.seek(options.start_ns));
      for (const LogSnapshot& snapshot : reader.snapshot()) {
        Owned& owned = first_snapshots.emplace_back();
        owned.view.universe = snapshot.universe;
        owned.view.sender = snapshot.sender;
        owned.view.sequence = snapshot.sequence;
        owned.view.priority = snapshot.priority;
        owned.view.terminated = snapshot.terminated;
        std::copy(snapshot.levels.begin(), snapshot.levels.end(), owned.levels.begin());
      }
    } else {
      FL_TRY(reader.rewind());
    }
    return fetch();
  }

  // Reads the next frame as soon as the previous one is out, so that a block is decompressed in the pause between
  // frames and not when a frame is due.
  Status fetch() {
    FL_ASSIGN(has_frame, reader.next(frame));
    // A frame exactly at the end of the log is played. A frame exactly at a stop time set by the user is not: it
    // belongs to the next part.
    if (has_frame && frame.time_ns >= stop_ns && stop_ns < log_end_ns) has_frame = false;
    return {};
  }

  TimeNs due_ns(DurationNs time_ns) const {
    const DurationNs played_ns = time_ns - options.start_ns;
    if (options.speed == 1.0) return pass_start_ns + played_ns;
    return pass_start_ns + std::llround(static_cast<long double>(played_ns) / static_cast<long double>(options.speed));
  }

  void give(FrameReceiver& receiver, FrameView view, TimeNs stamp_ns) {
    view.universe = renumbered(view.universe);
    if (view.universe == 0) return;
    view.stamp_ns = stamp_ns;
    view.sender = std::max<SenderId>(spread(salt ^ spread(view.sender)), 1);
    receiver.receive(view);
    ++frames;
  }

  TimeNs next_due_ns() const {
    if (ended) return kTimeNever;
    if (!started) return 0;
    if (!first_snapshots.empty()) return pass_start_ns;
    return due_ns(has_frame ? frame.time_ns : stop_ns);
  }

  Status poll(TimeNs now_ns, FrameReceiver& receiver) {
    if (!started) {
      pass_start_ns = now_ns;
      started = true;
    }
    while (!ended) {
      const TimeNs due = next_due_ns();
      if (due > now_ns) return {};
      if (!first_snapshots.empty()) {
        for (const Owned& owned : first_snapshots) {
          FrameView view = owned.view;
          view.slots = owned.levels;
          give(receiver, view, due);
        }
        first_snapshots.clear();
      } else if (has_frame) {
        FrameView view;
        view.universe = frame.universe;
        view.sender = frame.sender;
        view.sequence = frame.sequence;
        view.priority = frame.priority;
        view.terminated = frame.terminated;
        view.slots = frame.restored ? frame.levels : frame.slots();
        give(receiver, view, due);
        FL_TRY(fetch());
      } else if (options.loop) {
        pass_start_ns = due;
        ++passes;
        FL_TRY(begin_pass());
      } else {
        ended = true;
      }
    }
    return {};
  }

  struct Owned {
    FrameView view;
    Slots levels{};
  };

  LogReader reader;
  std::string name;
  LogSourceOptions options;
  std::map<Universe, Universe> renumber;
  std::vector<Universe> universes;
  std::uint64_t salt = 0;
  DurationNs log_end_ns = 0;
  DurationNs stop_ns = 0;

  bool started = false;
  bool ended = false;
  TimeNs pass_start_ns = 0;  // when options.start_ns of this pass is due
  std::vector<Owned> first_snapshots;
  LogFrame frame;  // the next frame; its spans belong to the reader
  bool has_frame = false;
  std::uint64_t passes = 0;
  std::uint64_t frames = 0;
};

LogSource::LogSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LogSource::~LogSource() = default;

Result<std::unique_ptr<LogSource>> LogSource::from_reader(LogReader reader, const std::string& name,
                                                          const LogSourceOptions& options) {
  auto impl = std::make_unique<Impl>(std::move(reader), name, options);
  FL_TRY(impl->prepare());
  return std::unique_ptr<LogSource>(new LogSource(std::move(impl)));
}

void LogSource::start(TimeNs now_ns) {
  FL_CHECK(!impl_->started);
  impl_->pass_start_ns = now_ns;
  impl_->started = true;
}

std::string LogSource::name() const { return impl_->name; }
TimeNs LogSource::next_deadline_ns() const { return impl_->next_due_ns(); }
PortState LogSource::state() const { return impl_->ended ? PortState::kEnded : PortState::kWorking; }
std::string LogSource::trouble() const { return {}; }
PortCounters LogSource::counters() const {
  PortCounters counters;
  counters.frames = impl_->frames;
  counters.rejected = impl_->reader.info().damage_count;
  return counters;
}
Status LogSource::poll(TimeNs now_ns, FrameReceiver& receiver) { return impl_->poll(now_ns, receiver); }
std::span<const Universe> LogSource::universes() const { return impl_->universes; }
const LogInfo& LogSource::info() const { return impl_->reader.info(); }
std::uint64_t LogSource::passes() const { return impl_->passes; }

}  // namespace footlight
