// The editable state of the window with its history, and what follows from it: the levels that were taken over, and
// the values of Highlight. Knows neither a window nor Dear ImGui.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fixtures/edit/add_fixtures.h"
#include "fixtures/edit/rig_edits.h"
#include "fixtures/files/library.h"
#include "fixtures/model/rig.h"
#include "tools/footlight/pictures/flash_mode.h"
#include "tools/footlight/preview/fly_camera.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/ui/level_comparison.h"
#include "tools/footlight/preview/ui/rig_index.h"
#include "tools/footlight/preview/ui/stage_measure.h"
#include "tools/footlight/preview/ui/ui_state.h"

namespace footlight::tools {

// The limits of what a user can set.
inline constexpr float kBrightestEv = -20;
inline constexpr float kDarkestEv = 30;

// What a field of the patch edits of the selected fixtures.
enum class EditField { kAddress, kName, kNumber, kClone };

// Why a locked window refuses something, and how it is unlocked.
[[nodiscard]] std::string locked_words();

// A command that was carried out, for the log of the session.
struct DoneCommand {
  enum class How { kRun, kUndo, kRedo };
  How how = How::kRun;
  std::string text;  // "set Pan of Spot 3"
};

class UiDesk {
 public:
  // Both outlive this, or until show().
  UiDesk(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled) : rig_(&rig), compiled_(&compiled) {}

  // The rig as it is shown: with addresses for faders, and what VRSL makes of it.
  [[nodiscard]] const fixtures::Rig& rig() const { return *rig_; }
  [[nodiscard]] const fixtures::CompiledRig& compiled() const { return *compiled_; }
  // Shows another rig, with as many fixtures as the edited one. Panels notice by shown_count().
  void show(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);
  [[nodiscard]] std::uint64_t shown_count() const { return shown_count_; }

  // Lets a rig be edited, which outlives this. remake() is called after each change of it; it calls show(), or fails
  // and shows the same as before. Then the edit is taken back.
  void let_edit(fixtures::Rig& edited, std::function<Status()> remake) {
    state_.edited = &edited;
    while (state_.ids.size() < edited.fixtures.size()) state_.ids.push_back(state_.next_id++);
    remake_ = std::move(remake);
  }
  [[nodiscard]] bool can_edit() const { return state_.edited != nullptr; }
  // The rig as its file has it, or will have it; as it is shown if it cannot be edited.
  [[nodiscard]] const fixtures::Rig& edited() const { return state_.edited != nullptr ? *state_.edited : *rig_; }
  // Makes an edit, or fails with its reason, and nothing is changed. `selects`: the selection after it; nothing: the
  // same fixtures.
  Status edit(Result<fixtures::RigEdit> edit, std::optional<Selection> selects = std::nullopt);
  // The cameras as the user has them: of the edited rig, or with those that the window made up for it.
  [[nodiscard]] const std::vector<fixtures::Camera>& cameras() const {
    return edited().made_up_cameras ? rig().cameras : edited().cameras;
  }
  // Copies fixtures, and selects the copies.
  Status clone(fixtures::Fixtures which, const fixtures::CloneRow& row);
  Status clone_selected(const fixtures::CloneRow& row) { return clone(selected(), row); }
  // Adds fixtures, and selects them.
  Status add(const fixtures::NewFixtures& row);
  // Where definitions of fixtures are that can be added, besides the built-in ones.
  void list_definitions_in(std::vector<fixtures::LibraryFolder> folders) { definition_folders_ = std::move(folders); }
  [[nodiscard]] const std::vector<fixtures::LibraryFolder>& definition_folders() const { return definition_folders_; }
  // Rigs and logs that were opened before, the newest first.
  void list_recent(std::vector<std::string> rigs, std::vector<std::string> logs = {}) {
    recent_rigs_ = std::move(rigs);
    recent_logs_ = std::move(logs);
  }
  [[nodiscard]] const std::vector<std::string>& recent_logs() const { return recent_logs_; }
  [[nodiscard]] const std::vector<std::string>& recent_rigs() const { return recent_rigs_; }
  // A message for the line of news, from where there is no other place for it.
  void tell(std::string news) { news_ = std::move(news); }
  [[nodiscard]] std::string take_news() { return std::exchange(news_, {}); }
  // What is selected, by index.
  [[nodiscard]] fixtures::Fixtures selected() const { return state_.selection.fixtures; }

  // Made by the first call.
  [[nodiscard]] const RigIndex& index();
  [[nodiscard]] const UiState& state() const { return state_; }
  [[nodiscard]] const UiHistory& history() const { return history_; }
  [[nodiscard]] bool take_forgot() { return history_.take_forgot(); }

