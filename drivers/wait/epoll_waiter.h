// The waiter of a real machine: epoll for descriptors, a timerfd for the deadline, an eventfd for interrupt().
//
// The deadline is a time of CLOCK_MONOTONIC, as SystemClock gives it. A timerfd and not the time-out of epoll_wait(),
// because it takes an absolute time in nanoseconds and is not rounded up by the timer slack of the thread (50 us unless
// it is a real-time one).
//
// Cost: one system call per wait, two when the deadline is another than last time.
// Threads: one, except interrupt().
#pragma once

#include <memory>
#include <span>

#include "sim/wait.h"

namespace footlight::drivers {

class EpollWaiter final : public Waiter {
 public:
  // kIo: the system has no descriptor left.
  [[nodiscard]] static Result<std::unique_ptr<EpollWaiter>> make();
  ~EpollWaiter() override;
  EpollWaiter(const EpollWaiter&) = delete;
  EpollWaiter& operator=(const EpollWaiter&) = delete;

  // Errors: kUnsupported for what cannot be waited for (a plain file), kIo for the rest.
  Status watch(int fd) override;
  void unwatch(int fd) override;
  int wait_until(TimeNs deadline_ns, std::span<int> ready) override;
  void interrupt() noexcept override;

 private:
  EpollWaiter() = default;

  int epoll_fd_ = -1;
  int timer_fd_ = -1;
  int interrupt_fd_ = -1;
  TimeNs armed_ns_ = kTimeNever;  // what the timer is set to
};

}  // namespace footlight::drivers
