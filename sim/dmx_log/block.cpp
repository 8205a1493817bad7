#include "sim/dmx_log/block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "sim/core/check.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/format.h"

namespace footlight::dmx_log {
namespace {

// A tag is index * 8 + flags.
constexpr std::uint64_t kTagLevels = 1;    // a row of the universe's columns belongs to this frame
constexpr std::uint64_t kTagMeta = 2;      // slot count, priority, sender or terminated differ from the frame before
constexpr std::uint64_t kTagSequence = 4;  // the sequence differs from the predicted one

constexpr std::uint8_t kTableSeen = 1;
constexpr std::uint8_t kTableTerminated = 2;

// Two bits per slot.
constexpr unsigned kColumnNone = 0;
constexpr unsigned kColumnFirst = 1;   // each byte is the level less the one before
constexpr unsigned kColumnSecond = 2;  // each byte is that difference less the difference before
constexpr std::size_t kColumnModeBytes = kSlotCountMax / 4;

void put_meta(Bytes& out, const UniverseState& state) {
  put_varint(out, state.slot_count);
  put_u8(out, state.priority);
  put_u8(out, state.terminated ? 1 : 0);
  put_varint(out, state.sender);
}

// Estimated compressed size of a column of residuals: the sum of their magnitudes, plus one for each change, because
// zstd needs more bytes where no run continues.
std::size_t cost_of(std::span<const std::uint8_t> residuals) {
  std::size_t cost = 0;
  std::uint8_t before = 0;
  for (const std::uint8_t residual : residuals) {
    const int size = std::abs(static_cast<int>(static_cast<std::int8_t>(residual)));
    cost += static_cast<std::size_t>(std::min(size, 8)) + (residual != before ? 2u : 0u);
    before = residual;
  }
  return cost;
}

}  // namespace

int BlockEncoder::find(Universe universe) const {
  const auto found = indices_.find(universe);
  return found == indices_.end() ? -1 : static_cast<int>(found->second);
}

std::size_t BlockEncoder::index_of(Universe universe) {
  const auto [place, is_new] = indices_.try_emplace(universe, states_.size());
  if (is_new) {
    states_.emplace_back().universe = universe;
    rows_.emplace_back();
  }
  return place->second;
}

bool BlockEncoder::add(DurationNs time_ns, const FrameView& frame, bool keep_repeats) {
  const std::size_t index = index_of(frame.universe);
  UniverseState& state = states_[index];
  const bool first = frame_count_ == 0;
  FL_CHECK(first || time_ns >= last_ns_);

  const std::size_t count = frame.terminated ? 0 : frame.slots.size();
  const bool changed = count > 0 && std::memcmp(state.levels.data(), frame.slots.data(), count) != 0;
  const auto slot_count = frame.terminated ? state.slot_count : static_cast<std::uint16_t>(count);
  const bool meta = !state.seen || state.slot_count != slot_count || state.priority != frame.priority ||
                    state.sender != frame.sender || state.terminated != frame.terminated;
  if (!changed && !meta && !keep_repeats) return false;

  const std::uint32_t predicted = state.sequence + state.sequence_step;
  const bool sequence = frame.sequence != predicted;
  if (first) first_ns_ = last_ns_ = time_ns;
  put_varint(tags_, index * 8 + (changed ? kTagLevels : 0) + (meta ? kTagMeta : 0) + (sequence ? kTagSequence : 0));
  put_varint(times_, static_cast<std::uint64_t>(time_ns - last_ns_));

  state.seen = true;
  state.terminated = frame.terminated;
  state.priority = frame.priority;
  state.slot_count = slot_count;
  state.sender = frame.sender;
  state.sequence_step = frame.sequence - state.sequence;
  state.sequence = frame.sequence;
  state.time_ns = time_ns;
  if (meta) put_meta(metas_, state);
  if (sequence) put_varint(metas_, frame.sequence - predicted);
  if (changed) {
    std::memcpy(state.levels.data(), frame.slots.data(), count);
    rows_[index].insert(rows_[index].end(), state.levels.begin(), state.levels.end());
    row_bytes_ += kSlotCountMax;
  }
  last_ns_ = time_ns;
  ++frame_count_;
  return changed;
}

void BlockEncoder::encode(Bytes& out) {
  out.clear();
  put_varint(out, states_.size());
  for (std::size_t i = 0; i < states_.size(); ++i) {
    UniverseState fresh;
    fresh.universe = states_[i].universe;
    const UniverseState& base = i < base_.size() ? base_[i] : fresh;
    put_varint(out, static_cast<std::uint64_t>(base.universe));
    put_u8(out, static_cast<std::uint8_t>((base.seen ? kTableSeen : 0) | (base.terminated ? kTableTerminated : 0)));
    if (!base.seen) continue;
    put_varint(out, static_cast<std::uint64_t>(first_ns_ - base.time_ns));
    put_varint(out, base.slot_count);
    put_u8(out, base.priority);
    put_varint(out, base.sender);
    put_varint(out, base.sequence);
    out.insert(out.end(), base.levels.begin(), base.levels.end());
  }
  put_varint(out, tags_.size());
  put_varint(out, times_.size());
  put_varint(out, metas_.size());
  out.insert(out.end(), tags_.begin(), tags_.end());
  out.insert(out.end(), times_.begin(), times_.end());
  out.insert(out.end(), metas_.begin(), metas_.end());

  for (std::size_t i = 0; i < states_.size(); ++i) {
    Bytes& rows = rows_[i];
    const std::size_t row_count = rows.size() / kSlotCountMax;
    put_varint(out, row_count);
    if (row_count == 0) continue;
    const std::size_t modes_at = out.size();
    out.resize(out.size() + kColumnModeBytes, 0);
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      std::uint8_t level = i < base_.size() ? base_[i].levels[slot] : std::uint8_t{0};
      std::uint8_t delta_before = 0;
      std::uint8_t any = 0;
      column_.clear();
      second_.clear();
      for (std::size_t row = 0; row < row_count; ++row) {
        const std::uint8_t next = rows[row * kSlotCountMax + slot];
        const auto delta = static_cast<std::uint8_t>(next - level);
        column_.push_back(delta);
        second_.push_back(static_cast<std::uint8_t>(delta - delta_before));
        any |= delta;
        level = next;
        delta_before = delta;
      }
      if (any == 0) continue;
      const bool second = cost_of(second_) < cost_of(column_);
      const Bytes& residuals = second ? second_ : column_;
      out.insert(out.end(), residuals.begin(), residuals.end());
      out[modes_at + slot / 4] = static_cast<std::uint8_t>(out[modes_at + slot / 4] |
                                                           (second ? kColumnSecond : kColumnFirst) << (2 * (slot % 4)));
    }
    rows.clear();
  }

