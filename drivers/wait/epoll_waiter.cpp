#include "drivers/wait/epoll_waiter.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kEventsPerWait = 64;

Status add(int epoll_fd, int fd) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  if (epoll_ctl(epoll_fd, EPOLL_CTL_ADD, fd, &event) == 0 || errno == EEXIST) return {};
  if (errno == EPERM)
    return fail(ErrorCode::kUnsupported, "descriptor {}: a plain file cannot be waited for; give the port a deadline",
                fd);
  return fail(ErrorCode::kIo, "descriptor {}: cannot be waited for: {}", fd, std::strerror(errno));
}

}  // namespace

Result<std::unique_ptr<EpollWaiter>> EpollWaiter::make() {
  std::unique_ptr<EpollWaiter> waiter(new EpollWaiter);
  waiter->epoll_fd_ = epoll_create1(EPOLL_CLOEXEC);
  waiter->timer_fd_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  waiter->interrupt_fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (waiter->epoll_fd_ < 0 || waiter->timer_fd_ < 0 || waiter->interrupt_fd_ < 0)
    return fail(ErrorCode::kIo, "cannot make a timer and an event queue: {}; see 'ulimit -n'", std::strerror(errno));
  FL_TRY(add(waiter->epoll_fd_, waiter->timer_fd_));
  FL_TRY(add(waiter->epoll_fd_, waiter->interrupt_fd_));
  return waiter;
}

EpollWaiter::~EpollWaiter() {
  for (const int fd : {interrupt_fd_, timer_fd_, epoll_fd_})
    if (fd >= 0) ::close(fd);
}

Status EpollWaiter::watch(int fd) { return add(epoll_fd_, fd); }

void EpollWaiter::unwatch(int fd) { epoll_ctl(epoll_fd_, EPOLL_CTL_DEL, fd, nullptr); }

int EpollWaiter::wait_until(TimeNs deadline_ns, std::span<int> ready) {
  // Setting the timer also clears its expiry, so it is never read. Tried: leaving it at an earlier time to save the
  // call when deadlines move later. Sinks that repeat within 25 ms then woke the pump twice per frame.
  if (deadline_ns != armed_ns_) {
    itimerspec when{};
    if (deadline_ns != kTimeNever) {
      const TimeNs at_ns = std::max<TimeNs>(deadline_ns, 1);  // 0 would switch the timer off
      when.it_value.tv_sec = static_cast<time_t>(at_ns / kNsPerS);
      when.it_value.tv_nsec = static_cast<long>(at_ns % kNsPerS);
    }
    FL_CHECK_EQ(timerfd_settime(timer_fd_, TFD_TIMER_ABSTIME, &when, nullptr), 0);
    armed_ns_ = deadline_ns;
  }

  std::array<epoll_event, kEventsPerWait> events;
  // Two more than the caller's room, for the timer and the interrupt.
  const std::size_t room = std::min(events.size(), ready.size() + 2);
  const int event_count = epoll_wait(epoll_fd_, events.data(), static_cast<int>(room), -1);
  if (event_count < 0) {
    FL_CHECK_EQ(errno, EINTR);  // a signal handler ran: the caller checks for a request
    return 0;
  }
  std::size_t ready_count = 0;
  for (int i = 0; i < event_count; ++i) {
    const int fd = events[static_cast<std::size_t>(i)].data.fd;
    if (fd == timer_fd_) continue;
    if (fd == interrupt_fd_) {
      std::uint64_t calls = 0;
      [[maybe_unused]] const ssize_t got = ::read(interrupt_fd_, &calls, sizeof calls);
      continue;
    }
    if (ready_count < ready.size()) ready[ready_count++] = fd;  // level-triggered: the rest comes again
  }
  return static_cast<int>(ready_count);
}

void EpollWaiter::interrupt() noexcept {
  const int saved_errno = errno;  // a signal handler must not change it
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(interrupt_fd_, &one, sizeof one);
  errno = saved_errno;
}

}  // namespace footlight::drivers
