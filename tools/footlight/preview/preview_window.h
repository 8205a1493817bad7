// The loop of `footlight preview`: levels from a log, an input or faders -> Frame -> window. Only for the files
// preview_*.cpp, each of which has one part of it.
//
// One thread, two devices (decision 0150): that of the stage draws pictures for as long as they take, that of the
// window shows the last one under the panels, as often as the screen does. While a picture is in flight nothing that
// its commands use may change: all that touches frame_ but step() happens in turn_stage().
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "render/frame.h"
#include "render/live_error.h"
#include "render/quality.h"
#include "sim/pattern.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/displays/display_videos.h"
#include "tools/footlight/edit/autosave.h"
#include "tools/footlight/mvr/exchange_follower.h"
#include "tools/footlight/pictures/log_damage.h"
#include "tools/footlight/pictures/timeline.h"
#include "tools/footlight/preview/coming_settings.h"
#include "tools/footlight/preview/compared_log.h"
#include "tools/footlight/preview/edited_scene.h"
#include "tools/footlight/preview/frame_times.h"
#include "tools/footlight/preview/hand_layer.h"
#include "tools/footlight/preview/hand_levels.h"
#include "tools/footlight/preview/live_levels.h"
#include "tools/footlight/preview/live_outputs.h"
#include "tools/footlight/preview/log_player.h"
#include "tools/footlight/preview/log_thumbnails.h"
#include "tools/footlight/preview/next_window.h"
#include "tools/footlight/preview/preview.h"
#include "tools/footlight/preview/preview_flashes.h"
#include "tools/footlight/preview/preview_panel.h"
#include "tools/footlight/preview/recording.h"
#include "tools/footlight/preview/stage_comparison.h"
#include "tools/footlight/preview/stage_picture.h"
#include "tools/footlight/preview/ui/draw_busy.h"
#include "tools/footlight/preview/ui/file_dialog.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/messages.h"
#include "tools/footlight/preview/ui/palette.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/questions.h"
#include "tools/footlight/preview/ui/report_view.h"
#include "tools/footlight/preview/ui/stage_box.h"
#include "tools/footlight/preview/ui/stage_handles.h"
#include "tools/footlight/preview/ui/stage_pick.h"
#include "tools/footlight/preview/ui/stage_views.h"
#include "tools/footlight/preview/ui/ui_desk.h"
#include "tools/footlight/preview/window.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {

extern const char* const kArmedUnmeasured;  // why curves of knobs are not measured while outputs are armed

class Preview {
 public:
  // What the user opened instead; the window has closed for it.
  [[nodiscard]] const std::optional<NextWindow>& next() const { return next_; }
  // A picture was shown.
  [[nodiscard]] bool opened() const { return picture_ns_ >= 0; }
  // Since its first turn, which --seconds counts from.
  [[nodiscard]] double seconds() const { return static_cast<double>(last_ns_ - start_ns_) * 1e-9; }
  // As the user has set them since: endpoints of inputs and controls; nothing: no rig was read.
  [[nodiscard]] std::vector<std::string> inputs() const;
  [[nodiscard]] std::optional<FlashMode> flashes() const {
    return desk_ ? std::optional(desk_->flashes()) : std::nullopt;
  }

  // Likewise those of outputs.
  [[nodiscard]] std::vector<std::string> outputs() const { return outputs_view_.staying(); }
  [[nodiscard]] bool holds_to_live() const { return outputs_view_.needs_hold; }
  [[nodiscard]] bool locked() const { return desk_ && desk_->locked(); }

  // The looks of the window, once it has opened.
  [[nodiscard]] const WindowSettings& settings() const { return settings_; }

  // The options outlive this.
  explicit Preview(const PreviewOptions& options);

  // Until the window is closed.
  Result<int> run();

 private:
  Result<int> open_and_turn();

