// What the pump sleeps on: descriptors that become readable, a deadline, and a call from elsewhere.
//
// The one for real descriptors is drivers/wait/epoll_waiter.h; tests have a scripted one.
#pragma once

#include <span>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight {

class Waiter {
 public:
  virtual ~Waiter() = default;
  // Has wait_until() report this descriptor while it is readable, closed by the other side or in error. Calling it
  // again is harmless, and needed where a descriptor was closed and its number given out anew.
  virtual Status watch(int fd) = 0;
  // Harmless for a descriptor that is not watched or already closed.
  virtual void unwatch(int fd) = 0;
  // Sleeps until something watched is readable, the absolute deadline has passed (at once where it lies in the past;
  // kTimeNever: no deadline) or interrupt() is called. Writes the readable descriptors to `ready`, as many as fit, and
  // returns how many; those that did not fit come with the next call. May return early with none.
  virtual int wait_until(TimeNs deadline_ns, std::span<int> ready) = 0;
  // Ends the wait under way or, where there is none, the next one. Any thread, and signal handlers.
  virtual void interrupt() noexcept = 0;
};

}  // namespace footlight
