// Edits of the rig in the preview: the scene that follows them, saving, automatic copies and the end.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <fmt/chrono.h>

#include "fixtures/displays/pixel_slots.h"
#include "sim/core/counted.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

// The rig of the options: a file of any format, or the demo. Prints the number of its warnings.
Result<RigFile> open_scene_file(const SceneFiles& files) {
  if (!files.rig.empty() && files.demo) return fail(ErrorCode::kBadInput, "expected a rig or --demo, not both");
  if (files.demo) return RigFile::made(fixtures::as_imported(fixtures::demo_rig(), "toml"), "demo.toml");
  if (files.rig.empty()) {
    return fail(ErrorCode::kBadInput, "no rig: expected a file, or --demo for the built-in rig");
  }
  fixtures::Diagnostics diagnostics;
  FL_ASSIGN(RigFile file, RigFile::open(files.rig, nullptr, diagnostics));
  diagnostics.finish();
  const auto& all = diagnostics.all();
  const auto wrong = std::count_if(all.begin(), all.end(), [](const fixtures::Diagnostic& one) {
    return one.severity != fixtures::Severity::kNote;
  });
  if (wrong > 0) {
    const std::string path = printable_utf8(files.rig);
    fmt::print(stderr, "footlight: {}: {}; 'footlight rig check {}' lists them\n", path, counted(wrong, "warning"),
               path);
  }
  return file;
}

}  // namespace

struct Preview::Made {
  std::unique_ptr<render::Frame> frame;
  std::unique_ptr<LogPlayer> player;  // at the time of the one before; null without a log
};

Result<RigFile> Preview::open_file() {
  const std::string state = state_folder();
  auto lost = find_lost_edits(state, options_.files.rig);
  if (!options_.recover) {
    lost_ = std::move(lost);
    if (lost_) lost_->claim.release();  // --recover may open them meanwhile
    return open_scene_file(options_.files);
  }
  if (!lost) {
    return fail(ErrorCode::kNotFound, "--recover: no edits of {} were lost; start without it",
                options_.files.rig.empty() ? "the demo" : options_.files.rig);
  }
  FL_ASSIGN(RigFile file, open_lost_edits(*lost));
  if (lost->others) {
    fmt::print(stderr, "footlight: {}: exists and is not the file of these edits; save them under another name\n",
               printable_utf8(lost->target));
  }
  if (lost->older) {
    fmt::print(stderr, "footlight: {}: has changed since these edits; move it away before you save them\n",
               printable_utf8(lost->target));
  }
  recovered_ = std::move(lost->claim);
  saved_revision_ = UINT64_MAX;
  return file;
}

// Lets the panels edit the rig.
void Preview::start_edits() {
  desk_->let_edit(edited_->file().rig(), [this]() -> Status {
    FL_TRY(edited_->remake(desk_->state().ids, desk_->state().revision, framed_));
    desk_->show(edited_->scene()->rig, edited_->scene()->compiled);
    pick_.reset();
    return {};
  });
  autosave_ = std::make_unique<Autosave>(edited_->file(), state_folder(), std::move(recovered_));
  recovered_.reset();
}

// A frame of another scene, made on another thread while the picture stands still. In a log of hours its fixtures have
// the states that follow from the last two minutes; a seek makes them exact.
Status Preview::begin_frame(const PixelRect& where) {
  making_scene_ = edited_->scene();
  made_begun_ns_ = clock_.now_ns();
  const TimeNs until_ns = player_ ? player_->now_ns() : 0;
  const NoSignals no_signals;
  making_ =
      std::async(std::launch::async,
                 [this, scene = making_scene_, settings = table_settings(where), first = frame_settings(where, false),
                  until_ns, logs = player_ != nullptr]() -> Result<std::unique_ptr<Made>> {
                   auto made = std::make_unique<Made>();
                   FL_ASSIGN(made->frame, render::Frame::create(*device_, scene->rig, scene->compiled, settings,
                                                                render::passes_of(options_.style), &first));
                   if (!logs) return made;
                   made->player = make_player(scene, *log_);
                   const auto step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool exposes) {
                     made->frame->step(levels, dt_ns, exposes);
                   };
                   FL_TRY(made->player->show_soon(until_ns, {*device_, *made->frame, false, step, [] {}}));
                   return made;
                 });
  return {};
}