  void run(UiCommand command);
  // The commands since the last call, at most the last 256. Those of one gesture are one, as it is by now.
  [[nodiscard]] std::vector<DoneCommand> take_done() { return std::exchange(done_, {}); }
  // What the commands that follow belong to, until the next call: a drag is one gesture.
  void begin_gesture() { ++gesture_; }
  // Takes the command of the current gesture back, as if it had not been: for a drag that is cancelled. Nothing happens
  // if there was none. For commands that do not edit the rig.
  void drop_gesture() {
    if (history_.drop(state_, gesture_) && !done_.empty()) done_.pop_back();
  }
  // The text of the command; empty: there was none.
  std::string undo();
  std::string redo();
  // The newest command, which undo() takes back, is an edit of the rig that needs a new picture.
  [[nodiscard]] bool edited_last() const {
    const auto* edit = history_.next_undo() != nullptr ? std::get_if<EditRig>(history_.next_undo()) : nullptr;
    return edit != nullptr && edit->edit.edits_fixtures();
  }
  // Where the camera and the exposure start. Not a command.
  void start_view(const OrbitCamera& camera, const Exposure& exposure) {
    state_.camera = camera;
    state_.exposure = exposure;
  }

  // Views of the stage: 1, 2 or 4, with a camera each. That of UiState and of the commands below is of the active one.
  // These are no commands. A flight ends when another view becomes active.
  [[nodiscard]] int views() const { return views_; }
  void set_views(int views);
  void activate_view(int view);
  void place_camera(int view, const OrbitCamera& camera) { state_.camera_of(view) = camera; }
  [[nodiscard]] const OrbitCamera& camera_of(int view) const {
    return view == state_.view ? state_.camera : state_.cameras[static_cast<std::size_t>(view)];
  }

  // As the mouse does; movements of one gesture join.
  void move_camera(const OrbitCamera& camera) { run(MoveCamera{camera}); }
  // To another place at once, also to its exposure if it has one. A gesture of its own: the turn of the wheel that
  // follows is another edit.
  void jump_camera(const OrbitCamera& camera, std::optional<float> exposure_ev = std::nullopt);
  // Within kDarkestEv and kBrightestEv; nothing happens if it is no number.
  void set_exposure(Exposure exposure);

  // How the picture looks. start_look() is not a command.
  void set_look(const PictureLook& look) { run(SetLook{look}); }
  void start_look(const PictureLook& look) { state_.look = look; }

  // Asks the patch for a field of the selected fixtures, which opens there.
  void ask_field(EditField field) { asked_field_ = field; }
  [[nodiscard]] std::optional<EditField> take_asked_field() { return std::exchange(asked_field_, std::nullopt); }

  // Markers of the log. Errors: those of with_marker() and with_name(). Indices into UiState::markers.
  Status add_marker(TimeNs at_ns);
  Status rename_marker(std::size_t index, std::string_view name);
  void remove_marker(std::size_t index);
  // As the file beside the log has them. Not a command.
  void start_markers(Markers markers) { state_.markers = std::move(markers); }

  // As a click in a list does: `add` (Ctrl) adds or removes, else replaces. -1: nothing, so all stays with `add`.
  void select(int fixture, bool add);
  void select(Selection selection) { run(SelectFixtures{std::move(selection), {}}); }
  // Those that are listed, or all.
  void select_all();
  // Fixtures that a filter leaves in a list that is shown; nullopt: no filter. Each turn.
  void list(std::optional<std::vector<int>> fixtures) { listed_ = std::move(fixtures); }
  [[nodiscard]] bool lists_some() const { return listed_.has_value(); }
  // Fixtures whose name matches, with * for any text.
  void select_named(std::string_view pattern);

  // Sets a channel to a raw value, and to the same in all selected fixtures of the same type and mode. In others their
  // channels with the same attribute go as near to the same physical value as they can. levels: that the fixtures get,
  // since other channels may decide what the value means.
  void take(ChannelKey key, std::uint32_t raw, std::span<const std::uint8_t> levels);
  // The channel, and those that take() would set with it to the value that it has now.
  void release(ChannelKey key, std::span<const std::uint8_t> levels);
  void release_all();

  // Several channels to raw values, as one edit; those without an address are left out.
  void take_values(std::span<const std::pair<ChannelKey, std::uint32_t>> values);
  // As take() for each of them, as one edit.
  void take_several(std::span<const std::pair<ChannelKey, std::uint32_t>> values, std::span<const std::uint8_t> levels);
  // As release() for each of them, as one edit.
  void release_several(std::span<const ChannelKey> keys, std::span<const std::uint8_t> levels);
  // The channels that mix colours, in all selected fixtures that have some. rgb: linear, 0 to 1.
  void take_colour(const glm::dvec3& rgb);

