// Universes that arrive at the window's inputs and that no fixture and no display of the rig uses: for who looks for a
// console's universe. Knows no window.
//
// A pump passes all frames of its sources to it, and it keeps the newest levels of those universes, not merged.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "sim/core/ports.h"

namespace footlight::tools {

struct UnpatchedUniverse {
  Universe universe = 0;
  Slots levels{};      // of the newest frame, and of those before it where that was shorter
  std::string sender;  // of the newest frame
  int priority = 0;    // of it
  TimeNs stamp_ns = 0;
  std::uint64_t frames = 0;
};

class UnpatchedLevels final : public FrameReceiver {
 public:
  static constexpr std::size_t kUniversesMax = 64;  // then one that was silent for 10 s makes room
  static constexpr DurationNs kForgottenNs = 10 * kNsPerS;

  // patched: ascending. name_of: the sender of a frame, called on the pump's thread.
  UnpatchedLevels(std::span<const Universe> patched, std::function<std::string(const FrameView&)> name_of)
      : patched_(patched.begin(), patched.end()), name_of_(std::move(name_of)) {}

  // The pump's thread.
  void receive(const FrameView& frame) override;
  // Any thread. Ascending; copied only if something has arrived since the last call.
  void take(std::vector<UnpatchedUniverse>& into);

 private:
  const std::vector<Universe> patched_;
  const std::function<std::string(const FrameView&)> name_of_;
  std::mutex mutex_;
  std::vector<UnpatchedUniverse> universes_;  // guarded by mutex_, ascending
  bool fresh_ = false;                        // likewise: since the last take()
};

}  // namespace footlight::tools
