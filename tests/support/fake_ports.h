// Ports and a waiter without hardware, for tests of the pump.
//
//   FakeClock clock;
//   FakeWaiter waiter(clock);
//   FakeSource source(waiter, "desk", {1, 2});
//   waiter.at(clock.now_ns() + kNsPerMs, [&] { source.give(1, 255); });
//
// Time moves in wait_until() only: to the next scripted event or to the deadline, whichever comes first.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/core/check.h"
#include "sim/core/ports.h"
#include "sim/wait.h"
#include "tests/support/fake_clock.h"

namespace footlight::testing {

class FakeWaiter final : public Waiter {
 public:
  explicit FakeWaiter(FakeClock& clock) : clock_(clock) {}

  // A descriptor number that is readable while the function returns true.
  int make_fd(std::function<bool()> is_readable) {
    const int fd = next_fd_++;
    readable_[fd] = std::move(is_readable);
    return fd;
  }
  // An event at that time, in the middle of a wait.
  void at(TimeNs time_ns, std::function<void()> event) { events_.emplace(time_ns, std::move(event)); }

  Status watch(int fd) override {
    if (readable_.count(fd) == 0) return fail(ErrorCode::kIo, "descriptor {}: no such thing", fd);
    watched_.insert(fd);
    return {};
  }
  void unwatch(int fd) override { watched_.erase(fd); }
  void interrupt() noexcept override { interrupted_ = true; }

  int wait_until(TimeNs deadline_ns, std::span<int> ready) override {
    ++wait_count;
    last_deadline_ns = deadline_ns;
    for (;;) {
      std::size_t count = 0;
      for (const int fd : watched_)
        if (count < ready.size() && readable_.at(fd)()) ready[count++] = fd;
      if (count != 0 || interrupted_ || clock_.now_ns() >= deadline_ns) {
        interrupted_ = false;
        return static_cast<int>(count);
      }
      const TimeNs event_ns = events_.empty() ? kTimeNever : events_.begin()->first;
      FL_CHECK(std::min(event_ns, deadline_ns) != kTimeNever);  // this wait would never end
      if (event_ns <= deadline_ns) {
        clock_.sleep_until_ns(event_ns);
        const auto event = std::move(events_.begin()->second);
        events_.erase(events_.begin());
        event();
      } else {
        clock_.sleep_until_ns(deadline_ns + late_by_ns);
      }
    }
  }

  DurationNs late_by_ns = 0;  // how late a wait with a deadline ends
  std::uint64_t wait_count = 0;
  TimeNs last_deadline_ns = 0;
  [[nodiscard]] const std::set<int>& watched() const { return watched_; }

 private:
  FakeClock& clock_;
  int next_fd_ = 100;
  std::atomic<bool> interrupted_{false};  // any thread
  std::map<int, std::function<bool()>> readable_;
  std::multimap<TimeNs, std::function<void()>> events_;
  std::set<int> watched_;
};

// The scripted behaviour of both kinds of port.
struct FakePort {
  std::string port_name;
  std::vector<Universe> carried;
  int fd = -1;
  PortState port_state = PortState::kWorking;
  std::string port_trouble;
  TimeNs deadline_ns = kTimeNever;
  DurationNs repeat_ns = 0;     // > 0: every poll moves a passed deadline on by this much, as in a log or keep-alive
  bool deadline_stuck = false;  // a faulty port: polls do not move the deadline
  std::string poll_error;       // not empty: poll() fails with it
  std::uint64_t poll_count = 0;
  std::vector<TimeNs> polled_ns;  // up to 1000 times

  Status polled(TimeNs now_ns) {
    ++poll_count;
    if (polled_ns.size() < 1000) polled_ns.push_back(now_ns);
    while (deadline_ns <= now_ns && !deadline_stuck) deadline_ns = repeat_ns > 0 ? deadline_ns + repeat_ns : kTimeNever;
    if (!poll_error.empty()) return tl::unexpected<Error>(Error{ErrorCode::kDisconnected, poll_error});
    return {};
  }
};

class FakeSource final : public Source, public FakePort {
 public:
  FakeSource(FakeWaiter& waiter, std::string name, std::vector<Universe> universes) {
    port_name = std::move(name);
    carried = std::move(universes);
    fd = waiter.make_fd([this] { return !mailbox_.empty(); });
  }

