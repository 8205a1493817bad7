#include "sim/hand.h"

#include <algorithm>
#include <utility>

#include "sim/core/check.h"
#include "sim/merge.h"

namespace footlight {
namespace {

constexpr SenderId kHandSender = 1;
constexpr SenderId kBlackoutSender = 2;
// Commands come when they come, so silence means nothing. A year is longer than any run.
constexpr DurationNs kHandSilenceNs = 365LL * 24 * 3'600 * kNsPerS;
constexpr std::uint8_t kLookPriority = 1;  // claims a slot, below all other senders

std::uint32_t read_value(const Slots& levels, const HandLevel& at) {
  std::uint32_t value = 0;
  for (int i = 0; i < at.count; ++i) value = value << 8 | levels[at.slots[static_cast<std::size_t>(i)]];
  return value;
}

// True if a level changed.
bool write_value(Slots& levels, const HandLevel& at, std::uint32_t value) {
  bool changed = false;
  for (int i = 0; i < at.count; ++i) {
    const auto byte = static_cast<std::uint8_t>(value >> (8 * (at.count - 1 - i)));
    std::uint8_t& level = levels[at.slots[static_cast<std::size_t>(i)]];
    changed = changed || level != byte;
    level = byte;
  }
  return changed;
}

std::string universe_list(std::span<const Universe> universes) {
  constexpr std::size_t kNamed = 12;
  std::string list;
  for (std::size_t i = 0; i < universes.size() && i < kNamed; ++i) {
    list += fmt::format("{}{}", i == 0 ? "" : ", ", universes[i]);
  }
  return universes.size() > kNamed ? list + ", ..." : list;
}

}  // namespace

std::uint32_t faded_value(std::uint32_t from, std::uint32_t to, DurationNs elapsed_ns, DurationNs over_ns) {
  FL_CHECK(over_ns > 0 && elapsed_ns >= 0 && elapsed_ns <= over_ns);
  __extension__ using Wide = __int128;
  const Wide twice = Wide{2} * (Wide{from} * (over_ns - elapsed_ns) + Wide{to} * elapsed_ns) + over_ns;
  return static_cast<std::uint32_t>(twice / (Wide{2} * over_ns));
}

HandSource::HandSource(std::shared_ptr<const Universes> buffer) : buffer_(std::move(buffer)) { fades_.reserve(64); }

// --- Commands --------------------------------------------------------------------------------------------------------

Status HandSource::check(const HandCommand& command) const {
  if (command.action == HandAction::kSet) {
    if (command.priority < 1 || command.priority > kPriorityMax) {
      return fail(ErrorCode::kBadInput, "expected a priority from 1 to {}, got {}", kPriorityMax, command.priority);
    }
    if (command.over_ns < 0 || command.over_ns > kHandFadeMaxNs) {
      return fail(ErrorCode::kBadInput, "expected a fade of at most 24 hours");
    }
  }
  const bool holds = command.action == HandAction::kHold || command.action == HandAction::kRenew;
  if (holds && (command.over_ns < kHandHoldMinNs || command.over_ns > kHandHoldMaxNs)) {
    return fail(ErrorCode::kBadInput, "expected a hold of 200ms to 1h");
  }
  if (command.action == HandAction::kHold && holding()) {
    return fail(ErrorCode::kBadInput,
                "another 'footlight blackout hold' has the hold of this bridge; stop that command, or end its hold "
                "with 'footlight blackout off'");
  }
  if (command.action == HandAction::kRenew && !holding()) {
    return fail(ErrorCode::kNotFound, "there is no hold; 'footlight blackout off' ended it, or it ran out");
  }
  const bool needs_levels = command.action == HandAction::kSet || command.action == HandAction::kRelease;
  if (needs_levels && command.levels.empty()) return fail(ErrorCode::kBadInput, "the command names no slot");
  const HandLevel* foreign = nullptr;
  std::size_t foreign_count = 0;
  for (const HandLevel& level : command.levels) {
    if (level.count < 1 || level.count > kHandSlotsMax) {
      return fail(ErrorCode::kBadInput, "expected a number in 1 to {} slots", kHandSlotsMax);
    }
    for (int i = 0; i < level.count; ++i) {
      const std::uint16_t slot = level.slots[static_cast<std::size_t>(i)];
      if (slot >= kSlotCountMax) return fail(ErrorCode::kBadInput, "expected an address from 1 to {}", kSlotCountMax);
    }
    if (level.value > hand_value_max(level.count)) {
      return fail(ErrorCode::kBadInput, "{} does not fit into {} slots", level.value, level.count);
    }
    if (has(level.universe)) continue;
    foreign = &level;
    ++foreign_count;
  }
  // A rig may be larger than the bridge: what is there goes dark, or is released.
  const bool may_skip = command.action == HandAction::kBlackout || command.action == HandAction::kRelease;
  if (foreign == nullptr || (may_skip && foreign_count < command.levels.size())) return {};
  return fail(ErrorCode::kNotFound,
              "universe {} is not part of this bridge, which has {}; name one of these, or start the bridge with an "
              "endpoint for it (a window has the universes of its rig)",
              foreign->universe, universe_list(buffer_->numbers()));
}

Result<int> HandSource::apply(const HandCommand& command, TimeNs now_ns) {
  FL_TRY(check(command));
  advance(now_ns);
  switch (command.action) {
    case HandAction::kSet: set(command, now_ns); break;
    case HandAction::kRelease: release(command); break;
    case HandAction::kReleaseAll:
      for (const auto& board : boards_)
        for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) release_slot(*board, slot);
      break;
    case HandAction::kBlackout:
      if (!blacked_out()) notices_.push_back({NoticeLevel::kWarning, "blackout-on", "blackout is on"});
      begin_blackout(command.levels);
      break;
    case HandAction::kLift: lift(); break;
    case HandAction::kHold:
      hold_until_ns_ = now_ns + command.over_ns;
      notices_.push_back({NoticeLevel::kInfo, "hold-begins", "a hold begins: when it ends, blackout is on"});
      break;
    case HandAction::kRenew: hold_until_ns_ = now_ns + command.over_ns; break;
    case HandAction::kTempo: return 0;
  }
  dirty_ = true;
  int slots = 0;
  for (const HandLevel& level : command.levels) slots += has(level.universe) ? level.count : 0;
  return slots;
}

