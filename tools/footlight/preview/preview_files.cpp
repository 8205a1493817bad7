// Files that are dropped on the preview's window, and rigs that are opened again.
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "fixtures/files/definition_list.h"
#include "tools/footlight/preview/dropped_file.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/new_place.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

std::string name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

// Definitions are added at once; the last rig and the last log of a drop are asked about.
void Preview::take_drops() {
  open_dropped(window_->take_drops());
}

void Preview::open_dropped(const std::vector<std::string>& paths) {
  const DroppedFiles dropped = sort_dropped(paths);
  for (const Error& refused : dropped.refused) tell(refused);
  for (const std::string& path : dropped.definitions) add_definition(path);
  if (dropped.rig.empty() && dropped.log.empty()) return;
  ask_to_open({dropped.rig, dropped.log, false, dropped.rig.empty() ? saved_as_ : ""});
}

void Preview::open_dialog(FileDialog::Use use) {
  dialog_.open(file_start(use, edited_->file().target(), settings_.recent_rigs));
}

// What the user has chosen in the dialog, which stays open with what cannot be opened or saved.
void Preview::draw_dialog() {
  dialog_.draw(window_->ui_scale(), [this](const FileDialog::Chosen& chosen) -> Status {
    if (chosen.use == FileDialog::Use::kSave) return save_as(chosen.path, chosen.replaces);
    FL_TRY(kind_of_dropped(chosen.path));
    open_dropped({chosen.path});
    return {};
  });
}

// From then on the rig is that of the new file.
Status Preview::save_as(const std::string& path, bool replaces) {
  FL_TRY(edited_->file().save_as(path, replaces));
  saved_revision_ = desk_->state().revision;
  autosave_->forget();
  saved_as_ = path;
  settings_.add_recent(path);
  desk_->list_recent(settings_.recent_rigs, settings_.recent_logs);
  tell(trf("saved {}", path));
  return {};
}

// One fixture of its first mode, as the button of the library does.
void Preview::add_definition(const std::string& path) {
  auto type = fixtures::open_definition(path);
  if (!type) return tell(type.error());
  fixtures::NewFixtures row;
  row.type = std::make_shared<const fixtures::FixtureType>(std::move(*type));
  row.position_m = new_place(desk_->edited());
  desk_->begin_gesture();
  const Status added = desk_->add(row);
  desk_->begin_gesture();
  if (!added) return tell(added.error());
  const fixtures::PatchedFixture& one = desk_->edited().fixtures.back();
  tell(trf("added {}, {}, at {}; Ctrl+Z takes it back, F7 adds more", one.name,
           fixtures::mode_of(desk_->edited(), one).name, fixtures::text_of_patch(one)));
}

void Preview::ask_to_open(NextWindow next) {
  if (desk_->locked()) return tell(locked_words());
  std::error_code trouble;
  for (const std::string& path : {next.rig, next.log}) {
    if (path.empty() || std::filesystem::exists(path, trouble)) continue;
    return tell(trf("{}: there is no such file", path), true);
  }
  asked_next_ = std::move(next);
}

// The window closes and opens again, with the question about unsaved edits before.
void Preview::draw_open_question() {
  if (!asked_next_ || asks_close_) return;
  const bool rig = !asked_next_->rig.empty();
  const bool both = rig && !asked_next_->log.empty();
  std::string then = both  ? tr("The window opens again with both; inputs are closed.")
                     : rig ? tr("The window opens again with this rig, driven as before; a log is closed.")
                           : tr("The window opens again with this rig and the log; inputs are closed.");
  if (outputs_ && outputs_view_.any_on()) then += tr(" Armed outputs go dark.");
  const std::string what = both ? trf("Open {} with {}?", name_of(asked_next_->rig), name_of(asked_next_->log))
                                : trf("Open {}?", name_of(rig ? asked_next_->rig : asked_next_->log));
  const auto answer = open_question_.draw(what, then, !rig);
  if (!answer) return;
  if (*answer == OpenAnswer::kOpen) {
    next_ = std::move(asked_next_);
    closing_ = true;
  } else if (*answer == OpenAnswer::kCompare) {
    if (const Status opened = compare_with(asked_next_->log); !opened) tell(opened.error());
  }
  asked_next_.reset();
}

}  // namespace footlight::tools