  tags_.clear();
  times_.clear();
  metas_.clear();
  row_bytes_ = 0;
  frame_count_ = 0;
  for (UniverseState& state : states_) state.sequence_step = 1;
  base_ = states_;
}

// ---- Decoding ------------------------------------------------------------------------------------------------------

void BlockDecoder::clear() {
  states_.clear();
  rows_.clear();
  frames_left_ = 0;
}

Status BlockDecoder::load(std::span<const std::uint8_t> raw, std::uint32_t frame_count, DurationNs first_ns,
                          DurationNs last_ns) {
  clear();
  Cursor cursor(raw);
  FL_TRY(read_table(cursor, first_ns));
  const std::uint64_t tags = cursor.varint();
  const std::uint64_t times = cursor.varint();
  const std::uint64_t metas = cursor.varint();
  if (!cursor.ok() || tags > cursor.left() || times > cursor.left() || metas > cursor.left()) {
    return fail(ErrorCode::kBadInput, "a stream is longer than the block");
  }
  tags_ = Cursor(cursor.take(tags));
  times_ = Cursor(cursor.take(times));
  metas_ = Cursor(cursor.take(metas));
  FL_TRY(read_columns(cursor, frame_count));
  if (cursor.left() != 0) return fail(ErrorCode::kBadInput, "{} bytes too many in the block", cursor.left());
  next_time_ns_ = first_ns;
  last_ns_ = last_ns;
  frames_left_ = frame_count;
  const Status status = frames_left_ > 0 ? read_next_time() : Status{};
  if (!status) clear();
  return status;
}

Status BlockDecoder::read_table(Cursor& cursor, DurationNs first_ns) {
  const std::uint64_t universe_count = cursor.varint();
  // A universe takes at least two bytes. So a wrong count cannot cause an allocation larger than the block justifies.
  if (!cursor.ok() || universe_count > kUniverseMax || universe_count > cursor.left() / 2) {
    return fail(ErrorCode::kBadInput, "the block names more universes than it can hold");
  }
  std::vector<bool> named(static_cast<std::size_t>(kUniverseMax) + 1, false);
  states_.reserve(universe_count);
  for (std::uint64_t i = 0; i < universe_count; ++i) {
    const std::uint64_t universe = cursor.varint();
    const std::uint8_t flags = cursor.u8();
    if (!cursor.ok() || universe < kUniverseMin || universe > kUniverseMax || named[universe]) {
      return fail(ErrorCode::kBadInput, "the block's table of universes is wrong at entry {}", i);
    }
    named[universe] = true;
    UniverseState& state = states_.emplace_back();
    state.universe = static_cast<Universe>(universe);
    if ((flags & kTableSeen) == 0) continue;
    state.seen = true;
    state.terminated = (flags & kTableTerminated) != 0;
    const std::uint64_t age_ns = cursor.varint();
    const std::uint64_t slot_count = cursor.varint();
    state.priority = cursor.u8();
    state.sender = cursor.varint();
    state.sequence = static_cast<std::uint32_t>(cursor.varint());
    const auto levels = cursor.take(kSlotCountMax);
    if (!cursor.ok() || slot_count > kSlotCountMax || age_ns > static_cast<std::uint64_t>(first_ns)) {
      return fail(ErrorCode::kBadInput, "the snapshot at the block's start is wrong at universe {}", universe);
    }
    state.slot_count = static_cast<std::uint16_t>(slot_count);
    state.time_ns = first_ns - static_cast<DurationNs>(age_ns);
    std::copy(levels.begin(), levels.end(), state.levels.begin());
  }
  return {};
}

