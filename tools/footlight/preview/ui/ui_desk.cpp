#include "tools/footlight/preview/ui/ui_desk.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fixtures/model/names.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/pick_colour.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

// Decides where a head points: its angles, its continuous rotation, and how fast it gets there.
bool points(const fixtures::ChannelFunction& function) {
  const auto use = fixtures::use_of(function.attribute);
  if (!use) return false;
  for (const auto param : {fixtures::kParamPan, fixtures::kParamTilt, fixtures::kParamPanSpinHz,
                           fixtures::kParamTiltSpinHz, fixtures::kParamPositionSpeed, fixtures::kParamTracking}) {
    if (use->param == param) return true;
  }
  return false;
}

// Highlight shows where a fixture points, so it leaves alone the channels that decide it: those with such a function,
// and those that switch such a function on or act on it.
std::vector<bool> pointing_channels(const fixtures::Mode& mode) {
  std::vector<bool> pointing(mode.channels.size());
  for (std::size_t c = 0; c < pointing.size(); ++c) {
    for (const fixtures::ChannelFunction& function : mode.channels[c].functions) {
      if (!points(function)) continue;
      pointing[c] = true;
      for (const auto& master : function.masters) pointing[static_cast<std::size_t>(master.channel)] = true;
    }
  }
  for (const fixtures::Relation& relation : mode.relations) {
    const auto& functions = mode.channels[static_cast<std::size_t>(relation.follower)].functions;
    if (std::any_of(functions.begin(), functions.end(), points)) {
      pointing[static_cast<std::size_t>(relation.master)] = true;
    }
  }
  return pointing;
}

// Machines that fill the room are not lit.
bool blows(const fixtures::Channel& channel) {
  return std::any_of(channel.functions.begin(), channel.functions.end(), [](const fixtures::ChannelFunction& function) {
    return function.attribute.starts_with("Fog") || function.attribute.starts_with("Haze") ||
           function.attribute.starts_with("Fan") || function.attribute.starts_with("Blower");
  });
}

}  // namespace

const RigIndex& UiDesk::index() {
  if (!index_) index_ = std::make_unique<RigIndex>(*rig_, *compiled_);
  return *index_;
}

void UiDesk::show(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled) {
  rig_ = &rig;
  compiled_ = &compiled;
  ++shown_count_;
  index_.reset();
  lit_.reset();
  lit_channels_.clear();
}

// After a command that may have changed the rig. An edit of cameras only makes no other picture.
Status UiDesk::follow_rig(const UiCommand& command) {
  const auto* edit = std::get_if<EditRig>(&command);
  return edit != nullptr && edit->edit.edits_fixtures() && remake_ ? remake_() : Status();
}

void UiDesk::note_done(DoneCommand done) {
  constexpr std::size_t kDoneMax = 256;
  if (done_.size() == kDoneMax) done_.erase(done_.begin());
  done_.push_back(std::move(done));
}

std::string locked_words() {
  return tr("The window is locked: nothing in it edits the rig or sets levels. Ctrl+Shift+L unlocks it");
}

bool UiDesk::locks(const UiCommand* command) const {
  if (!locked_ || command == nullptr) return false;
  if (std::holds_alternative<SelectFixtures>(*command)) return lights_ != Writes::kNothing;
  return std::holds_alternative<EditRig>(*command) || std::holds_alternative<TakeChannels>(*command);
}

bool UiDesk::refuses() {
  if (locked_ && std::exchange(refused_, gesture_) != gesture_) tell(locked_words());
  return locked_;
}

void UiDesk::set_lights(Writes lights) {
  if (lights != lights_ && !refuses()) lights_ = lights;
}

void UiDesk::run(UiCommand command) {
  if (locks(&command)) return (void)refuses();
  const auto ran = history_.run(state_, std::move(command), gesture_);
  if (ran == UiHistory::Ran::kNothing) return;
  DoneCommand done{DoneCommand::How::kRun, text_of(*history_.next_undo(), rig())};
  if (ran == UiHistory::Ran::kJoined && !done_.empty()) {
    done_.back() = std::move(done);
  } else {
    note_done(std::move(done));
  }
}

