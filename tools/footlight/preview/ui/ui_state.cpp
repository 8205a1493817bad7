#include "tools/footlight/preview/ui/ui_state.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "render/display.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

static_assert(sizeof(TakeChannels::Edit) == 24);  // the figure of UiHistory

const std::string& fixture_name(const fixtures::Rig& rig, int fixture) {
  return rig.fixtures[static_cast<std::size_t>(fixture)].name;
}

void set_taken(UiState& state, ChannelKey key, const std::optional<std::uint32_t>& raw) {
  if (raw) {
    state.taken[key] = *raw;
  } else {
    state.taken.erase(key);
  }
}

std::size_t bytes_of(const UiCommand& command) {
  return sizeof(UiCommand) + std::visit([](const auto& one) { return one.heap_bytes(); }, command);
}

}  // namespace

bool Selection::has(int fixture) const { return std::binary_search(fixtures.begin(), fixtures.end(), fixture); }

bool SelectFixtures::apply(UiState& state) {
  before = std::exchange(state.selection, after);
  return before != after;
}
void SelectFixtures::undo(UiState& state) const { state.selection = before; }
std::string SelectFixtures::text(const fixtures::Rig& rig) const {
  if (after.fixtures.empty()) return tr("select nothing");
  if (after.fixtures.size() == 1) return trf("select {}", fixture_name(rig, after.fixtures.front()));
  return trf_n("select {} fixture", "select {} fixtures", after.fixtures.size(), after.fixtures.size());
}
bool SelectFixtures::join(const SelectFixtures& later) {
  after = later.after;
  return true;
}
std::size_t SelectFixtures::heap_bytes() const {
  return (after.fixtures.capacity() + before.fixtures.capacity()) * sizeof(int);
}

bool TakeChannels::apply(UiState& state) {
  bool any = false;
  for (Edit& edit : edits) {
    const auto at = state.taken.find(edit.key);
    edit.before = at != state.taken.end() ? std::optional(at->second) : std::nullopt;
    any = any || edit.before != edit.after;
    set_taken(state, edit.key, edit.after);
  }
  return any;
}
void TakeChannels::undo(UiState& state) const {
  for (const Edit& edit : edits) set_taken(state, edit.key, edit.before);
}
std::string TakeChannels::text(const fixtures::Rig& rig) const {
  if (edits.empty()) return tr("take nothing over");
  const bool sets = edits.front().after.has_value();
  const std::size_t count = edits.size();
  const bool one_fixture = std::all_of(edits.begin(), edits.end(),
                                       [&](const Edit& edit) { return edit.key.fixture == edits.front().key.fixture; });
  const ChannelKey key = edits.front().key;
  const auto& mode = fixtures::mode_of(rig, rig.fixtures[static_cast<std::size_t>(key.fixture)]);
  const std::string channel = name_of(mode.channels[static_cast<std::size_t>(key.channel)]);
  const std::string& fixture = fixture_name(rig, key.fixture);
  if (count == 1) return sets ? trf("set {} of {}", channel, fixture) : trf("release {} of {}", channel, fixture);
  if (one_fixture) {
    return sets ? trf_n("set {} channel of {}", "set {} channels of {}", count, count, fixture)
                : trf_n("release {} channel of {}", "release {} channels of {}", count, count, fixture);
  }
  return sets ? trf_n("set {} channel", "set {} channels", count, count)
              : trf_n("release {} channel", "release {} channels", count, count);
}
bool TakeChannels::join(const TakeChannels& later) {
  const bool same = std::equal(edits.begin(), edits.end(), later.edits.begin(), later.edits.end(),
                               [](const Edit& a, const Edit& b) { return a.key == b.key; });
  if (same) {
    for (std::size_t i = 0; i < edits.size(); ++i) edits[i].after = later.edits[i].after;
    return true;
  }
  if (!moved || moved != later.moved) return false;
  // Its function changed on the way, and with it the channels that follow: all of them are one edit.
  std::vector<Edit> both;
  both.reserve(edits.size() + later.edits.size());
  auto own = edits.begin();
  for (const Edit& edit : later.edits) {
    while (own != edits.end() && own->key < edit.key) both.push_back(*own++);
    both.push_back(edit);
    if (own == edits.end() || own->key != edit.key) continue;
    both.back().before = own->before;
    ++own;
  }
  both.insert(both.end(), own, edits.end());
  edits = std::move(both);
  return true;
}
std::size_t TakeChannels::heap_bytes() const { return edits.capacity() * sizeof(Edit); }

