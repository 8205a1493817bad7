// Shared by tests of USB ports: snapshots, a receiver that keeps frames, and waits that sleep on descriptors. The waits
// have a limit, for tests that fail.
#pragma once

#include <poll.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <vector>

#include "sim/core/ports.h"

namespace footlight::testing {

using Snapshot = std::vector<std::uint8_t>;  // levels of 512 slots

// One of 256 snapshots that differ in every slot and have no period.
inline Snapshot some_snapshot(std::size_t which) {
  Snapshot slots(512);
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(which + i * 3 + i / 85);
  return slots;
}
// With the start code in front.
inline Snapshot line_frame_of(const Snapshot& slots) {
  Snapshot frame{0};
  frame.insert(frame.end(), slots.begin(), slots.end());
  return frame;
}

inline std::size_t entries_of(const char* folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

// Descriptors and threads of this process. The kernel lists a thread for a moment after it was joined, and an emulated
// device closes its end of a file on a thread of its own, so a count right after a close may be too high.
struct ProcessCounts {
  std::size_t fds = entries_of("/proc/self/fd"), threads = entries_of("/proc/self/task");
};
// Until no more are left than before, for at most 10 s. What leaks stays: repeat what may leak more often than once.
inline bool returns_to(const ProcessCounts& before) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (true) {
    const ProcessCounts now;
    if (now.fds <= before.fds && now.threads <= before.threads) return true;
    if (std::chrono::steady_clock::now() >= give_up) return false;
    ::poll(nullptr, 0, 1);
  }
}

// Keeps copies of the frames that a source delivers.
class FrameKeeper final : public FrameReceiver {
 public:
  struct Kept {
    FrameView view;  // its slots are invalid; see `slots`
    std::vector<std::uint8_t> slots;
  };
  void receive(const FrameView& frame) override { kept.push_back({frame, {frame.slots.begin(), frame.slots.end()}}); }
  std::vector<Kept> kept;
};

// Waits until `done()` is true, checking whenever the port's descriptor becomes readable; polls the port each time.
// False if it is not true within `patience` of real time.
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