Status UiDesk::edit(Result<fixtures::RigEdit> edit, std::optional<Selection> selects) {
  if (!edit) return tl::unexpected<Error>(std::move(edit).error());
  if (!can_edit()) return fail(ErrorCode::kUnsupported, "this rig cannot be edited");
  if (locked_) return fail(ErrorCode::kUnsupported, "{}", locked_words());
  const std::uint64_t before = state_.revision;
  const bool remakes = remake_ && edit->edits_fixtures();
  run(EditRig{std::move(*edit), std::move(selects)});
  if (state_.revision == before) return {};
  Status made = remakes ? remake_() : Status();
  if (made) return {};
  // A drag is taken back as a whole, so what is shown is not yet what is left.
  if (!done_.empty()) done_.pop_back();
  history_.undo(state_);
  history_.forget_undone();
  (void)remake_();
  return made;
}

Status UiDesk::edit_and_select_added(Result<fixtures::RigEdit> one) {
  Selection after;
  if (one) {
    for (const auto& entry : one->added) after.fixtures.push_back(entry.fixture);
    after.lead = after.fixtures.empty() ? -1 : after.fixtures.front();
  }
  return edit(std::move(one), std::move(after));
}

Status UiDesk::clone(fixtures::Fixtures which, const fixtures::CloneRow& row) {
  return edit_and_select_added(fixtures::clone_fixtures(edited(), which, row));
}

Status UiDesk::add(const fixtures::NewFixtures& row) {
  return edit_and_select_added(fixtures::add_fixtures(edited(), row));
}

// A movement in a view that is closed, which nobody sees.
bool UiDesk::is_hidden(const UiCommand* command) const {
  const auto* move = command != nullptr ? std::get_if<MoveCamera>(command) : nullptr;
  return move != nullptr && !move->exposure_ev && move->view.value_or(0) >= std::max(views_, 1);
}

// What moves is seen: the view of a movement becomes the active one.
void UiDesk::show_view_of(const UiCommand& command) {
  if (const auto* move = std::get_if<MoveCamera>(&command)) activate_view(move->view.value_or(state_.view));
}

std::string UiDesk::undo() {
  if (locks(history_.next_undo())) return locked_words();
  const UiCommand* command = history_.undo(state_);
  while (is_hidden(command) && !locks(history_.next_undo())) command = history_.undo(state_);
  if (command == nullptr) return "";
  show_view_of(*command);
  if (const Status made = follow_rig(*command); !made) {
    history_.redo(state_);
    return made.error().message;
  }
  std::string text = text_of(*command, rig());
  note_done({DoneCommand::How::kUndo, text});
  return text;
}

std::string UiDesk::redo() {
  if (locks(history_.next_redo())) return locked_words();
  const UiCommand* command = history_.redo(state_);
  while (is_hidden(command) && !locks(history_.next_redo())) command = history_.redo(state_);
  if (command == nullptr) return "";
  show_view_of(*command);
  if (const Status made = follow_rig(*command); !made) {
    history_.undo(state_);
    return made.error().message;
  }
  std::string text = text_of(*command, rig());
  note_done({DoneCommand::How::kRedo, text});
  return text;
}

void UiDesk::select(int fixture, bool add) {
  Selection next = add ? state_.selection : Selection{};
  if (fixture >= 0) {
    const auto at = std::lower_bound(next.fixtures.begin(), next.fixtures.end(), fixture);
    if (at != next.fixtures.end() && *at == fixture) {
      next.fixtures.erase(at);
      if (next.lead == fixture) next.lead = next.fixtures.empty() ? -1 : next.fixtures.back();
    } else {
      next.fixtures.insert(at, fixture);
      next.lead = fixture;
    }
  }
  select(std::move(next));
}

void UiDesk::select_all() {
  Selection all;
  if (listed_) {
    for (const int fixture : *listed_) {  // as of the last turn, so an edit may have taken some away
      if (static_cast<std::size_t>(fixture) < rig_->fixtures.size()) all.fixtures.push_back(fixture);
    }
    std::sort(all.fixtures.begin(), all.fixtures.end());
    if (!all.fixtures.empty()) all.lead = all.has(state_.selection.lead) ? state_.selection.lead : all.fixtures[0];
    select(std::move(all));
    return;
  }
  all.fixtures.resize(rig_->fixtures.size());
  std::iota(all.fixtures.begin(), all.fixtures.end(), 0);
  all.lead = state_.selection.lead >= 0 ? state_.selection.lead : all.fixtures.empty() ? -1 : 0;
  select(std::move(all));
}

void UiDesk::select_named(std::string_view pattern) {
  Selection next;
  for (std::size_t i = 0; i < rig_->fixtures.size(); ++i) {
    if (fixtures::name_matches(pattern, rig_->fixtures[i].name)) next.fixtures.push_back(static_cast<int>(i));
  }
  next.lead = next.fixtures.empty() ? -1 : next.fixtures.front();
  select(std::move(next));
}