  // Up to the first picture: preview_open.cpp. open(): false if it was closed while loading.
  Result<bool> open(const StopSignal& signal);
  Status load_rig(double aspect);
  Result<RigFile> open_file();
  Status open_levels(bool again = false);
  Status open_window_device();
  Status open_device();
  Status set_controls(const fixtures::Camera& camera);
  Status make_ladder();
  Result<render::KnobCurves> read_curves();
  void take_curves(const render::KnobCurves& curves);
  [[nodiscard]] std::size_t first_place(const render::KnobCurves& curves) const;  // in the ladder
  void mark_start(const char* ended);
  Result<bool> wait_for(std::future<Status>& work, const StopSignal& signal, const char* what);
  Status show_progress(const char* what);

  // Turn after turn: preview_window.cpp.
  Status turn();
  Status pace();
  Status take_picture();
  Status turn_stage(const PixelRect& where);
  [[nodiscard]] bool fits_controls(const PixelRect& where);
  // The settings of the window and its controls, with these knobs.
  [[nodiscard]] render::FrameSettings settings_with(const render::Knobs& knobs, const PixelRect& where) const;
  [[nodiscard]] render::FrameSettings frame_settings(const PixelRect& where, bool rough) const;
  // Those that a new frame has tables for.
  [[nodiscard]] render::FrameSettings table_settings(const PixelRect& where) const;
  Status rebuild(const PixelRect& where);
  Status update_error();
  void follow_first_picture(const PixelRect& where);
  void follow_knobs(const render::KnobPoint& point);
  Status draw();
  Status read_picture();
  void read_second();
  // What the report panel shows: preview_report.cpp.
  void follow_report();
  void read_report(double gpu_ms);
  void read_left_out();
  [[nodiscard]] bool reports() const { return panels_.is_open(report_panel_) && !window_->minimised(); }
  // Rigs over the network: preview_exchange.cpp.
  void follow_exchange();
  [[nodiscard]] std::string folder_for_rigs() const;
  // What the user changes of the picture: preview_picture.cpp.
  void take_picture_requests();
  [[nodiscard]] bool is_compiled(const PixelRect& where);
  [[nodiscard]] Busy busy() const;
  void cancel_busy();
  [[nodiscard]] double haze_per_m() const;
  Status follow_flashes();
  void ask_for_quality(const render::QualityRequest& request);
  Result<bool> follow_quality();
  void drop_curves();
  void tell_flashes(bool begins);
  Status start_again(const Error& loss);
  Status replace_stage();
  Status replace_window();

  // What drives the fixtures: preview_steps.cpp.
  Status step_levels();
  Status turn_log(DurationNs dt_ns, const LogPlayer::Driven& driven);
  Status step_meanwhile();
  void show_videos();
  [[nodiscard]] std::unique_ptr<LogPlayer> make_player(SharedScene scene, const LogReader& log);
  [[nodiscard]] LogPlayer::Driven driven();
  void follow_selected_curve();
  void tell_damage(std::optional<DamageWatch>& watch);
  Status work_at_index();
  Status take_thumbnail();
  Status begin_thumbnail();
  void give(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure);
  [[nodiscard]] std::span<const std::uint8_t> newest_levels() const;
  [[nodiscard]] std::span<const std::uint8_t> panel_levels();
  [[nodiscard]] bool overlays() const;
  void lay_over(std::span<const Universe> universes, std::span<std::uint8_t> levels);
  [[nodiscard]] static std::optional<fixtures::VrslReplay> vrsl_replay(const PreviewScene& scene);
  // True if neither a log nor an input drove the rig at the start.
  [[nodiscard]] bool by_hand() const {
    return starts_without_inputs_ && options_.files.log.empty() && !options_.files.demo;
  }

  // Levels by hand over all of it: preview_hand.cpp.
  Status open_hand();
  Status rest_hand();
  void follow_hand();
  void tap();
  void learn();
  Status add_learnt(const HandLearner::Moved& moved);
  Status reopen_control(const std::string& before, const std::string& after);
  [[nodiscard]] const LiveLevels* shown_levels() { return live_ ? live_.get() : layer_ ? layer_->shown() : nullptr; }

