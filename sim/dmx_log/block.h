// The content of a block before compression: the state of every universe at its start, then one tag and one time per
// frame, then the levels that changed, as one column per slot over the frames of the block. Layout and reasons:
// docs/formats/dmxlog.md. Bytes only, no I/O.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/dmx_log/bytes.h"

namespace footlight::dmx_log {

// The state of a universe. Frames in the log are stored as changes against it.
struct UniverseState {
  Universe universe = 0;
  bool seen = false;  // false: no frame yet, the other fields are unset
  bool terminated = false;
  std::uint8_t priority = kPriorityDefault;
  std::uint16_t slot_count = 0;
  SenderId sender = 0;
  std::uint32_t sequence = 0;
  std::uint32_t sequence_step = 1;  // the next sequence is predicted as sequence + step; 1 at the start of each block
  DurationNs time_ns = 0;           // of its newest frame
  Slots levels{};
};

// Encodes the frames of one block after another. The states carry over between blocks.
class BlockEncoder {
 public:
  // time_ns must not be before that of the last frame. Returns whether the frame changed a level.
  bool add(DurationNs time_ns, const FrameView& frame, bool keep_repeats);

  [[nodiscard]] bool empty() const { return frame_count_ == 0; }
  [[nodiscard]] std::uint32_t frame_count() const { return frame_count_; }
  [[nodiscard]] DurationNs first_ns() const { return first_ns_; }
  [[nodiscard]] DurationNs last_ns() const { return last_ns_; }
  // Upper bounds of the size from encode(): of this block, and of the part that does not depend on its frames.
  [[nodiscard]] std::size_t raw_bytes_bound() const {
    return base_bytes_bound() + row_bytes_ + std::size_t{64} * frame_count_;
  }
  [[nodiscard]] std::size_t base_bytes_bound() const { return 16 + states_.size() * (kSlotCountMax + 176); }
  [[nodiscard]] const std::vector<UniverseState>& states() const { return states_; }
  // Index of a universe in states(), or -1.
  [[nodiscard]] int find(Universe universe) const;

  // Writes the block into `out` (cleared first) and starts the next.
  void encode(Bytes& out);

 private:
  std::size_t index_of(Universe universe);

  std::vector<UniverseState> states_;  // in order of first appearance
  std::vector<UniverseState> base_;    // the states at the start of the block; shorter if universes were new
  std::unordered_map<Universe, std::size_t> indices_;
  std::vector<Bytes> rows_;  // per universe: 512 levels for each frame that changed one
  std::size_t row_bytes_ = 0;
  Bytes tags_, times_, metas_, column_, second_;
  std::uint32_t frame_count_ = 0;
  DurationNs first_ns_ = 0;
  DurationNs last_ns_ = 0;
};

// Decodes one block. Refers to the bytes given to load(), which must outlive it.
class BlockDecoder {
 public:
  // Fails with kBadInput and a description if the block is inconsistent.
  Status load(std::span<const std::uint8_t> raw, std::uint32_t frame_count, DurationNs first_ns, DurationNs last_ns);
  void clear();
  // Drops the remaining frames, keeps the states.
  void clear_frames() { frames_left_ = 0; }

  [[nodiscard]] bool has_next() const { return frames_left_ > 0; }
  [[nodiscard]] DurationNs next_time_ns() const { return next_time_ns_; }
  struct Step {
    std::size_t index = 0;  // into states()
    bool changed = false;   // levels
  };
  // Applies the next frame to its universe's state. Copies the replaced levels to `before` if a level changes.
  Result<Step> next(Slots& before);
  // The states after the frames so far, in the order of the block's table.
  [[nodiscard]] const std::vector<UniverseState>& states() const { return states_; }

 private:
  struct Column {
    std::uint16_t slot = 0;
    bool second = false;  // differences of differences
    std::uint8_t delta = 0;
    std::span<const std::uint8_t> residuals;
  };
  struct Rows {
    std::uint32_t count = 0;
    std::uint32_t at = 0;
    std::vector<Column> columns;
  };
  Status read_table(Cursor& cursor, DurationNs first_ns);
  Status read_columns(Cursor& cursor, std::uint32_t frame_count);
  Status read_next_time();

  std::vector<UniverseState> states_;
  std::vector<Rows> rows_;
  Cursor tags_{{}}, times_{{}}, metas_{{}};
  std::uint32_t frames_left_ = 0;
  DurationNs next_time_ns_ = 0;
  DurationNs last_ns_ = 0;
};

}  // namespace footlight::dmx_log
