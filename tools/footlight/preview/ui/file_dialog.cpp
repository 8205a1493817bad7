#include "tools/footlight/preview/ui/file_dialog.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/edit/rig_file.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFilesPopup = "###files";
constexpr float kFilesWidth = 760;
constexpr float kFilesHeight = 480;
constexpr float kPlacesWidth = 150;
constexpr int kPageRows = 10;
constexpr const char* kFilterWords[] = {tr_mark("all that can be opened"), tr_mark("rigs"), tr_mark("definitions"),
                                        tr_mark("logs"), tr_mark("all files")};

bool is_key(ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); }

bool is_folder(const std::string& path) {
  std::error_code trouble;
  return fs::is_directory(path, trouble);
}

std::string date_text(std::int64_t unix_s) {
  return unix_s == 0 ? "" : fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(static_cast<std::time_t>(unix_s)));
}

}  // namespace

void FileDialog::open(Start start) {
  opens_ = true;
  asks_.clear();
  chosen_.reset();
  const std::string before = std::exchange(start_, std::move(start)).folder;
  list_.set_filter(saves() ? FileFilter::kRigs : FileFilter::kOpens);
  go(saves() || before.empty() ? start_.folder : before);
  if (saves()) set_text(start_.name);
}

// marks: the entry that is marked once it is read.
void FileDialog::go(const std::string& folder, const std::string& marks) {
  start_.folder = folder;
  list_.clear();
  list_.mark_name(marks);
  trouble_.clear();
  reader_ = std::make_unique<FolderReader>(folder);
  if (!saves()) set_text("");
  focuses_ = scrolls_ = true;
}

void FileDialog::set_text(const std::string& text) {
  text_.fill(0);
  text.copy(text_.data(), text_.size() - 1);
  ++field_;
  focuses_ = true;
}

// What has come since the last picture.
void FileDialog::read() {
  if (!reader_) return;
  if (std::vector<FileEntry> more = reader_->take(); !more.empty()) list_.add(std::move(more));
  if (!reader_->ended()) return;
  if (const auto error = reader_->error()) trouble_ = printable_utf8(tr_known(error->message));
  reader_.reset();
}

void FileDialog::refuse(const Error& error) {
  trouble_ = printable_utf8(tr_known(error.message));
  asks_.clear();
}

void FileDialog::choose(const std::string& path) {
  std::error_code trouble;
  const bool there = fs::exists(path, trouble);
  if (!saves()) {
    if (!there) {
      trouble_ = trf("{}: there is no such file", printable_utf8(path));
      return;
    }
    chosen_ = {start_.use, path, false};
    return;
  }
  const std::string whole = kind_of_name(path) == FileKind::kRig && path.ends_with(".toml") ? path : path + ".toml";
  if (const Status can = check_rig_target(whole); !can) return refuse(can.error());
  trouble_.clear();
  if (fs::exists(whole, trouble)) {
    asks_ = whole;
  } else {
    chosen_ = {start_.use, whole, false};
  }
}

void FileDialog::act(std::size_t row) {
  const FileEntry& entry = list_.at(row);
  const std::string path = path_from(start_.folder, "./" + entry.name, start_.home);
  if (entry.kind == FileKind::kFolder) return go(path);
  choose(path);
}

// Of the field.
void FileDialog::enter() {
  const std::string text = text_.data();
  const int marked = list_.marked();
  const bool is_path = text.find('/') != std::string::npos || text == "~" || text == "..";
  if (is_path) {
    const std::string path = path_from(start_.folder, text, start_.home);
    if (!is_folder(path)) return choose(path);
    go(path);
    return set_text(saves() ? start_.name : "");
  }
  if (marked >= 0) return act(static_cast<std::size_t>(marked));
  if (saves() && !text.empty()) choose(path_from(start_.folder, "./" + text, start_.home));
}