HandSource::Board& HandSource::board_of(Universe universe) {
  const auto at = std::lower_bound(boards_.begin(), boards_.end(), universe,
                                   [](const auto& board, Universe number) { return board->universe < number; });
  if (at != boards_.end() && (*at)->universe == universe) return **at;
  auto board = std::make_unique<Board>();
  board->universe = universe;
  return **boards_.insert(at, std::move(board));
}

// The levels of all senders, as they are without a blackout.
Slots HandSource::merged(const Board& board) const {
  Slots levels;
  FrameStamp stamp;
  buffer_->snapshot(buffer_->index_of(board.universe), levels, stamp);
  for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
    if (board.black.priorities[slot] != 0) levels[slot] = board.look[slot];
  }
  return levels;
}

void HandSource::set(const HandCommand& command, TimeNs now_ns) {
  Board* board = nullptr;
  Slots before = {};
  for (const HandLevel& level : command.levels) {
    if (board == nullptr || board->universe != level.universe) {
      board = &board_of(level.universe);
      before = merged(*board);
    }
    Layer& layer = board->hand;
    for (int i = 0; i < level.count; ++i) {
      const std::size_t slot = level.slots[static_cast<std::size_t>(i)];
      if (layer.priorities[slot] == 0) layer.levels[slot] = before[slot];
      layer.priorities_changed = layer.priorities_changed || layer.priorities[slot] != command.priority;
      layer.priorities[slot] = command.priority;
      board->leaving.reset(slot);
      board->fade[slot] = 0;
    }
    const std::uint32_t from = read_value(layer.levels, level);
    layer.levels_changed = true;
    if (command.over_ns == 0 || level.jumps || from == level.value) {
      write_value(layer.levels, level, level.value);
      continue;
    }
    if (fades_.empty()) grid_start_ns_ = now_ns;
    if (++last_fade_ == 0) ++last_fade_;
    for (int i = 0; i < level.count; ++i) board->fade[level.slots[static_cast<std::size_t>(i)]] = last_fade_;
    fades_.push_back({last_fade_, board, level, from, now_ns, command.over_ns});
  }
}

void HandSource::release(const HandCommand& command) {
  for (const HandLevel& level : command.levels) {
    if (!has(level.universe)) continue;
    Board& board = board_of(level.universe);
    for (int i = 0; i < level.count; ++i) release_slot(board, level.slots[static_cast<std::size_t>(i)]);
  }
}

void HandSource::release_slot(Board& board, std::size_t slot) {
  board.fade[slot] = 0;
  Layer& layer = board.hand;
  if (layer.priorities[slot] == 0) return;
  // The level that it keeps without another sender, also at the end of a blackout.
  if (board.black.priorities[slot] == kPriorityOverride) board.look[slot] = layer.levels[slot];
  if (layer.levels_changed) {
    board.leaving.set(slot);  // that level has not been sent yet
    return;
  }
  layer.priorities[slot] = 0;
  layer.priorities_changed = true;
}