bool MoveCamera::apply(UiState& state) {
  if (!view) view = state.view;
  before = std::exchange(state.camera_of(*view), after);
  before_ev = state.exposure.ev;
  if (exposure_ev) state.exposure.ev = *exposure_ev;
  return true;
}
void MoveCamera::undo(UiState& state) const {
  state.camera_of(view.value_or(state.view)) = before.value_or(after);
  if (exposure_ev) state.exposure.ev = before_ev;
}
std::string MoveCamera::text(const fixtures::Rig&) const { return tr("move the camera"); }
bool MoveCamera::join(const MoveCamera& later) {
  if (view != later.view) return false;
  after = later.after;
  if (!exposure_ev) before_ev = later.before_ev;
  if (later.exposure_ev) exposure_ev = later.exposure_ev;
  return true;
}
std::size_t MoveCamera::heap_bytes() const {
  return after.name().capacity() + (before ? before->name().capacity() : 0);
}

bool SetExposure::apply(UiState& state) {
  before = std::exchange(state.exposure, after);
  return before != after;
}
void SetExposure::undo(UiState& state) const { state.exposure = before; }
std::string SetExposure::text(const fixtures::Rig&) const {
  if (after.automatic) return tr("automatic exposure");
  return trf("set the exposure to {:.2f} EV", after.ev);
}
bool SetExposure::join(const SetExposure& later) {
  after = later.after;
  return true;
}

bool SetLook::apply(UiState& state) {
  before = std::exchange(state.look, after);
  return before != after;
}
std::string SetLook::text(const fixtures::Rig&) const {
  if (after.tone != before.tone) return trf("tone curve {}", render::word_of(after.tone));
  if (after.glare_percent != before.glare_percent) return trf("set the glare to {:.1f} %", after.glare_percent);
  if (!after.balances_white) return tr("no white balance");
  return trf("white balance for {:.0f} K", after.white_k);
}
bool SetLook::join(const SetLook& later) {
  after = later.after;
  return true;
}

bool EditMarkers::apply(UiState& state) {
  before = std::exchange(state.markers, after);
  return before != after;
}
std::size_t EditMarkers::heap_bytes() const {
  return (after.size() + before.size()) * (sizeof(Marker) + kMarkerNameMax) + does.size();
}

// Whether values that were taken over do not stay as they are.
bool EditRig::releases() const {
  return edit.moves_indices() || std::any_of(edit.changes.begin(), edit.changes.end(), [](const auto& change) {
           return change.before.mode != change.after.mode || change.before.type != change.after.type;
         });
}
// Removes and adds ids as the edit does with fixtures.
void EditRig::move_ids(UiState& state) {
  if (!edit.moves_indices()) return;
  if (added_ids.empty()) {
    for (std::size_t i = 0; i < edit.added.size(); ++i) added_ids.push_back(state.next_id++);
  }
  removed_ids.clear();
  std::vector<int> kept;
  kept.reserve(state.ids.size() + added_ids.size());
  for (const int id : state.ids) {
    const int index = static_cast<int>(kept.size() + removed_ids.size());
    const bool gone = removed_ids.size() < edit.removed.size() && edit.removed[removed_ids.size()].fixture == index;
    (gone ? removed_ids : kept).push_back(id);
  }
  for (std::size_t i = 0; i < added_ids.size(); ++i) kept.insert(kept.begin() + edit.added[i].fixture, added_ids[i]);
  state.ids = std::move(kept);
}
bool EditRig::apply(UiState& state) {
  const bool any = edit.edits_stage() || edit.moves_indices() ||
                   std::any_of(edit.changes.begin(), edit.changes.end(),
                               [](const auto& each) { return !fixtures::same_fixture(each.before, each.after); });
  if (!any || state.edited == nullptr) return false;
  while (state.ids.size() < state.edited->fixtures.size()) state.ids.push_back(state.next_id++);
  move_ids(state);
  edit.apply(*state.edited);
  if (revision == 0) revision = ++state.revision_last;
  before = std::exchange(state.revision, revision);
  selection_before = state.selection;
  if (selects) {
    state.selection = *selects;
  } else if (edit.moves_indices()) {
    Selection next;
    for (const int fixture : selection_before.fixtures) {
      if (const int now = edit.index_after(fixture); now >= 0) next.fixtures.push_back(now);
    }
    next.lead = selection_before.lead >= 0 ? edit.index_after(selection_before.lead) : -1;
    if (next.lead < 0 && !next.fixtures.empty()) next.lead = next.fixtures.back();
    state.selection = std::move(next);
  }
  if (state.taken.empty() || !releases()) return true;
  taken_before = std::exchange(state.taken, {});
  std::vector<int> released;
  for (const auto& change : edit.changes) {
    if (change.before.mode != change.after.mode || change.before.type != change.after.type) {
      released.push_back(change.fixture);
    }
  }
  std::sort(released.begin(), released.end());
  for (const auto& [key, raw] : taken_before) {
    const int now = edit.index_after(key.fixture);
    if (now >= 0 && !std::binary_search(released.begin(), released.end(), key.fixture)) {
      state.taken[{now, key.channel}] = raw;
    }
  }
  return true;
}
void EditRig::undo(UiState& state) const {
  edit.undo(*state.edited);
  for (auto each = edit.added.rbegin(); each != edit.added.rend(); ++each) {
    state.ids.erase(state.ids.begin() + each->fixture);
  }
  for (std::size_t i = 0; i < removed_ids.size(); ++i) {
    state.ids.insert(state.ids.begin() + edit.removed[i].fixture, removed_ids[i]);
  }
  state.revision = before;
  state.selection = selection_before;
  if (!taken_before.empty()) state.taken = taken_before;
}
std::string EditRig::text(const fixtures::Rig&) const { return tr_known(edit.text); }
bool EditRig::join(const EditRig& later) {
  if (selects || later.selects || releases() || later.releases() || !edit.join(later.edit)) return false;
  revision = later.revision;
  return true;
}
std::size_t EditRig::heap_bytes() const {
  return edit.bytes() + selection_before.fixtures.capacity() * sizeof(int) +
         (removed_ids.capacity() + added_ids.capacity()) * sizeof(int) +
         (selects ? selects->fixtures.capacity() * sizeof(int) : 0) +
         taken_before.size() * (sizeof(std::pair<const ChannelKey, std::uint32_t>) + 4 * sizeof(void*));
}

