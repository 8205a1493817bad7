#include "drivers/gpio/gpio_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>

#include <sys/epoll.h>
#include <unistd.h>

#include "drivers/gpio/gpio_model.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kRepeatNs = 800 * kNsPerMs;  // the interval of E1.31 section 6.6.2 for unchanged levels
constexpr DurationNs kSilenceMaxNs = 2'500 * kNsPerMs;
constexpr DurationNs kReadLevelsNs = kNsPerS;
constexpr DurationNs kRetryNs = 250 * kNsPerMs;
constexpr DurationNs kStormNs = 100 * kNsPerMs;  // the window, and the pause after it
constexpr int kStormEdgesMax = 200;
constexpr DurationNs kReportAgainNs = 10 * kNsPerS;
constexpr int kReadsMax = 4;  // per line and poll; remaining edges make the descriptor readable again

}  // namespace

// --- From an edge to a frame, top down -------------------------------------------------------------------------------

Status GpioSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  if (!is_open() && now_ns >= retry_ns_) {
    if (const Status opened = open_lines(now_ns); !opened) {
      trouble_ = opened.error().message;
      retry_ns_ = now_ns + kRetryNs;
    }
  }
  if (is_open()) {
    Status read = read_ready(now_ns, receiver);
    if (read) read = read_due_levels(now_ns, receiver);
    if (!read) lose_lines(read.error(), now_ns, receiver);
  }
  for (Line& line : lines_) line.strobe.advance(now_ns);
  deliver_changes(receiver);
  if (now_ns >= repeat_ns_) {
    // Priorities first: the levels of the other slots must not be used.
    deliver(now_ns, kStartCodePriorities, receiver);
    deliver(now_ns, kStartCodeLevels, receiver);
    repeat_ns_ = now_ns + kRepeatNs;
  }
  report_capped(now_ns);
  return {};
}

Status GpioSource::read_ready(TimeNs now_ns, FrameReceiver& receiver) {
  std::array<epoll_event, 64> events;
  const int count = ::epoll_wait(epoll_fd_, events.data(), static_cast<int>(events.size()), 0);
  for (int i = 0; i < count; ++i) FL_TRY(read_line(events[static_cast<std::size_t>(i)].data.u64, now_ns, receiver));
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (lines_[i].input->fd() < 0 && lines_[i].input->next_edge_ns() <= now_ns) FL_TRY(read_line(i, now_ns, receiver));
  return {};
}

Status GpioSource::read_line(std::size_t index, TimeNs now_ns, FrameReceiver& receiver) {
  Line& line = lines_[index];
  std::array<GpioEdge, kGpioQueueEdges> edges;
  bool was_full = false;
  for (int reads = 0; reads < kReadsMax; ++reads) {
    FL_ASSIGN(const std::size_t count, line.input->read_edges(edges));
    for (std::size_t i = 0; i < count; ++i) {
      line.strobe.edge(edges[i].level, edges[i].stamp_ns);
      deliver_changes(receiver);
    }
    line.storm_edges += static_cast<int>(count);
    was_full = was_full || count == kGpioQueueEdges;
    if (count < edges.size()) break;
  }
  if (was_full) {
    // The queue does not report lost edges.
    FL_ASSIGN(const bool level, line.input->read_level());
    line.strobe.read_level(level, clock_.now_ns());
    deliver_changes(receiver);
  }
  if (now_ns - line.storm_ns >= kStormNs) {
    line.storm_ns = now_ns;
    line.storm_edges = 0;
  }
  if (line.storm_edges <= kStormEdgesMax || line.input->fd() < 0) return {};
  line.ignored_until_ns = now_ns + kStormNs;
  FL_TRY(listen(index, false));
  if (now_ns >= report_storm_ns_) {
    report_storm_ns_ = now_ns + kReportAgainNs;
    notices_.push_back(
        {NoticeLevel::kWarning, "edge-storm",
         fmt::format(
             "line {}: more than {} edges in {} ms; until this ends it is read ten times a second; for a floating "
             "input set bias = \"pull-up\" or add a resistor",
             config_.lines[index], kStormEdgesMax, kStormNs / kNsPerMs)});
  }
  return {};
}

