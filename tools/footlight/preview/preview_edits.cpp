// Edits of the rig in the preview: the scene that follows them, saving, automatic copies and the end.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <unordered_map>
#include <utility>

#include <fmt/chrono.h>

#include "sim/core/counted.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/status/status_text.h"

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
  std::unique_ptr<Timeline> timeline;  // of a log, at the time of the one before
  std::vector<std::uint8_t> log_levels;
};

Result<RigFile> Preview::open_file() {
  const std::string state = state_folder();
  auto lost = find_lost_edits(state, options_.files.rig);
  if (!options_.recover) {
    if (lost) lost_when_ = fmt::format("{:%H:%M, %d %B}", fmt::localtime(static_cast<std::time_t>(lost->written_s)));
    return open_scene_file(options_.files);
  }
  if (!lost) {
    return fail(ErrorCode::kNotFound, "--recover: no edits of {} were lost; start without it",
                options_.files.rig.empty() ? "the demo" : options_.files.rig);
  }
  FL_ASSIGN(RigFile file, open_lost_edits(*lost));
  recovered_ = std::move(lost->claim);
  saved_revision_ = UINT64_MAX;
  return file;
}

// Lets the panels edit the rig.
void Preview::start_edits() {
  desk_->let_edit(edited_->file().rig(), [this]() -> Status {
    FL_TRY(edited_->remake());
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
  const TimeNs until_ns = timeline_ ? timeline_->now_ns() : 0;
  const NoSignals no_signals;
  making_ = std::async(std::launch::async,
                       [this, scene = making_scene_, settings = frame_settings(where), until_ns,
                        logs = timeline_ != nullptr]() -> Result<std::unique_ptr<Made>> {
                         auto made = std::make_unique<Made>();
                         FL_ASSIGN(made->frame, render::Frame::create(*device_, scene->rig, scene->compiled, settings));
                         if (!logs) return made;
                         FL_ASSIGN(made->timeline, read_log(*scene));
                         if (made->timeline->can_go() && until_ns > kQuickLogNs) {
                           FL_TRY(made->timeline->start_at(until_ns - kQuickLogNs));
                         }
                         Status flushed;
                         FL_TRY(made->timeline->advance(
                             until_ns, 0, [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool exposes) {
                               made->log_levels.assign(levels.begin(), levels.end());
                               made->frame->step(levels, dt_ns, exposes);
                               if (made->frame->steps_are_due() && flushed) {
                                 flushed = made->frame->run_steps();
                               }
                             }));
                         FL_TRY(flushed);
                         return made;
                       });
  return {};
}

// What the user set by faders goes on in another scene: by index, or by name where there are more or fewer fixtures.
void Preview::take_hand(const PreviewScene& before) {
  auto next = std::make_unique<HandLevels>(framed_->rig, framed_->compiled);
  const HandLevels untouched(before.rig, before.compiled);
  const bool same = before.rig.fixtures.size() == framed_->rig.fixtures.size();
  std::unordered_map<std::string_view, std::size_t> by_name;
  for (std::size_t i = 0; i < framed_->rig.fixtures.size(); ++i) by_name[framed_->rig.fixtures[i].name] = i;
  for (std::size_t i = 0; i < hand_->fixture_count(); ++i) {
    std::size_t index = i;
    if (!same) {
      const auto at = by_name.find(before.rig.fixtures[i].name);
      if (at == by_name.end()) continue;
      index = at->second;
    }
    const auto usual = untouched.faders(i);
    const auto faders = hand_->faders(i);
    for (std::size_t f = 0; f < faders.size(); ++f) {
      if (faders[f].value != usual[f].value) next->set(index, faders[f].attribute, faders[f].value);
    }
  }
  hand_ = std::move(next);
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
    } else {  // inputs are opened for their universes; senders repeat their levels within seconds
      live_timeline_.reset();
      live_.reset();
      FL_TRY(open_levels());
    }
  } else if (hand_) {
    take_hand(before);
    frame_->settle_machine_air(hand_->levels());
  }
  facts_.fixtures.clear();
  for (const auto& fixture : framed_->rig.fixtures) facts_.fixtures.push_back(fixture.name);
  facts_.can_haze = framed_->compiled.needs.haze;
  if (controls_.hand_fixture >= static_cast<int>(facts_.fixtures.size())) controls_.hand_fixture = -1;
  panels_.restart();
  return {};
}