// Gives up the slots that were released before their levels were sent, once these were.
void HandSource::let_leave() {
  leave_ns_ = kTimeNever;
  for (const auto& board : boards_) {
    for (std::size_t slot = 0; slot < kSlotCountMax && board->leaving.any(); ++slot) {
      if (!board->leaving.test(slot)) continue;
      board->leaving.reset(slot);
      board->hand.priorities[slot] = 0;
      board->hand.priorities_changed = dirty_ = true;
    }
  }
}

// --- Blackout --------------------------------------------------------------------------------------------------------

void HandSource::black_out(Board& board, const Slots& look, std::size_t slot, std::uint8_t level) {
  std::uint8_t& priority = board.black.priorities[slot];
  if (priority == kPriorityOverride) return;
  if (priority == 0) board.look[slot] = look[slot];  // else a blackout that is about to end has it
  priority = kPriorityOverride;
  board.black.levels[slot] = level;
  board.black.priorities_changed = board.black.levels_changed = true;
  ++black_slots_;
}

void HandSource::black_out_everything() {
  for (const Universe universe : buffer_->numbers()) {
    Board& board = board_of(universe);
    const Slots look = merged(board);
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) black_out(board, look, slot, 0);
  }
}

void HandSource::begin_blackout(std::span<const HandLevel> only) {
  dirty_ = true;
  if (only.empty()) {
    black_all_ = true;
    black_out_everything();
    return;
  }
  Board* board = nullptr;
  Slots look = {};
  for (const HandLevel& level : only) {
    if (!has(level.universe)) continue;
    if (board == nullptr || board->universe != level.universe) {
      board = &board_of(level.universe);
      look = merged(*board);
    }
    Slots dark = {};
    write_value(dark, level, level.value);
    for (int i = 0; i < level.count; ++i) {
      const std::size_t slot = level.slots[static_cast<std::size_t>(i)];
      black_out(*board, look, slot, dark[slot]);
    }
  }
}

void HandSource::lift() {
  if (holding()) notices_.push_back({NoticeLevel::kInfo, "hold-ends", "the hold is over"});
  hold_until_ns_ = kTimeNever;
  if (!blacked_out()) return;
  notices_.push_back({NoticeLevel::kWarning, "blackout-off", "blackout is off"});
  black_all_ = false;
  black_slots_ = 0;
  for (const auto& board : boards_) {
    board->hand.levels_changed = true;  // so that the newest frame of these slots is one of now
    Layer& black = board->black;
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      if (black.priorities[slot] == 0) continue;
      black.priorities[slot] = kLookPriority;
      black.levels[slot] = board->look[slot];
      black.priorities_changed = black.levels_changed = true;
    }
  }
}

void HandSource::move_to(std::shared_ptr<const Universes> buffer) {
  buffer_ = std::move(buffer);
  const auto gone = [this](const Board& board) { return buffer_->index_of(board.universe) < 0; };
  std::erase_if(fades_, [&](const Fade& fade) { return gone(*fade.board); });
  std::erase_if(boards_, [&](const auto& board) { return gone(*board); });
  black_slots_ = 0;
  for (const auto& board : boards_) {
    for (const std::uint8_t priority : board->black.priorities) black_slots_ += priority == kPriorityOverride ? 1 : 0;
  }
  if (black_all_) black_out_everything();
  for (const auto& board : boards_) board->hand.sending = board->black.sending = false;
  dirty_ = true;
}

// --- Time ------------------------------------------------------------------------------------------------------------