  // Recordings: preview_recording.cpp.
  Status start_recording(const std::string& path);
  void toggle_recording();
  void end_recording();
  void report_recording(bool waits);
  void keep_recording();
  void offer_recording();
  void draw_recorded_line();

  // Markers of the log: preview_markers.cpp.
  void open_markers();
  void mark_time();
  [[nodiscard]] TimeNs marker_start_ns(bool back) const;
  void go_to_marker(const Marker* marker);
  void keep_markers();

  // Outputs to real lamps: preview_outputs.cpp.
  Status open_outputs(std::span<const std::string> texts);
  Status keep_outputs(std::span<const std::string> texts);
  Status move_output(const OutputsView::Move& move);
  void drive_outputs();
  bool call_outputs(const UiCall& call);
  [[nodiscard]] std::string why_still_dark(const UiCall& call) const;

  // Inputs that come and go: preview_inputs.cpp.
  Status start_live(std::vector<std::unique_ptr<Source>> sources);
  Result<std::unique_ptr<Source>> open_input(const std::string& text, bool again);
  void follow_patterns();
  void follow_inputs();
  [[nodiscard]] std::string why_no_input() const;
  Status add_input(const std::string& text);
  Status move_input(const InputsView::Move& move);
  void remove_input(const std::string& text);
  void close_inputs();

  // Edits of the rig: preview_edits.cpp.
  void start_edits();
  Status begin_frame(const PixelRect& where);
  void drop_frame();
  Result<bool> follow_edits(const PixelRect& where);
  Status take_scene(const PreviewScene& before);
  void open_inputs_again(const PreviewScene& before);
  void save();
  void keep_edits();
  void end_edits();
  bool may_close();
  void draw_questions();
  [[nodiscard]] bool unsaved() const { return desk_ && desk_->state().revision != saved_revision_; }

  // What lies over the picture, mouse and keys: preview_input.cpp.
  void draw_ui(DurationNs dt_ns);
  void take_input(bool typing, DurationNs dt_ns);
  void take_mouse();
  bool take_handles();
  bool take_box(bool handle);
  void cancel_drags();
  void escape();
  // Comparisons: preview_compare.cpp.
  void compare_from_here();
  void keep_this_moment();
  Status compare_with(const std::string& path);
  Status take_compared_log();
  void follow_compared_log();
  [[nodiscard]] TimeNs compared_time_ns() const;
  // On the stage: preview_stage_compare.cpp.
  void set_stage_compare(StageCompare mode);
  void follow_stage_compare();
  Status begin_compared();
  Status take_difference(const HostPicture& picture);
  [[nodiscard]] LogPlayer::Driven driven_aside();
  [[nodiscard]] bool steps_wait() const {
    return both_.holds_steps() ? both_.is_full() : frame_->steps_are_due();
  }
  void draw_compared();
  void draw_measures();
  void step_history(bool back);
  void call(const UiCall& call);
  void take_camera(std::size_t index);
  void show_cameras();
  void edit_cameras(const CameraRequest& request);
  void store_new_camera();
  [[nodiscard]] fixtures::Camera view_as_camera() const;
  void view_from_side(ViewSide side);
  void fly(bool typing, DurationNs dt_ns);
  void frame_box(const glm::dvec3& low_m, const glm::dvec3& high_m);
  void expose(double steps_ev);
  void take_look();
  void show_exposure();
  void tell(std::string news, bool wrong = false);
  void tell(const Error& error);
  // Of all views, and of one; stage() is the active one.
  [[nodiscard]] PixelRect place() const;
  [[nodiscard]] PixelRect place_of(int view) const { return view_place(place(), views(), view); }
  // How many are shown, and which of them keys and the mouse belong to: those of the desk, or A and B.
  [[nodiscard]] int views() const;
  [[nodiscard]] int active_view() const;
  [[nodiscard]] StagePlace stage() const;
  // Several views: preview_views.cpp.
  void start_views();
  void set_views(int views);
  void call_views(bool next);
  Status follow_views();
  void take_active_view();
  [[nodiscard]] int view_under_mouse() const;
  [[nodiscard]] bool over_active_view() const;
  [[nodiscard]] bool pressed_on_stage() const;
  [[nodiscard]] bool shows_all() const;
  void draw_views();
  [[nodiscard]] const StagePick& pick();

