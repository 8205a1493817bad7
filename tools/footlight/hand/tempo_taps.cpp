#include "tools/footlight/hand/tempo_taps.h"

#include <algorithm>

namespace footlight::tools {

void TempoTaps::Taps::receive(const FrameView& frame) {
  if (frame.start_code != kStartCodeLevels) return;
  if (frame.terminated) {
    known_ = false;
    return;
  }
  for (std::size_t slot = 0; slot < std::min(frame.slots.size(), last_.size()); ++slot) {
    if (known_ && frame.slots[slot] != 0 && last_[slot] == 0) tempo_->tap(frame.stamp_ns);
    last_[slot] = frame.slots[slot];
  }
  known_ = true;
}

}  // namespace footlight::tools