// For other universes. If they cannot be opened, faders drive the rig until an edit after which they can.
void Preview::open_inputs_again(const PreviewScene& before) {
  close_inputs();
  const Status opened = open_levels(true);
  if (opened) {
    hand_.reset();
    return;
  }
  close_inputs();
  hand_ = hand_ ? moved_hand(*hand_, before, *framed_) : std::make_unique<HandLevels>(framed_->rig, framed_->compiled);
  frame_->settle_machine_air(hand_->levels());
  if (outputs_) outputs_->black_out();  // real lamps must not follow faders that nobody has set
  if (const Status rests = rest_hand(); !rests) tell(rests.error());
  tell(trf("faders drive the rig, the inputs are closed: {}", tr_known(opened.error().message)), true);
}

// What drives the fixtures, for framed_ instead of the scene before.
Status Preview::take_scene(const PreviewScene& before) {
  if (live_) {
    const auto old = live_->universes();
    const auto& now = framed_->compiled.universes;
    if (std::equal(old.begin(), old.end(), now.begin(), now.end())) {
      live_->take();
      live_timeline_ = std::make_unique<Timeline>(live_->changes(), framed_->compiled, vrsl_replay(*framed_),
                                                  live_timeline_->now_ns());
      live_timeline_->pass_over(fixtures::pixel_universes(framed_->rig, framed_->compiled));
      live_timeline_->hold(live_->levels());
      follow_patterns();
    } else {  // inputs are opened for their universes; senders repeat their levels within seconds
      open_inputs_again(before);
    }
  } else if (hand_ && !ins_.empty()) {
    open_inputs_again(before);
  } else if (hand_) {
    hand_ = moved_hand(*hand_, before, *framed_);
    frame_->settle_machine_air(hand_->levels());
  }
  if (!live_) FL_TRY(rest_hand());
  facts_.fixtures.clear();
  for (const auto& fixture : framed_->rig.fixtures) facts_.fixtures.push_back(fixture.name);
  facts_.can_haze = framed_->compiled.needs.haze;
  facts_.can_probes = framed_->compiled.needs.probes && options_.probes && options_.bounce;
  if (const auto chosen = static_cast<std::size_t>(std::max(controls_.hand_fixture, 0)); controls_.hand_fixture >= 0) {
    const std::vector<int> moves = fixture_moves(before, *framed_);
    controls_.hand_fixture = chosen < moves.size() ? moves[chosen] : -1;
  }
  panels_.restart();
  return {};
}

// Waits for a frame that is being made, and leaves it.
void Preview::drop_frame() {
  if (making_.valid()) (void)making_.get();
  making_scene_.reset();
}

// True while the picture stands still: the rig was edited, and the frame of the edited rig is not yet there. A frame of
// a rig that was edited since is left: the last picture of the frame before stays until one is the newest.
Result<bool> Preview::follow_edits(const PixelRect& where) {
  if (making_.valid() && making_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    auto made = making_.get();
    if (!made && device_->lost()) return tl::unexpected<Error>(std::move(made).error());
    if (made && making_scene_ != edited_->scene()) {
      making_scene_.reset();
    } else if (made) {
      error_.reset();
      facts_.error = {};  // that of the rig from before
      error_tried_ = error_begun_ = error_drawn_ = false;
      picture_since_ns_ = -1;
      thumbnails_.clear();
      both_.change_rig();
      frame_ = std::move((*made)->frame);
      videos_.show_all_again();
      if ((*made)->player) player_ = std::move((*made)->player);
      curve_.reset();
      first_of_edit_ = true;
      const SharedScene before = std::exchange(framed_, std::exchange(making_scene_, nullptr));
      if (!same_videos(before->rig, framed_->rig)) {  // a fixture with a video as its content came or went
        auto videos = DisplayVideos::open(framed_->rig, ClipPace::kAhead);
        if (!videos) tell(tr_known(videos.error().message), true);
        videos_ = videos ? std::move(*videos) : DisplayVideos();
      }
      FL_TRY(take_scene(*before));
      facts_.edit_to_frame_ms = static_cast<double>(clock_.now_ns() - made_begun_ns_) * 1e-6;
    } else {
      failed_ = std::exchange(making_scene_, nullptr);
      tell(trf("{}; the picture shows the rig from before", tr_known(made.error().message)), true);
    }
  }
  const SharedScene& scene = edited_->scene();
  if (scene != failed_ || scene == framed_) failed_.reset();
  if (!making_.valid() && scene != framed_ && scene != failed_) FL_TRY(begin_frame(where));
  // If no frame can be made, the fixtures of the rig from before move on; the panels have the indices of the new rig.
  panels_.pause(failed_ != nullptr);
  desk_->pause_overlay(failed_ != nullptr);
  return making_.valid() || (scene != framed_ && scene != failed_);
}

