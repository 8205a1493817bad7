// What tests of USB ports share: a receiver that keeps frames, and waits that are bounded and sleep on descriptors.
#pragma once

#include <poll.h>

#include <chrono>
#include <vector>

#include "sim/core/ports.h"

namespace footlight::testing {

// Keeps copies of the frames that a source hands over.
class FrameKeeper final : public FrameReceiver {
 public:
  struct Kept {
    FrameView view;  // its slots are stale; see `slots`
    std::vector<std::uint8_t> slots;
  };
  void receive(const FrameView& frame) override { kept.push_back({frame, {frame.slots.begin(), frame.slots.end()}}); }
  std::vector<Kept> kept;
};

// Waits until `done()` is true, looking again whenever the port's descriptor becomes readable; polls the port each
// time. False where it is not true within `patience` of real time.
template <class PollPort, class Done>
bool poll_until(const Port& port, PollPort&& poll_port, Done&& done,
                std::chrono::milliseconds patience = std::chrono::seconds(10)) {
  const auto give_up = std::chrono::steady_clock::now() + patience;
  while (true) {
    poll_port();
    if (done()) return true;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(give_up - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd waited{.fd = port.poll_fd(), .events = POLLIN, .revents = 0};
    ::poll(&waited, 1, static_cast<int>(left.count()));
  }
}

inline bool wait_for_state(Sink& sink, PortState state) {
  return poll_until(
      sink, [&] { (void)sink.poll(0); }, [&] { return sink.state() == state; });
}

}  // namespace footlight::testing