// Writes the levels of all fades at this time, removes those that have ended or were replaced, and finds the next poll.
void HandSource::advance(TimeNs now_ns) {
  fade_due_ns_ = kTimeNever;
  for (std::size_t i = 0; i < fades_.size();) {
    Fade& fade = fades_[i];
    bool alive = true;
    for (int k = 0; k < fade.to.count; ++k) {
      alive = alive && fade.board->fade[fade.to.slots[static_cast<std::size_t>(k)]] == fade.number;
    }
    if (alive) {
      const DurationNs elapsed_ns = std::clamp<DurationNs>(now_ns - fade.start_ns, 0, fade.over_ns);
      const std::uint32_t value = faded_value(fade.from, fade.to.value, elapsed_ns, fade.over_ns);
      if (write_value(fade.board->hand.levels, fade.to, value)) fade.board->hand.levels_changed = dirty_ = true;
      alive = elapsed_ns < fade.over_ns;
    }
    if (alive) {
      fade_due_ns_ = std::min(fade_due_ns_, fade.start_ns + fade.over_ns);
      ++i;
    } else {
      fade = fades_.back();
      fades_.pop_back();
    }
  }
  if (fades_.empty()) return;
  const std::int64_t tick = (now_ns - grid_start_ns_) * kHandFadeRateHz / kNsPerS + 1;
  const TimeNs grid_ns = grid_start_ns_ + (tick * kNsPerS + kHandFadeRateHz - 1) / kHandFadeRateHz;
  fade_due_ns_ = std::min(fade_due_ns_, grid_ns);
}

TimeNs HandSource::next_deadline_ns() const {
  return dirty_ ? INT64_MIN : std::min({fade_due_ns_, hold_until_ns_, leave_ns_});
}

Status HandSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  if (now_ns >= hold_until_ns_) {
    hold_until_ns_ = kTimeNever;
    notices_.push_back({NoticeLevel::kWarning, "blackout-on",
                        "the hold was not renewed: blackout is on; 'footlight blackout off' ends it"});
    begin_blackout({});
  }
  advance(now_ns);
  if (now_ns >= leave_ns_) let_leave();
  if (!dirty_) return {};
  dirty_ = false;
  for (const auto& board : boards_) {
    deliver(board->hand, board->universe, kHandSender, now_ns, receiver);
    deliver(board->black, board->universe, kBlackoutSender, now_ns, receiver);
    give_up_looks(*board, now_ns, receiver);
    if (board->leaving.any()) leave_ns_ = now_ns + 1;  // in the next tick: this one shows the levels
  }
  if (shown_ != nullptr) shown_->publish(slots());
  return {};
}

// --- Frames ----------------------------------------------------------------------------------------------------------

// After the levels from before the blackout were delivered: gives their slots up, so that they stay only where no other
// sender has the slot. The merge resolves those levels before it takes this sender's next frame.
void HandSource::give_up_looks(Board& board, TimeNs now_ns, FrameReceiver& receiver) {
  Layer& black = board.black;
  bool any = false;
  for (std::uint8_t& priority : black.priorities) {
    if (priority != kLookPriority) continue;
    priority = 0;
    any = true;
  }
  if (!any) return;
  const bool claims =
      std::any_of(black.priorities.begin(), black.priorities.end(), [](std::uint8_t each) { return each != 0; });
  if (claims) send(black, board.universe, kBlackoutSender, now_ns, kStartCodeLevels, receiver);
  black.priorities_changed = true;
  deliver(black, board.universe, kBlackoutSender, now_ns, receiver);
}

void HandSource::deliver(Layer& layer, Universe universe, SenderId sender, TimeNs now_ns, FrameReceiver& receiver) {
  const bool claims =
      std::any_of(layer.priorities.begin(), layer.priorities.end(), [](std::uint8_t each) { return each != 0; });
  if (!claims && !layer.sending) {
    layer.levels_changed = layer.priorities_changed = false;
    return;
  }
  if (!claims) {
    FrameView end;
    end.universe = universe;
    end.stamp_ns = now_ns;
    end.sender = sender;
    end.sequence = ++sequence_;
    end.terminated = true;
    ++counters_.frames;
    receiver.receive(end);
  } else if (layer.priorities_changed || layer.levels_changed || !layer.sending) {
    // Priorities first: levels of the other slots must not be used. Each time both, since the merge may have displaced
    // this sender, which is not reported: without priorities it would claim every slot.
    send(layer, universe, sender, now_ns, kStartCodePriorities, receiver);
    send(layer, universe, sender, now_ns, kStartCodeLevels, receiver);
  }
  layer.sending = claims;
  layer.levels_changed = layer.priorities_changed = false;
}

void HandSource::send(const Layer& layer, Universe universe, SenderId sender, TimeNs now_ns, std::uint8_t start_code,
                      FrameReceiver& receiver) {
  FrameView frame;
  frame.universe = universe;
  frame.stamp_ns = now_ns;
  frame.sender = sender;
  frame.sequence = ++sequence_;
  frame.priority = *std::max_element(layer.priorities.begin(), layer.priorities.end());
  frame.start_code = start_code;
  frame.silence_max_ns = kHandSilenceNs;
  frame.slots = start_code == kStartCodePriorities ? layer.priorities : layer.levels;
  ++counters_.frames;
  receiver.receive(frame);
}