  // What the window remembers: preview_settings.cpp.
  Status open_settings();
  void follow_settings();
  void show_look();
  void note_recent();

  // Files that are dropped on the window, and rigs that are opened again: preview_files.cpp.
  void take_drops();
  void open_dropped(const std::vector<std::string>& paths);
  void open_dialog(FileDialog::Use use);
  void draw_dialog();
  Status save_as(const std::string& path, bool replaces);
  void add_definition(const std::string& path);
  void ask_to_open(NextWindow next);
  void draw_open_question();

  // Figures and pictures for files and standard output: preview_figures.cpp.
  [[nodiscard]] std::vector<std::uint64_t> view_pictures() const;
  void print_second();
  static void print_message(const std::string& text, bool wrong);
  void print_commands();
  void print_summary();
  Status write_shot();
  void write_own_shot();
  [[nodiscard]] std::size_t validation_messages() const {
    return messages_before_ + device_->validation_messages().size() + window_device_->validation_messages().size();
  }

  const PreviewOptions& options_;
  render::FrameSettings lens_;  // of which depth of field
  SystemClock clock_;
  PortOpener opener_;
  std::mutex opener_mutex_;              // outputs are opened on threads of their own
  std::unique_ptr<EditedScene> edited_;  // the rig that is edited; its scene() is what panels show
  SharedScene framed_;                   // what frame_ was made from

  // What drives the rig: one of the three.
  std::optional<LogReader> log_;  // not read itself: player_ has readers of its own
  std::optional<DamageWatch> log_watch_;       // of log_
  std::unique_ptr<LogPlayer> player_;
  std::unique_ptr<LiveLevels> live_;
  std::unique_ptr<Timeline> live_timeline_;
  std::unique_ptr<HandLevels> hand_;
  std::vector<std::string> ins_;          // endpoints of live_; with hand_: those that could not be opened
  std::vector<std::string> controls_in_;  // endpoints of controls, of layer_
  const bool starts_without_inputs_;      // no endpoint of the options is an input of levels
  std::vector<PatternSource*> patterns_;  // of live_
  std::string learns_for_;                // the target of the control that is being learnt
  InputsView inputs_view_;
  std::unique_ptr<HandLevels> resting_hand_;  // from before the first input that was added, of resting_scene_
  SharedScene resting_scene_;
  std::unique_ptr<HandLayer> layer_;  // over all of them; ends before they do

  std::unique_ptr<Recording> recording_;    // null: nothing is recorded
  std::future<Result<std::string>> ended_;  // valid: a recording is being written to its end
  std::string ended_path_;                  // its file
  bool recording_failed_ = false;           // one of this run: the exit code is that of a failure
  std::string recorded_;                    // a file that the window offers to play; empty: none
  TimeNs step_ns_ = 0;                      // when the step that is given next begins, of live inputs and faders
  std::unique_ptr<LiveOutputs> outputs_;    // null: there are none
  OutputsView outputs_view_;
  std::optional<DamageWatch> compared_watch_;  // of compared_
  std::unique_ptr<ComparedLog> compared_;  // whose levels are A of the comparison; null: none
  TimeNs compared_since_ns_ = 0;           // without a log that plays: when it began
  std::future<Result<LogReader>> reading_compared_;  // valid: it is read
  std::string compared_path_;
  StageComparison both_;  // A and B on the stage; ends before frame_
  int compared_view_ = 0;  // the active one of both
  DisplayVideos videos_;             // of displays; without those that have failed
  bool outputs_told_ = false;        // that there are some, with the first picture
  TimeNs looked_ns_ = 0;             // for devices that are plugged in
  std::string markers_path_;         // empty: they are not saved
  Markers saved_markers_;            // as the file has them
  std::optional<LightCurve> curve_;  // of the log, from the moments of its index
  std::optional<LightCurve> selected_curve_;  // the same of the selected fixtures, which are:
  std::vector<int> curve_selection_;
  struct Strips {
    explicit Strips(SharedScene of) : scene(std::move(of)), strips(scene->rig, scene->compiled) {}
    SharedScene scene;
    LightStrips strips;
  };
  std::unique_ptr<Strips> strips_;  // the same, once a panel is open