void FileDialog::draw_field() {
  ImGui::PushID(field_);
  if (std::exchange(focuses_, false)) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  const char* const hint = saves() ? tr("name of the rig's file, or a folder") : tr("words of a name, or a path");
  const bool entered = ImGui::InputTextWithHint("##field", hint, text_.data(), text_.size(),
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  if (ImGui::IsItemEdited()) {
    asks_.clear();
    if (saves()) {
      list_.mark(-1);
    } else {
      list_.set_words(text_[0] == '/' || text_[0] == '~' ? "" : text_.data());
    }
    scrolls_ = true;
  }
  ImGui::PopID();
  if (entered) {
    enter();
    focuses_ = true;
  }
}

void FileDialog::draw_places(float width, float height) {
  if (ImGui::BeginChild("places", {width, height})) {
    for (std::size_t i = 0; i < start_.places.size(); ++i) {
      const FilePlace& place = start_.places[i];
      ImGui::PushID(static_cast<int>(i));
      const std::string label = printable_utf8(place.name) + "###place";
      if (ImGui::Selectable(label.c_str(), place.path == start_.folder)) go(place.path);
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", printable_utf8(place.path).c_str());
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
}

void FileDialog::draw_row(std::size_t row) {
  const FileEntry& entry = list_.at(row);
  const bool folder = entry.kind == FileKind::kFolder;
  ImGui::PushID(static_cast<int>(row));
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  constexpr ImGuiSelectableFlags kFlags = ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick;
  if (ImGui::Selectable("##row", list_.marked() == static_cast<int>(row), kFlags)) {
    list_.mark(static_cast<int>(row));
    if (saves() && !folder) set_text(fs::path(entry.name).replace_extension(".toml").string());
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      act(row);
      if (folder) return ImGui::PopID();  // the list is another one
    }
  }
  ImGui::SameLine(0, 0);
  ui_text(folder ? kUiAmber : entry.kind == FileKind::kOther ? kUiDim : kUiText,
          printable_utf8(entry.name) + (folder ? "/" : ""));
  ImGui::TableNextColumn();
  ui_text(kUiDim, folder ? "" : file_size_text(entry.bytes));
  ImGui::TableNextColumn();
  ui_text(kUiDim, date_text(entry.modified_s));
  ImGui::PopID();
}

void FileDialog::draw_list(float height, float scale) {
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_Resizable |
                                     ImGuiTableFlags_Sortable | ImGuiTableFlags_BordersInnerV;
  if (!ImGui::BeginTable("files", 3, kFlags, {0, height})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableSetupColumn(tr("Name"), ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn(tr("Size"), ImGuiTableColumnFlags_WidthFixed, 80 * scale);
  ImGui::TableSetupColumn(tr("Changed"), ImGuiTableColumnFlags_WidthFixed, 130 * scale);
  ImGui::TableHeadersRow();
  if (ImGuiTableSortSpecs* const specs = ImGui::TableGetSortSpecs(); specs != nullptr && specs->SpecsCount > 0) {
    list_.sort(static_cast<FileColumn>(specs->Specs[0].ColumnIndex),
               specs->Specs[0].SortDirection == ImGuiSortDirection_Descending);
  }
  const float line = ImGui::GetTextLineHeightWithSpacing();
  if (std::exchange(scrolls_, false) && list_.marked() >= 0) {
    const float top = static_cast<float>(list_.marked()) * line;
    if (top < ImGui::GetScrollY() || top + 3 * line > ImGui::GetScrollY() + height) {
      ImGui::SetScrollY(top - height / 2);
    }
  }
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(list_.shown()));
  const std::string folder = start_.folder;
  while (clipper.Step()) {
    for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row) {
      if (start_.folder == folder && static_cast<std::size_t>(row) < list_.shown()) {
        draw_row(static_cast<std::size_t>(row));
      }
    }
  }
  ImGui::EndTable();
}

void FileDialog::draw_foot(float scale) {
  ImGui::SetNextItemWidth(190 * scale);
  const auto filter = static_cast<std::size_t>(list_.filter());
  if (ImGui::BeginCombo("##filter", tr(kFilterWords[filter]))) {
    for (const FileFilter each : kFileFilters) {
      const char* const words = tr_label(kFilterWords[static_cast<std::size_t>(each)]);
      if (ImGui::Selectable(words, each == list_.filter())) list_.set_filter(each);
    }
    ImGui::EndCombo();
  }
  ImGui::SameLine();
  bool hidden = list_.shows_hidden();
  if (ImGui::Checkbox(tr_label("hidden files"), &hidden)) list_.set_hidden(hidden);
  ImGui::SameLine();
  const std::string count = trf("{} of {}", list_.shown(), list_.size());
  ui_text(reader_ ? kUiAmber : kUiDim, reader_ ? trf("reading ... {}", count) : count);
  if (!trouble_.empty()) {
    ImGui::PushTextWrapPos(0);
    ui_text(kUiRed, trouble_);
    ImGui::PopTextWrapPos();
  }
  if (!asks_.empty()) {
    ui_text(kUiAmber, trf("There is a file {}.", printable_utf8(fs::path(asks_).filename().string())));
    ImGui::SameLine();
    if (ImGui::Button(tr_label("Replace"))) chosen_ = {start_.use, asks_, true};
    ImGui::SameLine();
    if (ImGui::Button(tr_label("Stay"))) asks_.clear();
    return;
  }
  if (ImGui::Button(tr_label(saves() ? tr_mark("Save") : tr_mark("Open")))) enter();
  ImGui::SameLine();
  if (ImGui::Button(tr_label("Cancel"))) ImGui::CloseCurrentPopup();
}

void FileDialog::take_keys() {
  const int step = is_key(ImGuiKey_DownArrow)   ? 1
                   : is_key(ImGuiKey_UpArrow)   ? -1
                   : is_key(ImGuiKey_PageDown)  ? kPageRows
                   : is_key(ImGuiKey_PageUp)    ? -kPageRows
                                                : 0;
  list_.mark_next(step);
  scrolls_ = scrolls_ || step != 0;
  const bool is_empty = text_[0] == 0;
  // The Backspace that empties the field does not leave the folder.
  if (is_empty && was_empty_ && is_key(ImGuiKey_Backspace) && start_.folder != "/") {
    go(parent_of(start_.folder), fs::path(start_.folder).filename().string());
  }
  was_empty_ = is_empty;
}

void FileDialog::draw(float scale, const Take& take) {
  if (std::exchange(opens_, false)) ImGui::OpenPopup(kFilesPopup);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(kFilesWidth * scale, std::max(size.x - 16, 1.0f)),
                            std::min(kFilesHeight * scale, std::max(size.y - 16, 1.0f))});
  const char* const title = saves() ? tr_label("Save the rig as", "files") : tr_label("Open a file", "files");
  constexpr ImGuiWindowFlags kFlags =
      ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
  shown_ = ImGui::BeginPopupModal(title, nullptr, kFlags);
  if (!shown_) {
    reader_.reset();
    return;
  }
  read();
  if (ImGui::Button(tr_label("folder above"))) {
    go(parent_of(start_.folder), fs::path(start_.folder).filename().string());
  }
  ImGui::SameLine();
  ui_text(printable_utf8(start_.folder));
  draw_field();
  const float line = ImGui::GetFrameHeightWithSpacing();
  float foot = line * 2 + ImGui::GetStyle().ItemSpacing.y;
  if (!trouble_.empty()) {
    const float width = ImGui::GetContentRegionAvail().x;
    foot += ImGui::CalcTextSize(trouble_.c_str(), nullptr, false, width).y + ImGui::GetStyle().ItemSpacing.y;
  }
  const float height = std::max(ImGui::GetContentRegionAvail().y - foot, 3 * line);
  draw_places(kPlacesWidth * scale, height);
  ImGui::SameLine();
  draw_list(height, scale);
  draw_foot(scale);
  take_keys();
  const bool leaves = is_key(ImGuiKey_Escape);
  bool closes = leaves && asks_.empty();
  if (const auto chosen = std::exchange(chosen_, std::nullopt)) {
    if (const Status taken = take(*chosen); taken) {
      closes = true;
    } else {
      refuse(taken.error());
    }
  }
  if (closes) ImGui::CloseCurrentPopup();
  if (leaves) asks_.clear();
  ImGui::EndPopup();
}

FileDialog::Start file_start(FileDialog::Use use, const std::string& beside,
                             const std::vector<std::string>& recent_rigs) {
  const char* const home = std::getenv("HOME");
  std::error_code trouble;
  const std::string path = fs::absolute(beside, trouble).lexically_normal().string();
  std::ifstream mounts("/proc/self/mounts");
  const std::string mounted{std::istreambuf_iterator<char>(mounts), {}};
  FileDialog::Start start;
  start.use = use;
  start.folder = parent_of(path);
  start.name = fs::path(path).filename().string();
  start.home = home != nullptr ? home : "/";
  start.places = file_places(start.home, path, recent_rigs, mounted);
  return start;
}

}  // namespace footlight::tools
