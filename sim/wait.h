// What the pump sleeps on: readable descriptors, a deadline, and a call from another thread.
//
// The implementation for real descriptors is drivers/wait/epoll_waiter.h; tests have a scripted one.
#pragma once

#include <span>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight {

class Waiter {
 public:
  virtual ~Waiter() = default;
  // Makes wait_until() report this descriptor while it is readable, closed by the other side or in error. A repeated
  // call is harmless. It is needed if a descriptor was closed and its number reused.
  virtual Status watch(int fd) = 0;
  // Harmless if the descriptor is not watched or already closed.
  virtual void unwatch(int fd) = 0;
  // Sleeps until a watched descriptor is readable, the absolute deadline has passed or interrupt() is called. Returns
  // at once if the deadline is in the past; kTimeNever: no deadline. Writes as many readable descriptors to `ready` as
  // fit and returns their number; the others come with the next call. May return early with none.
  virtual int wait_until(TimeNs deadline_ns, std::span<int> ready) = 0;
  // Ends the current or next wait. Any thread, and signal handlers.
  virtual void interrupt() noexcept = 0;
};

}  // namespace footlight