std::string text_of(const UiCommand& command, const fixtures::Rig& rig) {
  return std::visit([&](const auto& one) { return one.text(rig); }, command);
}

UiHistory::Ran UiHistory::run(UiState& state, UiCommand command, std::uint64_t gesture) {
  if (!std::visit([&](auto& one) { return one.apply(state); }, command)) return Ran::kNothing;
  forget_undone();
  bool joined = false;
  if (gesture != 0 && gesture == gesture_ && done_ > 0) {
    bytes_ -= bytes_of(commands_.back());
    joined = std::visit(
        [](auto& last, const auto& next) {
          if constexpr (std::is_same_v<std::decay_t<decltype(last)>, std::decay_t<decltype(next)>>) {
            return last.join(next);
          } else {
            return false;
          }
        },
        commands_.back(), command);
    bytes_ += bytes_of(commands_.back());
  }
  gesture_ = gesture;
  if (!joined) {
    if (auto* take = std::get_if<TakeChannels>(&command)) take->edits.shrink_to_fit();
    bytes_ += bytes_of(command);
    commands_.push_back(std::move(command));
  }
  while (bytes_ > bytes_max_ && commands_.size() > 1) {
    bytes_ -= bytes_of(commands_.front());
    commands_.pop_front();
    forgot_ = true;
  }
  done_ = commands_.size();
  return joined ? Ran::kJoined : Ran::kNew;
}

bool UiHistory::drop(UiState& state, std::uint64_t gesture) {
  if (gesture == 0 || gesture != gesture_ || done_ == 0 || done_ != commands_.size()) return false;
  (void)undo(state);
  forget_undone();
  return true;
}

void UiHistory::forget_undone() {
  for (; commands_.size() > done_; commands_.pop_back()) bytes_ -= bytes_of(commands_.back());
}

const UiCommand* UiHistory::undo(UiState& state) {
  if (done_ == 0) return nullptr;
  const UiCommand& command = commands_[--done_];
  std::visit([&](const auto& one) { one.undo(state); }, command);
  gesture_ = 0;
  return &command;
}

const UiCommand* UiHistory::redo(UiState& state) {
  if (done_ == commands_.size()) return nullptr;
  UiCommand& command = commands_[done_++];
  bytes_ -= bytes_of(command);
  std::visit([&](auto& one) { (void)one.apply(state); }, command);
  bytes_ += bytes_of(command);
  gesture_ = 0;
  return &command;
}

}  // namespace footlight::tools