// What take() and release() change: the channel at this value, and those that follow it.
TakeChannels UiDesk::command_of(ChannelKey key, std::uint32_t raw, bool takes, std::span<const std::uint8_t> levels) {
  TakeChannels command;
  command.moved = key;
  const auto& all = rig_->fixtures;
  const fixtures::PatchedFixture& own = all[static_cast<std::size_t>(key.fixture)];
  const auto add = [&](ChannelKey one, std::uint32_t value) {
    if (index().place(one)) command.edits.push_back({one, takes ? std::optional(value) : std::nullopt, std::nullopt});
  };
  if (!state_.selection.has(key.fixture)) {
    add(key, raw);
    return command;
  }
  const fixtures::FixtureType& type = fixtures::type_of(*rig_, own);
  const fixtures::Mode& mode = fixtures::mode_of(*rig_, own);
  const fixtures::Channel& channel = mode.channels[static_cast<std::size_t>(key.channel)];
  const ChannelReading reading = reading_of(type, channel, raw, [&](int other) {
    return index().read({key.fixture, other}, levels);
  });
  const std::string attribute = reading.function != nullptr ? reading.function->attribute : std::string();
  for (const int fixture : state_.selection.fixtures) {
    const fixtures::PatchedFixture& one = all[static_cast<std::size_t>(fixture)];
    if (one.type == own.type && one.mode == own.mode) {
      add({fixture, key.channel}, raw);
      continue;
    }
    if (attribute.empty() || fixtures::same_attribute(attribute, "NoFeature")) continue;
    const fixtures::Mode& its = fixtures::mode_of(*rig_, one);
    for (std::size_t c = 0; c < its.channels.size(); ++c) {
      const auto nearest =
          fixtures::nearest_raw(fixtures::type_of(*rig_, one), its.channels[c], attribute, reading.value);
      if (nearest) add({fixture, static_cast<int>(c)}, nearest->raw);
    }
  }
  return command;
}

void UiDesk::take(ChannelKey key, std::uint32_t raw, std::span<const std::uint8_t> levels) {
  run(command_of(key, raw, true, levels));
}

void UiDesk::release(ChannelKey key, std::span<const std::uint8_t> levels) {
  const auto held = state_.taken.find(key);
  run(command_of(key, held != state_.taken.end() ? held->second : index().read(key, levels), false, levels));
}

void UiDesk::set_views(int views) {
  views_ = views;
  if (state_.view >= views) activate_view(0);
}

void UiDesk::activate_view(int view) {
  if (view < 0 || view >= std::max(views_, 1) || view == state_.view) return;
  fly_.set_on(false);  // a flight ends with its view
  state_.cameras[static_cast<std::size_t>(state_.view)] = state_.camera;
  state_.camera = state_.cameras[static_cast<std::size_t>(view)];
  state_.view = view;
  begin_gesture();
}

void UiDesk::jump_camera(const OrbitCamera& camera, std::optional<float> exposure_ev) {
  begin_gesture();
  run(MoveCamera{camera, exposure_ev});
  begin_gesture();
}

void UiDesk::set_exposure(Exposure exposure) {
  if (!std::isfinite(exposure.ev)) return;
  exposure.ev = std::clamp(exposure.ev, kBrightestEv, kDarkestEv);
  run(SetExposure{exposure});
}

Status UiDesk::add_marker(TimeNs at_ns) {
  FL_ASSIGN(Markers after, with_marker(state_.markers, at_ns));
  run(EditMarkers{std::move(after), tr("add a marker")});
  return {};
}

Status UiDesk::rename_marker(std::size_t index, std::string_view name) {
  FL_ASSIGN(Markers after, with_name(state_.markers, index, name));
  run(EditMarkers{std::move(after), trf("name the marker {}", name)});
  return {};
}

void UiDesk::remove_marker(std::size_t index) {
  Markers after = state_.markers;
  const std::string name = after.at(index).name;
  after.erase(after.begin() + static_cast<std::ptrdiff_t>(index));
  run(EditMarkers{std::move(after), trf("delete the marker {}", name)});
}

void UiDesk::release_all() {
  TakeChannels command;
  for (const auto& [key, raw] : state_.taken) command.edits.push_back({key, std::nullopt, std::nullopt});
  run(std::move(command));
}

