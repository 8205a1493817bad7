// The waiter of a real machine: epoll for descriptors, a timerfd for the deadline, an eventfd for interrupt().
//
// The deadline is a time of CLOCK_MONOTONIC, as in SystemClock. A timerfd is used instead of the timeout of
// epoll_wait(), because it takes an absolute time in nanoseconds. It is not rounded up by the timer slack of the thread
// (50 us except for real-time threads).
//
// Cost: one system call per wait, two if the deadline has changed.
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

  // Errors: kUnsupported for a descriptor that cannot be waited for (a plain file), kIo for other errors.
  Status watch(int fd) override;
  void unwatch(int fd) override;
  int wait_until(TimeNs deadline_ns, std::span<int> ready) override;
  void interrupt() noexcept override;

 private:
  EpollWaiter() = default;

  int epoll_fd_ = -1;
  int timer_fd_ = -1;
  int interrupt_fd_ = -1;
  TimeNs armed_ns_ = kTimeNever;  // the current setting of the timer
};

}  // namespace footlight::drivers