  std::unique_ptr<render::vk::Device> window_device_;  // outlives the window's swapchain
  std::unique_ptr<Window> window_;
  std::unique_ptr<render::vk::Device> device_;  // of the stage
  std::unique_ptr<render::Frame> frame_;
  double refresh_hz_ = 60;                   // of the screen
  TimeNs drawn_ns_ = 0;                      // when the newest picture was started
  std::optional<OrbitCamera> drawn_camera_;  // of it
  int drawn_view_ = 0;                       // of it
  bool drawn_main_ = true;                   // figures of the stage are those of it
  StageCompare drawn_compare_ = StageCompare::kOff;  // of it
  // A view of the stage. All are drawn by frame_, in turn, and have the same size.
  struct View {
    std::optional<OrbitCamera> shown;         // camera of the picture that the window shows; nothing: there is none
    std::unique_ptr<PreviewFlashes> flashes;  // null: --flashes off
    bool flashes_held = false;
    std::uint64_t pictures = 0;
  };
  std::array<View, kViewsMax> views_;
  ViewTurns view_turns_;
  int shown_views_ = 1;                       // that follow_views() has seen
  render::vk::Buffer counts_;                 // of the current picture, for the panel
  std::unique_ptr<render::LiveError> error_;  // while the panel shows it; null in a rig without light
  render::Knobs knobs_;                       // but for nodes and divisor, which are those of controls_
  bool error_begun_ = false;                  // what error_ needs is being compiled
  bool error_tried_ = false;                  // error_ was made, or cannot be
  bool is_rough_ = false;                     // the first pictures, in software (render::rough_settings)
  bool shows_rough_ = false;                  // the window shows such a picture
  bool compiles_whole_ = false;               // is_rough_ ends once the pipelines have finished
  bool error_drawn_ = false;                  // the current picture has its samples
  std::vector<render::KnobPoint> ladder_;     // for --error and --ms; else empty
  std::optional<render::TimeKeeper> keeper_;  // for --ms
  double gpu_ms_ = 0;                         // of the last picture
  std::optional<render::KnobCurves> curves_;  // of this machine, once they were needed
  std::future<Result<render::KnobCurves>> reading_curves_;  // valid: they are measured or read
  std::atomic<bool> stops_curves_ = false;
  bool stopped_curves_ = false;  // since they were begun
  std::atomic<double> curves_share_ = 0;  // of the measurement that is done
  ComingSettings coming_;  // of a frame that is to be another one for its size or settings
  BusyMark busy_mark_;
  bool wants_curves_ = false;    // also without a request for an error or a time
  const std::size_t report_panel_ = panel_of("report");
  const std::size_t universes_panel_ = panel_of("universes");
  std::vector<UnpatchedUniverse> unpatched_;  // of live_, while that panel is open
  ReportView report_;
  bool looked_for_curves_ = false;  // of this machine, in their file
  SharedScene left_out_scene_;      // that report_.left_out is of, with these settings
  render::FrameSettings left_out_settings_;
  std::future<LeftOutPlan> reading_left_out_;
  bool haze_is_rig_ = true;                // the slider edits the rig; else, with --haze, only the picture
  double picture_haze_per_m_ = 0;          // then
  std::atomic<bool> closed_ = false;       // while other threads worked: they may end early
  std::unique_ptr<StagePicture> picture_;  // destroyed before what its commands use
  LogThumbnails thumbnails_;               // likewise; beside frame_

