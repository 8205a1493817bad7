// The waiter of a pump over real sockets in tests.
#pragma once

#include <algorithm>
#include <vector>

#include <poll.h>

#include "sim/pump.h"
#include "tests/support/fake_clock.h"

namespace footlight::testing {

// Real descriptors, simulated time: if nothing is readable, the clock jumps to the deadline, but not past `limit`.
class JumpingWaiter final : public Waiter {
 public:
  explicit JumpingWaiter(FakeClock& clock) : clock_(clock) {}
  Status watch(int fd) override {
    unwatch(fd);
    waiting_.push_back({fd, POLLIN, 0});
    return {};
  }
  void unwatch(int fd) override {
    std::erase_if(waiting_, [fd](const pollfd& one) { return one.fd == fd; });
  }
  int wait_until(TimeNs deadline_ns, std::span<int> ready) override {
    std::size_t count = 0;
    if (::poll(waiting_.data(), waiting_.size(), 0) > 0) {
      for (const pollfd& one : waiting_) {
        if (one.revents != 0 && count < ready.size()) ready[count++] = one.fd;
      }
    }
    if (count == 0) clock_.sleep_until_ns(std::min(deadline_ns, limit_ns));
    return static_cast<int>(count);
  }
  void interrupt() noexcept override {}
  TimeNs limit_ns = 0;

 private:
  FakeClock& clock_;
  std::vector<pollfd> waiting_;
};

}  // namespace footlight::testing
