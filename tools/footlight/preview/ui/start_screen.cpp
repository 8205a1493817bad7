#include "tools/footlight/preview/ui/start_screen.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/dropped_file.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

constexpr float kColumnWidth = 620;

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

void wrapped_text(const ImVec4& colour, const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ui_text(colour, text);
  ImGui::PopTextWrapPos();
}

}  // namespace

StartScreen::StartScreen(std::vector<std::string> recent_rigs, std::vector<std::string> recent_logs, std::string log)
    : recent_rigs_(std::move(recent_rigs)), recent_logs_(std::move(recent_logs)), log_(std::move(log)) {}

void StartScreen::open_dialog() {
  std::error_code trouble;
  const std::string near =
      recent_rigs_.empty() ? (std::filesystem::current_path(trouble) / "rig.toml").string() : recent_rigs_.front();
  dialog_.open(file_start(FileDialog::Use::kOpen, near, recent_rigs_));
}

void StartScreen::choose_rig(const std::string& path) { chosen_ = StartChoice{false, path, log_}; }

Status StartScreen::take_files(const std::vector<std::string>& paths) {
  trouble_.clear();
  const DroppedFiles dropped = sort_dropped(paths);
  if (!dropped.log.empty()) log_ = dropped.log;
  std::string rig = dropped.rig;
  if (rig.empty() && !dropped.definitions.empty()) rig = dropped.definitions.back();
  if (!rig.empty()) choose_rig(rig);
  if (dropped.refused.empty()) return {};
  trouble_ = printable_utf8(tr_known(dropped.refused.front().message));
  return tl::unexpected(dropped.refused.front());
}

void StartScreen::draw_buttons() {
  if (ImGui::Button(tr_label("Open the demo"))) chosen_ = StartChoice{true, "", log_};
  ImGui::SameLine();
  ui_text(kUiDim, tr("a small stage with a show of one minute"));
  if (ImGui::Button(tr_label("Open a file ..."))) open_dialog();
  ImGui::SameLine();
  ui_text(kUiDim, tr("Ctrl+O, or drop a file on this window"));
  wrapped_text(kUiDim, tr("Rigs are MVR, QLC+ or TOML files. A definition of a fixture opens that fixture alone. Logs "
                          "are recorded DMX, which drives the fixtures of a rig."));
  if (log_.empty()) return;
  ImGui::Spacing();
  wrapped_text(kUiAmber, trf("The log {} plays as soon as a rig is opened.", printable_utf8(file_name(log_))));
  if (ImGui::SmallButton(tr_label("without it"))) log_.clear();
}

void StartScreen::draw_recent(const char* title, const std::vector<std::string>& paths, bool rigs) {
  if (paths.empty()) return;
  ImGui::Spacing();
  ImGui::Separator();
  ui_text(kUiAmber, title);
  ImGui::PushID(title);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string& path = paths[i];
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable("##row")) {
      std::error_code ignored;
      if (!std::filesystem::exists(path, ignored)) {
        trouble_ = trf("{}: there is no such file", printable_utf8(path));
      } else if (rigs) {
        choose_rig(path);
      } else {
        log_ = path;
      }
    }
    ImGui::SameLine(0, 0);
    ui_text(printable_utf8(file_name(path)));
    ImGui::SameLine();
    ui_text(kUiDim, printable_utf8(parent_of(path)));
    ImGui::PopID();
  }
  ImGui::PopID();
}

std::optional<StartChoice> StartScreen::draw(float scale) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float width = std::min(kColumnWidth * scale, std::max(size.x - 16, 1.0f));
  ImGui::SetNextWindowPos({(size.x - width) / 2, 8 * scale});
  ImGui::SetNextWindowSize({width, std::max(size.y - 16 * scale, 1.0f)});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (ImGui::Begin("###start", nullptr, kFlags)) {
    ui_text(kUiAmber, "Footlight");
    ImGui::Spacing();
    if (!trouble_.empty()) {
      wrapped_text(kUiRed, trouble_);
      ImGui::Spacing();
    }
    draw_buttons();
    draw_recent(tr("Recent rigs"), recent_rigs_, true);
    draw_recent(tr("Recent logs"), recent_logs_, false);
  }
  ImGui::End();
  dialog_.draw(scale, [this](const FileDialog::Chosen& chosen) { return take_files({chosen.path}); });
  return std::exchange(chosen_, std::nullopt);
}

}  // namespace footlight::tools