  // Edits.
  struct Made;
  std::future<Result<std::unique_ptr<Made>>> making_;  // valid: a frame of an edited rig is being made
  SharedScene making_scene_;                           // of it
  SharedScene failed_;                                 // of which no frame can be made
  TimeNs made_begun_ns_ = 0;
  bool first_of_edit_ = false;  // the frame of an edited rig is there, and no picture of it yet
  std::unique_ptr<Autosave> autosave_;
  std::optional<FolderClaim> recovered_;  // of the copy that the rig was read from
  std::uint64_t saved_revision_ = 0;      // of the edited rig as it is in its file
  std::optional<LostEdits> lost_;         // of a session before, until the user has answered
  std::string save_error_;                // of the last save
  std::string title_;
  CloseQuestion close_question_;
  bool asks_close_ = false;
  bool discards_ = false;
  bool times_out_ = false;  // --seconds have passed

  ExchangeFollower exchange_;
  ExchangeView exchange_view_;
  std::optional<NextWindow> asked_next_;  // while the question is open
  std::optional<NextWindow> next_;
  OpenQuestion open_question_;
  std::string settings_path_;  // empty: they are not saved
  WindowSettings settings_;
  WindowSettings saved_settings_;  // as the file has them
  WindowSettings shown_settings_;  // as the window looks

  std::unique_ptr<UiDesk> desk_;  // once the rig is read
  UiPanels panels_;
  PictureShelf pictures_;
  Palette palette_;
  FileDialog dialog_;
  std::string saved_as_;       // where the rig was saved since it was opened; empty: nowhere else
  std::unique_ptr<StagePick> pick_;  // made by the first selection
  StageHandles handles_;
  StageBox box_;
  std::vector<std::uint8_t> overlaid_;  // levels with what was taken over
  std::vector<std::uint8_t> panel_levels_;
  std::vector<std::uint8_t> aside_levels_;
  std::array<bool, 3> pressed_on_stage_{};  // buttons of the mouse
  bool selects_more_ = false;               // Ctrl or Shift was held at the last press
  bool look_began_ = false;                 // state().look is that of the options, or newer
  bool shot_asked_ = false;                 // the next picture is kept
  bool shot_taken_ = false;
  MessageLog messages_;
  FrameTimes ui_times_;          // CPU time of the panels
  FrameTimes turn_times_{4096};  // from turn to turn: of the user interface
  FrameTimes show_times_{4096};  // of turns that changed the window: until it was given to the window system
  PreviewControls controls_;
  PreviewFacts facts_;
  FrameTimes times_;      // from picture to picture of the stage
  int wanted_width_ = 0;  // of the window's place for the picture when last looked at, and since when
  int wanted_height_ = 0;
  int sized_views_ = 1;  // that frame_ has the size for
  TimeNs wanted_since_ns_ = 0;

  TimeNs begun_ns_ = 0;
  DurationNs progress_ns_ = -1;                              // from there to the first text in the window; -1: not yet
  DurationNs picture_ns_ = -1;                               // to the first picture
  DurationNs whole_ns_ = -1;                                 // to the first one that is not rough
  std::vector<std::pair<const char*, double>> start_marks_;  // what ended when, ms; until there is a frame
  TimeNs start_ns_ = 0;
  TimeNs last_ns_ = 0;            // when the last turn began
  TimeNs stepped_ns_ = 0;         // up to when the fixtures have moved
  TimeNs picture_since_ns_ = -1;  // when the picture before was done; -1: the next one is the first of its kind
  bool presented_ = false;        // by the last turn
  TimeNs second_ns_ = 0;          // when the figures were last computed
  std::uint64_t second_frames_ = 0;
  bool closing_ = false;
  struct Losses {
    int count = 0;  // shortly one after the other
    TimeNs last_ns = 0;
  };
  Losses stage_losses_, window_losses_;
  std::size_t messages_before_ = 0;  // of the validation layer, of devices that were lost
};

}  // namespace footlight::tools