  // Selected fixtures are lit in white: with Highlight wherever they point to or turn, with Locate at their home
  // position. At most one of the two is on.
  [[nodiscard]] bool highlights() const { return lights_ == Writes::kHighlight; }
  void set_highlight(bool on) { set_lights(on ? Writes::kHighlight : Writes::kNothing); }
  [[nodiscard]] bool locates() const { return lights_ == Writes::kLocate; }
  void set_locate(bool on) { set_lights(on ? Writes::kLocate : Writes::kNothing); }
  // What overlay() writes into a channel.
  enum class Writes { kNothing, kTaken, kHighlight, kLocate };
  [[nodiscard]] Writes writes(ChannelKey key);

  // A locked desk takes no edit of the rig and no command that changes levels, whoever asks; edit() fails, the others
  // tell why, once a gesture. Cameras, the look of the picture, markers and selections go on, but for a selection that
  // is lit by Highlight or Locate.
  [[nodiscard]] bool locked() const { return locked_; }
  void set_locked(bool on) { locked_ = on; }
  // Whether undo() or redo() would be refused.
  [[nodiscard]] bool locks(const UiCommand* command) const;
  // Tells why, once a gesture. True: it is locked.
  bool refuses();

  // What harmful flashes of the picture do.
  [[nodiscard]] FlashMode flashes() const { return flashes_; }
  void set_flashes(FlashMode mode) { flashes_ = mode; }

  // Whether handles that move and aim the selected fixtures are in the picture.
  [[nodiscard]] bool handles() const { return handles_; }
  void set_handles(bool on) { handles_ = on; }

  // The camera that flies with keys.
  [[nodiscard]] const FlyCamera& fly() const { return fly_; }
  [[nodiscard]] FlyCamera& fly() { return fly_; }

  // Whether clicks measure, and what.
  [[nodiscard]] const StageMeasure& measure() const { return measure_; }
  [[nodiscard]] StageMeasure& measure() { return measure_; }
  // Whether lines on the floor are in the picture.
  [[nodiscard]] bool floor_lines() const { return floor_lines_; }
  void set_floor_lines(bool on) { floor_lines_ = on; }

  // Two moments whose levels the universes panel compares.
  [[nodiscard]] const LevelComparison& comparison() const { return comparison_; }
  [[nodiscard]] LevelComparison& comparison() { return comparison_; }

  // Whether overlay() changes anything.
  [[nodiscard]] bool overlays() const {
    return !pauses_ && (!state_.taken.empty() || (lights_ != Writes::kNothing && !state_.selection.fixtures.empty()));
  }
  // While the fixtures that move are not those that are shown: nothing is written over their levels.
  void pause_overlay(bool pauses) { pauses_ = pauses; }
  // Writes what was taken over, and above that Highlight or Locate, over the levels of the rig.
  void overlay(std::span<std::uint8_t> levels);

 private:
  [[nodiscard]] TakeChannels command_of(ChannelKey key, std::uint32_t raw, bool takes,
                                        std::span<const std::uint8_t> levels);
  // What Highlight and Locate do with a channel.
  enum class Lit { kNever, kLit, kPoints };
  [[nodiscard]] const std::vector<Lit>& lit_channels(const fixtures::PatchedFixture& fixture);
  [[nodiscard]] bool is_lit(Lit lit) const { return lit == Lit::kLit || (lit == Lit::kPoints && locates()); }
  void run_taken(TakeChannels command);
  void set_lights(Writes lights);

  void note_done(DoneCommand done);
  [[nodiscard]] Status follow_rig(const UiCommand& command);
  [[nodiscard]] bool is_hidden(const UiCommand* command) const;
  void show_view_of(const UiCommand& command);
  Status edit_and_select_added(Result<fixtures::RigEdit> one);

  const fixtures::Rig* rig_;
  const fixtures::CompiledRig* compiled_;
  std::function<Status()> remake_;
  std::uint64_t shown_count_ = 0;
  std::string news_;
  std::vector<DoneCommand> done_;
  std::optional<EditField> asked_field_;
  std::vector<fixtures::LibraryFolder> definition_folders_;
  std::vector<std::string> recent_rigs_;
  std::vector<std::string> recent_logs_;
  std::unique_ptr<RigIndex> index_;
  std::unique_ptr<HandLevels> lit_;                                // what Highlight writes; made when it is first used
  std::map<std::pair<int, int>, std::vector<Lit>> lit_channels_;   // of a type and a mode
  UiState state_;
  UiHistory history_;
  std::uint64_t gesture_ = 1;
  Writes lights_ = Writes::kNothing;
  FlashMode flashes_ = FlashMode::kWarn;
  bool handles_ = false;
  bool floor_lines_ = false;
  FlyCamera fly_;
  int views_ = 1;
  StageMeasure measure_;
  LevelComparison comparison_;
  std::optional<std::vector<int>> listed_;
  bool pauses_ = false;
  bool locked_ = false;
  std::uint64_t refused_ = 0;  // the gesture that was told why
};

}  // namespace footlight::tools