// --- Learning --------------------------------------------------------------------------------------------------------

void HandLearner::begin() {
  const std::lock_guard lock(mutex_);
  moved_.reset();
  waits_.store(true);
}

bool HandLearner::take(std::string_view port, std::string input) {
  const std::lock_guard lock(mutex_);
  if (!waits_.exchange(false)) return false;
  moved_ = Moved{std::string(port), std::move(input)};
  return true;
}

void HandLearner::end() {
  const std::lock_guard lock(mutex_);
  waits_.store(false);
  moved_.reset();
}

std::optional<HandLearner::Moved> HandLearner::moved() {
  const std::lock_guard lock(mutex_);
  return std::exchange(moved_, std::nullopt);
}

// --- For a reader ----------------------------------------------------------------------------------------------------

std::vector<HandSlots> HandSource::slots() const {
  std::vector<HandSlots> slots;
  for (const auto& board : boards_) {
    HandSlots one;
    one.universe = board->universe;
    one.levels = board->hand.levels;
    one.priorities = board->hand.priorities;
    one.dark_levels = board->black.levels;
    bool any = false;
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      one.dark[slot] = board->black.priorities[slot] == kPriorityOverride;
      any = any || one.dark[slot] || one.priorities[slot] != 0;
    }
    if (any) slots.push_back(one);
  }
  return slots;
}

void HandShown::publish(std::vector<HandSlots> slots) {
  const std::lock_guard lock(mutex_);
  published_ = std::move(slots);
  fresh_ = true;
}

void HandShown::take() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(fresh_, false)) return;
  taken_.swap(published_);
}

std::size_t HandShown::held_count() const {
  std::size_t count = 0;
  for (const HandSlots& one : taken_) {
    count += static_cast<std::size_t>(
        std::count_if(one.priorities.begin(), one.priorities.end(), [](std::uint8_t each) { return each != 0; }));
  }
  return count;
}

bool HandShown::dark() const {
  return std::any_of(taken_.begin(), taken_.end(), [](const HandSlots& one) { return one.dark.any(); });
}

namespace {

// Calls `change(slots, levels of the universe)` for each universe of both.
template <class Change>
void change_levels(const std::vector<HandSlots>& all, std::span<const Universe> universes,
                   std::span<std::uint8_t> levels, Change change) {
  for (const HandSlots& one : all) {
    const auto at = std::lower_bound(universes.begin(), universes.end(), one.universe);
    const auto from = static_cast<std::size_t>(at - universes.begin()) * kSlotCountMax;
    if (at == universes.end() || *at != one.universe || from + kSlotCountMax > levels.size()) continue;
    change(one, levels.subspan(from, kSlotCountMax));
  }
}

}  // namespace

void HandShown::overlay(std::span<const Universe> universes, std::span<std::uint8_t> levels,
                        std::uint8_t base_priority) const {
  change_levels(taken_, universes, levels, [&](const HandSlots& one, std::span<std::uint8_t> into) {
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      const std::uint8_t priority = one.priorities[slot];
      if (priority == 0 || priority < base_priority) continue;
      into[slot] = priority == base_priority ? std::max(into[slot], one.levels[slot]) : one.levels[slot];
    }
  });
}

void HandShown::darken(std::span<const Universe> universes, std::span<std::uint8_t> levels) const {
  change_levels(taken_, universes, levels, [](const HandSlots& one, std::span<std::uint8_t> into) {
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      if (one.dark[slot]) into[slot] = one.dark_levels[slot];
    }
  });
}

// --- Status ----------------------------------------------------------------------------------------------------------

// Also while nothing is set: it waits for no device and no sender. A status may be two seconds old, so another state of
// the first moment would be shown beside levels that are set.
PortState HandSource::state() const { return PortState::kWorking; }

std::string HandSource::sender_text(SenderId sender) const { return sender == kBlackoutSender ? "blackout" : ""; }

std::optional<PortNotice> HandSource::take_notice() {
  if (notices_.empty()) return std::nullopt;
  PortNotice notice = std::move(notices_.front());
  notices_.pop_front();
  return notice;
}

std::vector<HandSource::Held> HandSource::held() const {
  std::vector<Held> held;
  for (const auto& board : boards_) {
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      const std::uint8_t priority = board->hand.priorities[slot];
      if (priority == 0 || board->leaving.test(slot)) continue;
      held.push_back({board->universe, static_cast<Address>(slot) + 1, board->hand.levels[slot], priority});
    }
  }
  return held;
}

}  // namespace footlight