// Joins with the command before of the same gesture, if the user moves the same thing.
void UiDesk::run_taken(TakeChannels command) {
  auto& edits = command.edits;
  std::stable_sort(edits.begin(), edits.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  const auto same = [](const auto& a, const auto& b) { return a.key == b.key; };
  edits.erase(std::unique(edits.begin(), edits.end(), same), edits.end());
  if (!edits.empty()) run(std::move(command));
}

void UiDesk::take_values(std::span<const std::pair<ChannelKey, std::uint32_t>> values) {
  TakeChannels command;
  for (const auto& [key, raw] : values) {
    if (index().place(key)) command.edits.push_back({key, raw, std::nullopt});
  }
  run_taken(std::move(command));
}

void UiDesk::take_several(std::span<const std::pair<ChannelKey, std::uint32_t>> values,
                          std::span<const std::uint8_t> levels) {
  TakeChannels command;
  for (const auto& [key, raw] : values) {
    TakeChannels one = command_of(key, raw, true, levels);
    command.moved = command.moved ? command.moved : one.moved;
    command.edits.insert(command.edits.end(), one.edits.begin(), one.edits.end());
  }
  run_taken(std::move(command));
}

void UiDesk::release_several(std::span<const ChannelKey> keys, std::span<const std::uint8_t> levels) {
  TakeChannels command;
  for (const ChannelKey key : keys) {
    const auto held = state_.taken.find(key);
    const std::uint32_t raw = held != state_.taken.end() ? held->second : index().read(key, levels);
    const TakeChannels one = command_of(key, raw, false, levels);
    command.edits.insert(command.edits.end(), one.edits.begin(), one.edits.end());
  }
  run_taken(std::move(command));
}

void UiDesk::take_colour(const glm::dvec3& rgb) {
  std::vector<std::pair<ChannelKey, std::uint32_t>> values;
  std::map<std::pair<int, int>, std::vector<ChannelRaw>> known;  // by type and mode
  for (const int fixture : state_.selection.fixtures) {
    const fixtures::PatchedFixture& one = rig_->fixtures[static_cast<std::size_t>(fixture)];
    const auto [at, fresh] = known.try_emplace({one.type, one.mode});
    if (fresh) at->second = channels_of_colour(fixtures::type_of(*rig_, one), fixtures::mode_of(*rig_, one), rgb);
    for (const ChannelRaw& value : at->second) values.push_back({{fixture, value.channel}, value.raw});
  }
  take_values(values);
}

UiDesk::Writes UiDesk::writes(ChannelKey key) {
  if (pauses_) return Writes::kNothing;
  if (lights_ != Writes::kNothing && state_.selection.has(key.fixture)) {
    const auto& lit = lit_channels(rig_->fixtures[static_cast<std::size_t>(key.fixture)]);
    if (is_lit(lit[static_cast<std::size_t>(key.channel)])) return lights_;
  }
  return state_.taken.contains(key) ? Writes::kTaken : Writes::kNothing;
}

const std::vector<UiDesk::Lit>& UiDesk::lit_channels(const fixtures::PatchedFixture& fixture) {
  const auto [at, fresh] = lit_channels_.try_emplace({fixture.type, fixture.mode});
  if (!fresh) return at->second;
  const fixtures::Mode& mode = fixtures::mode_of(*rig_, fixture);
  const std::vector<bool> pointing = pointing_channels(mode);
  for (std::size_t c = 0; c < pointing.size(); ++c) {
    at->second.push_back(blows(mode.channels[c]) ? Lit::kNever : pointing[c] ? Lit::kPoints : Lit::kLit);
  }
  return at->second;
}

void UiDesk::overlay(std::span<std::uint8_t> levels) {
  const RigIndex& slots = index();
  for (const auto& [key, raw] : state_.taken) slots.write(key, raw, levels);
  if (lights_ == Writes::kNothing || state_.selection.fixtures.empty()) return;
  if (!lit_) lit_ = std::make_unique<HandLevels>(*rig_, *compiled_);
  for (const int fixture : state_.selection.fixtures) {
    const std::vector<Lit>& lit = lit_channels(rig_->fixtures[static_cast<std::size_t>(fixture)]);
    for (std::size_t c = 0; c < lit.size(); ++c) {
      if (!is_lit(lit[c])) continue;
      const ChannelKey key{fixture, static_cast<int>(c)};
      const fixtures::Channel& channel = slots.channel(key);
      const bool stated = channel.has_highlight && lit[c] == Lit::kLit;
      slots.write(key, stated ? channel.highlight_value : slots.read(key, lit_->levels()), levels);
    }
  }
}

}  // namespace footlight::tools