Status GpioSource::read_due_levels(TimeNs now_ns, FrameReceiver& receiver) {
  const bool all = now_ns >= read_levels_ns_;
  if (all) read_levels_ns_ = now_ns + kReadLevelsNs;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    const bool rested = line.ignored_until_ns <= now_ns;
    if (rested) {
      // The queue is old and has gaps: use the current level.
      std::array<GpioEdge, kGpioQueueEdges> edges;
      FL_TRY(line.input->read_edges(edges));
      FL_TRY(listen(i, true));
      line.ignored_until_ns = kTimeNever;
      line.storm_ns = now_ns;
      line.storm_edges = 0;
    }
    if (line.ignored_until_ns != kTimeNever || !(all || rested || line.strobe.needs_level(now_ns))) continue;
    FL_ASSIGN(const bool level, line.input->read_level());
    line.strobe.read_level(level, now_ns);
    deliver_changes(receiver);
  }
  return {};
}

void GpioSource::deliver_changes(FrameReceiver& receiver) {
  bool changed = false;
  TimeNs stamp_ns = INT64_MIN;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    if (line.strobe.value() == line.sent) continue;
    changed = true;
    line.sent = line.strobe.value();
    levels_[static_cast<std::size_t>(slot_of_address(config_.address)) + i] = line.sent;
    stamp_ns = std::max(stamp_ns, line.strobe.changed_ns());
  }
  // No changes are delivered before the first whole frame.
  if (changed && repeat_ns_ != INT64_MIN) deliver(stamp_ns, kStartCodeLevels, receiver);
}

void GpioSource::deliver(TimeNs stamp_ns, std::uint8_t start_code, FrameReceiver& receiver) {
  FrameView frame;
  frame.universe = config_.universe;
  frame.stamp_ns = stamp_ns;
  frame.sender = std::hash<std::string>{}(config_.name) | 1u;
  frame.sequence = ++sequence_;
  frame.priority = config_.priority;
  frame.start_code = start_code;
  frame.silence_max_ns = kSilenceMaxNs;
  frame.slots = start_code == kStartCodePriorities ? priorities_ : levels_;
  ++frames_;
  receiver.receive(frame);
}

// --- Opening and losing lines ----------------------------------------------------------------------------------------

GpioSource::GpioSource(GpioConfig config, std::shared_ptr<GpioChips> chips, Clock& clock)
    : config_(std::move(config)), chips_(std::move(chips)), clock_(clock) {
  const auto first = static_cast<std::size_t>(slot_of_address(config_.address));
  for (std::size_t i = 0; i < config_.lines.size(); ++i) {
    lines_.emplace_back(config_.strobe);
    lines_.back().sent = levels_[first + i] = config_.strobe.off;
    priorities_[first + i] = config_.priority;
  }
}

GpioSource::~GpioSource() {
  lines_.clear();
  if (epoll_fd_ >= 0) ::close(epoll_fd_);
}

Result<std::unique_ptr<GpioSource>> GpioSource::open(GpioConfig config, std::shared_ptr<GpioChips> chips,
                                                     Clock& clock) {
  if (config.name.empty()) config.name = fmt::format("gpio:{}", config.chip);
  if (config.lines.empty() || static_cast<int>(config.lines.size()) > kSlotCountMax - slot_of_address(config.address))
    return fail(ErrorCode::kBadInput, "{}: {} lines from address {} on do not fit; a universe has {} addresses",
                config.name, config.lines.size(), config.address, kSlotCountMax);
  std::unique_ptr<GpioSource> source(new GpioSource(std::move(config), std::move(chips), clock));
  const std::string& name = source->config_.name;
  Status opened = source->make_epoll();
  if (opened) {
    opened = source->open_lines(clock.now_ns());
    const bool may_wait = source->config_.wait_for_device;
    if (!opened && may_wait && opened.error().code == ErrorCode::kNotFound) {
      source->trouble_ = opened.error().message;
      source->retry_ns_ = clock.now_ns() + kRetryNs;
      opened = {};
    }
  }
  if (!opened) return fail(opened.error().code, "{}: {}", name, opened.error().message);
  return source;
}

