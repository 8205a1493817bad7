// What an opener over a file of /dev and its transport share: how other threads end their waits.
#pragma once

#include <poll.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "drivers/fd.h"
#include "sim/core/clock.h"

namespace footlight::drivers {

// wake() and abort() may be called by any thread, all else by the device's.
class Wakeup {
 public:
  [[nodiscard]] bool usable() const { return static_cast<bool>(event_); }

  // Ends the current or the next wait.
  void wake() { interrupt(woken_); }
  // Ends this wait and all that follow.
  void abort() { interrupt(aborted_); }
  [[nodiscard]] bool aborted() const { return aborted_; }
  // True once after each wake().
  [[nodiscard]] bool take_wake() { return woken_.exchange(false); }

  // Readable after wake() and abort(), until clear(): for waits other than poll_until().
  [[nodiscard]] int fd() const { return event_.get(); }
  void clear() const { event_.clear(); }

  // Waits until `fd` (-1: none) has one of `events`, a call of wake() or abort(), or the deadline. Returns after a real
  // second at the latest, for clocks that are moved by hand. Returns errno, or 0; `got`: what poll() found at `fd`.
  int poll_until(int fd, short events, Clock& clock, TimeNs deadline_ns, short& got) const {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kNsPerS);
    const timespec left{.tv_sec = left_ns / kNsPerS, .tv_nsec = left_ns % kNsPerS};
    pollfd waited[] = {{.fd = fd, .events = events, .revents = 0},
                       {.fd = event_.get(), .events = POLLIN, .revents = 0}};
    const int count = ::ppoll(waited, 2, &left, nullptr);
    if ((waited[1].revents & POLLIN) != 0) event_.clear();
    got = waited[0].revents;
    return count < 0 && errno != EINTR ? errno : 0;
  }

 private:
  void interrupt(std::atomic<bool>& what) {
    what = true;
    event_.signal();
  }

  EventFd event_;
  std::atomic<bool> woken_{false};
  std::atomic<bool> aborted_{false};
};

}  // namespace footlight::drivers