Status BlockDecoder::read_columns(Cursor& cursor, std::uint32_t frame_count) {
  rows_.resize(states_.size());
  for (std::size_t i = 0; i < states_.size(); ++i) {
    Rows& rows = rows_[i];
    const std::uint64_t count = cursor.varint();
    if (!cursor.ok() || count > frame_count) {
      return fail(ErrorCode::kBadInput, "universe {} has more changes than frames", states_[i].universe);
    }
    rows.count = static_cast<std::uint32_t>(count);
    if (count == 0) continue;
    const auto modes = cursor.take(kColumnModeBytes);
    if (!cursor.ok()) return fail(ErrorCode::kBadInput, "the block ends inside universe {}", states_[i].universe);
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      const unsigned mode = (static_cast<unsigned>(modes[slot / 4]) >> (2 * (slot % 4))) & 3u;
      if (mode == kColumnNone) continue;
      if (mode != kColumnFirst && mode != kColumnSecond) {
        return fail(ErrorCode::kBadInput, "unknown coding of universe {}, slot {}", states_[i].universe, slot);
      }
      const auto residuals = cursor.take(count);
      if (!cursor.ok()) return fail(ErrorCode::kBadInput, "the block ends inside universe {}", states_[i].universe);
      rows.columns.push_back({static_cast<std::uint16_t>(slot), mode == kColumnSecond, 0, residuals});
    }
  }
  return {};
}

Status BlockDecoder::read_next_time() {
  const std::uint64_t step_ns = times_.varint();
  if (!times_.ok() || step_ns > static_cast<std::uint64_t>(last_ns_ - next_time_ns_)) {
    return fail(ErrorCode::kBadInput, "a frame is later than the block's end");
  }
  next_time_ns_ += static_cast<DurationNs>(step_ns);
  return {};
}

Result<BlockDecoder::Step> BlockDecoder::next(Slots& before) {
  FL_CHECK(frames_left_ > 0);
  const std::uint64_t tag = tags_.varint();
  if (!tags_.ok() || tag / 8 >= states_.size()) {
    return fail(ErrorCode::kBadInput, "a frame of a universe that the block does not name");
  }
  Step step;
  step.index = tag / 8;
  UniverseState& state = states_[step.index];
  if ((tag & kTagMeta) != 0) {
    const std::uint64_t slot_count = metas_.varint();
    state.priority = metas_.u8();
    state.terminated = metas_.u8() != 0;
    state.sender = metas_.varint();
    if (!metas_.ok() || slot_count > kSlotCountMax) return fail(ErrorCode::kBadInput, "a frame of more than 512 slots");
    state.slot_count = static_cast<std::uint16_t>(slot_count);
  }
  std::uint32_t sequence = state.sequence + state.sequence_step;
  if ((tag & kTagSequence) != 0) sequence += static_cast<std::uint32_t>(metas_.varint());
  if (!metas_.ok()) return fail(ErrorCode::kBadInput, "the block ends inside a frame");
  state.sequence_step = sequence - state.sequence;
  state.sequence = sequence;
  state.seen = true;
  state.time_ns = next_time_ns_;
  if ((tag & kTagLevels) != 0) {
    Rows& rows = rows_[step.index];
    if (rows.at == rows.count) {
      return fail(ErrorCode::kBadInput, "universe {} has fewer changes than its frames declare", state.universe);
    }
    before = state.levels;
    for (Column& column : rows.columns) {
      const std::uint8_t residual = column.residuals[rows.at];
      column.delta = column.second ? static_cast<std::uint8_t>(column.delta + residual) : residual;
      state.levels[column.slot] = static_cast<std::uint8_t>(state.levels[column.slot] + column.delta);
    }
    ++rows.at;
    step.changed = true;
  }
  --frames_left_;
  if (frames_left_ > 0) FL_TRY(read_next_time());
  return step;
}

}  // namespace footlight::dmx_log