void Preview::save() {
  RigFile& file = edited_->file();
  if (!unsaved() && file.known() && mark_of_file(file.target())) {
    return tell(trf("no edits to save in {}", file.target()));
  }
  const auto report = file.save();
  save_error_ = report ? "" : tr_known(report.error().message);
  if (!report) return tell(save_error_, true);
  saved_revision_ = desk_->state().revision;
  autosave_->forget();
  std::string news = trf("saved {}", std::filesystem::absolute(report->path).string());
  if (report->shared > 0)
    news += trf_n("; {} fixture shares slots", "; {} fixtures share slots", report->shared, report->shared);
  if (!report->old.empty()) news += trf("; the file from before is {}", report->old);
  tell(std::move(news));
}

// Once a picture: the copy for a crash, and the title.
void Preview::keep_edits() {
  if (const auto error = autosave_->step(clock_.now_ns(), desk_->state().revision, unsaved())) {
    tell(trf("no automatic copy of the edits: {}", error->message), true);
  }
  std::string title = fmt::format("{}{} - Footlight", unsaved() ? "* " : "", framed_->rig.name);
  if (title == title_) return;
  window_->set_title(title);
  title_ = std::move(title);
}

// Whether the window closes now, as its user wants. With unsaved edits a question comes first.
bool Preview::may_close() {
  if (!unsaved() || discards_ || times_out_) return true;
  window_->keep_open();
  closing_ = false;
  asks_close_ = true;
  return false;
}

void Preview::draw_questions() {
  if (lost_) {
    const auto when = fmt::localtime(static_cast<std::time_t>(lost_->written_s));
    if (const auto answer = draw_lost_edits(fmt::format("{:%H:%M, %d %B}", when), lost_->older, window_->ui_scale())) {
      if (*answer == LostAnswer::kDiscard) discard_lost_edits(*lost_);
      if (*answer == LostAnswer::kRecover) {
        next_ = NextWindow{"", "", true};
        closing_ = true;
      } else {
        lost_.reset();
      }
    }
  }
  draw_recorded_line();
  draw_open_question();
  if (!asks_close_) return;
  const auto answer = close_question_.draw(edited_->file().target(), save_error_);
  if (!answer) return;
  asks_close_ = false;
  if (*answer == CloseAnswer::kStay) next_.reset();
  if (*answer == CloseAnswer::kSave) save();
  discards_ = *answer == CloseAnswer::kDiscard;
  closing_ = discards_ || (*answer == CloseAnswer::kSave && !unsaved());
  asks_close_ = *answer == CloseAnswer::kSave && unsaved();  // with the reason why it could not be saved
}

// At the end of the program.
void Preview::end_edits() {
  drop_frame();
  drop_curves();
  if (!autosave_) return;
  if (!unsaved() || discards_) {
    autosave_->forget();
    return;
  }
  if (const Status kept = autosave_->write_now(desk_->state().revision); !kept) {
    fmt::print(stderr, "footlight: unsaved edits are lost: {}\n", kept.error().message);
  } else if (!state_folder().empty()) {
    fmt::print(stderr, "footlight: unsaved edits are kept; 'footlight preview --recover' with this rig opens them\n");
  }
}

}  // namespace footlight::tools