  struct Letter {
    FrameView frame;
    std::vector<std::uint8_t> slots;
  };
  // A whole universe at one level. `stamp_ns` 0: the time of the poll.
  void give(Universe universe, std::uint8_t level, std::uint8_t priority = kPriorityDefault, TimeNs stamp_ns = 0) {
    Letter letter;
    letter.slots.assign(kSlotCountMax, level);
    letter.frame.universe = universe;
    letter.frame.priority = priority;
    letter.frame.sender = sender;
    letter.frame.stamp_ns = stamp_ns;
    letter.frame.sequence = ++sequence_;
    mailbox_.push_back(std::move(letter));
  }
  void end(Universe universe) {
    give(universe, 0);
    mailbox_.back().frame.terminated = true;
  }

  std::string name() const override { return port_name; }
  int poll_fd() const override { return fd; }
  TimeNs next_deadline_ns() const override { return deadline_ns; }
  PortState state() const override { return port_state; }
  std::string trouble() const override { return port_trouble; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return carried; }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
    if (Status status = polled(now_ns); !status) return status;
    if (before_poll) before_poll(now_ns);
    while (!mailbox_.empty()) {
      Letter& letter = mailbox_.front();
      if (letter.frame.stamp_ns == 0) letter.frame.stamp_ns = now_ns;
      letter.frame.slots = letter.slots;
      receiver.receive(letter.frame);
      mailbox_.pop_front();
    }
    return {};
  }

  std::string sender_text(SenderId) const override { return sender_name; }
  SenderLosses sender_losses(std::size_t place, SenderId) const override {
    return place < losses.size() ? losses[place] : SenderLosses{};
  }

  SenderId sender = 1;
  std::string sender_name;
  std::vector<SenderLosses> losses;         // per universe
  std::function<void(TimeNs)> before_poll;  // may give() frames that are due

 private:
  std::deque<Letter> mailbox_;
  std::uint32_t sequence_ = 0;
};

class FakeSink final : public Sink, public FakePort {
 public:
  FakeSink(FakeWaiter& waiter, std::string name, std::vector<Universe> universes, double rate_hz_max = 0.0)
      : rate_hz_max_(rate_hz_max) {
    port_name = std::move(name);
    carried = std::move(universes);
    fd = waiter.make_fd([this] { return readable; });
  }

  struct Sent {
    TimeNs time_ns = 0;
    std::vector<Universe> universes;  // in the order of the call
    std::vector<int> levels;          // of slot 0, in the same order
    friend bool operator==(const Sent&, const Sent&) = default;
  };

  std::string name() const override { return port_name; }
  int poll_fd() const override { return fd; }
  TimeNs next_deadline_ns() const override { return deadline_ns; }
  PortState state() const override { return port_state; }
  std::string trouble() const override { return port_trouble; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return carried; }
  double rate_hz_max() const override { return rate_hz_max_; }
  std::optional<std::uint64_t> frames_on_line() const override { return line_frames; }
  void take_figures(std::vector<PortFigure>& into) const override { into = figures; }
  void set_rate_hz_max(double rate_hz) { rate_hz_max_ = rate_hz; }  // as for a returning device of another model
  std::optional<std::uint64_t> line_frames;
  std::vector<PortFigure> figures;
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override {
    ++send_count;
    if (!send_error.empty()) return tl::unexpected<Error>(Error{ErrorCode::kIo, send_error});
    frame_count += frames.size();
    if (keep_history) {
      Sent& entry = sent.emplace_back();
      entry.time_ns = now_ns;
      for (const FrameView& frame : frames) {
        FL_CHECK_EQ(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
        entry.universes.push_back(frame.universe);
        entry.levels.push_back(frame.slots[0]);
      }
    }
    return {};
  }
  Status poll(TimeNs now_ns) override {
    readable = false;
    if (during_poll) during_poll(now_ns);
    return polled(now_ns);
  }
  void rest(TimeNs) override { ++rest_count; }
  void close(TimeNs) override { ++close_count; }

  std::string send_error;  // not empty: send() fails with it
  std::function<void(TimeNs)> during_poll;
  bool readable = false;
  bool keep_history = true;
  std::vector<Sent> sent;
  std::uint64_t send_count = 0;
  std::uint64_t frame_count = 0;
  int close_count = 0;
  int rest_count = 0;

 private:
  double rate_hz_max_;
};

}  // namespace footlight::testing