Status GpioSource::make_epoll() {
  epoll_fd_ = ::epoll_create1(EPOLL_CLOEXEC);
  if (epoll_fd_ < 0) return fail(ErrorCode::kIo, "epoll_create1: {}", std::strerror(errno));
  return {};
}

Status GpioSource::open_lines(TimeNs now_ns) {
  std::vector<std::unique_ptr<GpioLine>> inputs;
  std::vector<bool> levels;
  for (const std::string& line : config_.lines) {
    FL_ASSIGN(
        std::unique_ptr<GpioLine> input,
        chips_->request({.chip = config_.chip, .line = line, .active_low = config_.active_low, .bias = config_.bias}));
    FL_ASSIGN(const bool level, input->read_level());
    inputs.push_back(std::move(input));
    levels.push_back(level);
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    line.input = std::move(inputs[i]);
    line.ignored_until_ns = kTimeNever;
    line.storm_ns = now_ns;
    line.storm_edges = 0;
    line.strobe.start(levels[i], now_ns);
    if (const Status listening = listen(i, true); !listening) {
      for (Line& opened : lines_) opened.input.reset();
      return listening;
    }
  }
  trouble_.clear();
  retry_ns_ = kTimeNever;
  read_levels_ns_ = now_ns + kReadLevelsNs;
  return {};
}

void GpioSource::lose_lines(const Error& error, TimeNs now_ns, FrameReceiver& receiver) {
  ++errors_;
  trouble_ = error.message;
  retry_ns_ = now_ns + kRetryNs;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    (void)listen(i, false);
    lines_[i].input.reset();
    lines_[i].strobe.stop(now_ns);
  }
  deliver_changes(receiver);
}

Status GpioSource::listen(std::size_t index, bool on) {
  const int fd = lines_[index].input->fd();
  if (fd < 0) return {};
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = index;
  if (::epoll_ctl(epoll_fd_, on ? EPOLL_CTL_ADD : EPOLL_CTL_DEL, fd, &event) == 0 || !on) return {};
  return fail(ErrorCode::kIo, "line {}: cannot be waited for: {}", config_.lines[index], std::strerror(errno));
}

TimeNs GpioSource::next_deadline_ns() const {
  TimeNs next_ns = std::min(repeat_ns_, is_open() ? read_levels_ns_ : retry_ns_);
  for (const Line& line : lines_) {
    next_ns = std::min({next_ns, line.strobe.next_deadline_ns(), line.ignored_until_ns});
    if (line.input != nullptr) next_ns = std::min(next_ns, line.input->next_edge_ns());
  }
  return next_ns;
}

// --- Counters and notices --------------------------------------------------------------------------------------------

PortCounters GpioSource::counters() const {
  PortCounters counters{.frames = frames_, .errors = errors_};
  for (const Line& line : lines_) {
    counters.rejected += line.strobe.counters().lost + line.strobe.counters().repaired;
    counters.dropped += line.strobe.counters().capped;
  }
  return counters;
}

void GpioSource::report_capped(TimeNs now_ns) {
  if (now_ns < report_capped_ns_) return;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    const std::uint64_t capped = line.strobe.counters().capped;
    if (capped == line.reported_capped) continue;
    notices_.push_back(
        {NoticeLevel::kWarning, "flashes-held-back",
         fmt::format("line {}: {} {} held back; at most {:g} a second are allowed (flashes_hz_max)", config_.lines[i],
                     capped - line.reported_capped, capped - line.reported_capped == 1 ? "flash" : "flashes",
                     config_.strobe.flashes_hz_max)});
    line.reported_capped = capped;
    report_capped_ns_ = now_ns + kReportAgainNs;
  }
}

std::optional<PortNotice> GpioSource::take_notice() {
  if (notices_.empty()) return std::nullopt;
  PortNotice notice = std::move(notices_.front());
  notices_.erase(notices_.begin());
  return notice;
}

Result<std::unique_ptr<Source>> open_gpio_source(GpioConfig config, Clock& clock) {
  auto chips = config.chip == "mock" ? mock::make_mock_chips(clock) : make_gpio_chips();
  FL_ASSIGN(std::unique_ptr<GpioSource> source, GpioSource::open(std::move(config), std::move(chips), clock));
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace footlight::drivers