// Waits for a frame that is being made, and leaves it.
void Preview::drop_frame() {
  if (making_.valid()) (void)making_.get();
  making_scene_.reset();
}

// True while the picture stands still: the rig was edited, and the frame of the edited rig is not yet there.
Result<bool> Preview::follow_edits(const PixelRect& where) {
  if (making_.valid() && making_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    auto made = making_.get();
    if (!made && device_->lost()) return tl::unexpected<Error>(std::move(made).error());
    if (made) {
      error_.reset();
      error_tried_ = error_drawn_ = shown_ = false;
      frame_ = std::move((*made)->frame);
      if ((*made)->timeline) {
        timeline_ = std::move((*made)->timeline);
        log_levels_ = std::move((*made)->log_levels);
      }
      const SharedScene before = std::exchange(framed_, std::exchange(making_scene_, nullptr));
      if (timeline_) FL_TRY(make_index());
      FL_TRY(take_scene(*before));
      facts_.edit_to_frame_ms = static_cast<double>(clock_.now_ns() - made_begun_ns_) * 1e-6;
    } else {
      failed_ = std::exchange(making_scene_, nullptr);
      tell(made.error().message + "; the picture shows the rig from before");
    }
  }
  const SharedScene& scene = edited_->scene();
  if (scene == framed_) failed_.reset();
  if (!making_.valid() && scene != framed_ && scene != failed_) FL_TRY(begin_frame(where));
  return making_.valid() || scene != framed_;
}

// The last picture again, under what lies over it.
Status Preview::show_still(const PixelRect& where) {
  shown_ = false;
  if (window_->minimised()) return {};
  WindowPicture picture;
  if (picture_ns_ >= 0) {
    picture.image = facts_.flashes_held ? flashes_->standing() : frame_->resources().picture.screen.handle;
    picture.width = frame_->settings().width;
    picture.height = frame_->settings().height;
  }
  picture.place = where;
  FL_TRY(window_->show(picture, [](VkCommandBuffer) {}));
  return {};
}

void Preview::save() {
  RigFile& file = edited_->file();
  if (!unsaved() && file.known()) return tell(fmt::format("no edits to save in {}", file.target()));
  const auto report = file.save();
  save_error_ = report ? "" : report.error().message;
  if (!report) return tell(save_error_);
  saved_revision_ = desk_->state().revision;
  autosave_->forget();
  std::string news = fmt::format("saved {}", std::filesystem::absolute(report->path).string());
  if (report->shared > 0) news += fmt::format("; {} fixtures share slots", report->shared);
  if (!report->old.empty()) news += fmt::format("; the file from before is {}", report->old);
  tell(std::move(news));
}

// Once a picture: the copy for a crash, and the title.
void Preview::keep_edits() {
  if (const auto error = autosave_->step(clock_.now_ns(), desk_->state().revision, unsaved())) {
    tell("no automatic copy of the edits: " + error->message);
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
  if (!lost_when_.empty()) {
    if (const auto answer = draw_lost_edits(lost_when_, window_->ui_scale())) {
      lost_when_.clear();
      if (*answer == LostAnswer::kDiscard) {
        if (auto lost = find_lost_edits(state_folder(), options_.files.rig)) lost->claim.remove();
      }
    }
  }
  if (!asks_close_) return;
  const auto answer = close_question_.draw(edited_->file().target(), save_error_);
  if (!answer) return;
  asks_close_ = false;
  if (*answer == CloseAnswer::kSave) save();
  discards_ = *answer == CloseAnswer::kDiscard;
  closing_ = discards_ || (*answer == CloseAnswer::kSave && !unsaved());
  asks_close_ = *answer == CloseAnswer::kSave && unsaved();  // with the reason why it could not be saved
}

// At the end of the program.
void Preview::end_edits() {
  drop_frame();
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
