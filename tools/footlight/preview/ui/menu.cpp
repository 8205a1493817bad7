#include "tools/footlight/preview/ui/menu.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/actions.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

// True: it was chosen. why_not: as a tip of an entry that is not possible.
bool draw_row(const char* label, const char* keys, bool checked, const std::string& why_not) {
  const bool chosen = ImGui::MenuItem(label, keys, checked, why_not.empty());
  if (!why_not.empty() && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) {
    ImGui::SetTooltip("%s", why_not.c_str());
  }
  return chosen;
}

void draw_rows(UiMenu menu, const UiDesk& desk, const OutputsView* outputs, std::optional<UiCall>& chosen) {
  for (const KeyRow& row : key_rows()) {
    if (row.menu != menu) continue;
    const bool checked = (row.call.action == UiAction::kHighlight && desk.highlights()) ||
                         (row.call.action == UiAction::kLocate && desk.locates()) ||
                         (row.call.action == UiAction::kHandles && desk.handles()) ||
                         (row.call.action == UiAction::kMeasure && desk.measure().on) ||
                         (row.call.action == UiAction::kFly && desk.fly().on()) ||
                         (row.call.action == UiAction::kFloorLines && desk.floor_lines());
    const std::string label = fmt::format("{}###{}", label_of(row, desk), row.keys);
    if (draw_row(label.c_str(), tr(row.keys), checked, why_not(row.call, desk, true, outputs))) chosen = row.call;
  }
  for (const CommandRow& row : command_rows()) {
    if (row.menu != menu) continue;
    const bool checked = row.call.action == UiAction::kHoldToLive && outputs->needs_hold;
    if (draw_row(tr_label(row.does), nullptr, checked, why_not(row.call, desk, true, outputs))) chosen = row.call;
  }
}

void draw_recent(const std::vector<std::string>& paths, UiAction action, std::optional<UiCall>& chosen) {
  ImGui::PushID(static_cast<int>(action));
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string name = std::filesystem::path(paths[i]).filename().string();
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::MenuItem(name.c_str())) chosen = UiCall{action, static_cast<int>(i)};
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", paths[i].c_str());
    ImGui::PopID();
  }
  ImGui::PopID();
}

std::string words_of(const ExchangeView::File& file) {
  std::string words = file.name.empty() ? file.uuid : file.name;
  if (file.bytes > 0) words += fmt::format("  {:.1f} MB", static_cast<double>(file.bytes) * 1e-6);
  return file.comment.empty() ? words : words + "  " + file.comment;
}

// The newest file first.
void draw_station(const ExchangeView::Station& station, ExchangeView& exchange) {
  const std::string title =
      station.program.empty() ? station.name : fmt::format("{} ({})", station.name, station.program);
  ui_text(station.joined ? kUiAmber : kUiDim, title);
  if (!station.trouble.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", station.trouble.c_str());
  if (!station.joined) return ui_text(kUiDim, station.trouble.empty() ? tr("  asked ...") : tr("  does not answer"));
  if (station.files.empty() && ImGui::MenuItem(tr_label("  its newest file")))
    exchange.receive = {{station.address, "", ""}};
  for (auto file = station.files.rbegin(); file != station.files.rend(); ++file) {
    ImGui::PushID(file->uuid.c_str());
    if (ImGui::MenuItem(fmt::format("  {}###file", words_of(*file)).c_str())) {
      exchange.receive = {{station.address, file->uuid, file->name}};
    }
    ImGui::PopID();
  }
}

void draw_stations(ExchangeView& exchange) {
  exchange.looks = true;
  if (!exchange.receiving.empty()) {
    ui_text(kUiAmber, trf("receiving {}", exchange.receiving));
    if (ImGui::MenuItem(tr_label("stop"))) exchange.stop_receiving = true;
    ImGui::Separator();
  }
  if (exchange.stations.empty())
    ui_text(kUiDim, exchange.trouble.empty() ? tr("looking for stations ...") : tr("no station"));
  if (!exchange.trouble.empty()) {
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
    ui_text(kUiRed, exchange.trouble);
    ImGui::PopTextWrapPos();
  }
  for (const ExchangeView::Station& station : exchange.stations) {
    ImGui::PushID(station.address.c_str());
    draw_station(station, exchange);
    ImGui::PopID();
  }
  ImGui::Separator();
  std::array<char, 256> text{};
  exchange.address_text.copy(text.data(), text.size() - 1);
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 14);
  const bool entered = ImGui::InputTextWithHint("##address", "10.0.0.7:42424", text.data(), text.size(),
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  exchange.address_text = text.data();
  ImGui::SameLine();
  if ((ImGui::Button(tr_label("add")) || entered) && !exchange.address_text.empty()) {
    exchange.add = std::exchange(exchange.address_text, {});
  }
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("A station that is not found, by its address."));
}

void draw_exchange(ExchangeView& exchange) {
  if (ImGui::BeginMenu(tr_label("Receive a rig"))) {
    draw_stations(exchange);
    ImGui::EndMenu();
  }
  if (exchange.makes) return ui_text(kUiDim, tr("making the file to share ..."));
  if (exchange.sharing.empty()) {
    if (ImGui::MenuItem(tr_label("Share this rig on the network"))) exchange.share = true;
    return;
  }
  if (ImGui::MenuItem(tr_label("Share this rig anew"))) exchange.share = true;
  if (ImGui::MenuItem(tr_label("Stop sharing"))) exchange.stop_sharing = true;
  ui_text(kUiDim, trf("shared: {}", exchange.sharing));
}

bool has_recent(const UiDesk& desk) { return !desk.recent_rigs().empty() || !desk.recent_logs().empty(); }

void draw_file(const UiDesk& desk, ExchangeView* exchange, std::optional<UiCall>& chosen) {
  draw_rows(UiMenu::kFile, desk, nullptr, chosen);
  if (exchange != nullptr) ImGui::Separator();
  if (exchange != nullptr) draw_exchange(*exchange);
  if (!has_recent(desk)) return;
  ImGui::Separator();
  ui_text(kUiDim, tr("Open again"));
  draw_recent(desk.recent_rigs(), UiAction::kOpenRecent, chosen);
  if (!desk.recent_rigs().empty() && !desk.recent_logs().empty()) ImGui::Separator();
  draw_recent(desk.recent_logs(), UiAction::kOpenRecentLog, chosen);
}

void draw_panel_rows(const UiPanels& open, std::optional<UiCall>& chosen) {
  for (std::size_t i = 0; i < panels().size(); ++i) {
    if (ImGui::MenuItem(tr_label(panels()[i].title), tr(panels()[i].key_text), open.is_open(i))) {
      chosen = UiCall{UiAction::kPanel, static_cast<int>(i)};
    }
  }
}

struct Menu {
  const char* title;
  bool is_there;
  std::function<void()> draw;
};

// All menus fit beside each other in the side panel: with a log and outputs they are too wide otherwise. ImGui has
// twice the spacing between two menus.
ImVec2 menu_spacing(std::span<const Menu> menus) {
  float text_px = 0;
  int count = 0;
  for (const Menu& menu : menus) {
    if (!menu.is_there) continue;
    text_px += ImGui::CalcTextSize(menu.title, nullptr, true).x;
    ++count;
  }
  const ImVec2 usual = ImGui::GetStyle().ItemSpacing;
  const float spare_px = ImGui::GetContentRegionAvail().x - text_px;
  return {std::clamp(spare_px / static_cast<float>(2 * count), 1.0f, usual.x), usual.y};
}

}  // namespace

std::optional<UiCall> draw_menu(const UiDesk& desk, const UiPanels& open, bool has_log, const OutputsView* outputs,
                                ExchangeView* exchange) {
  std::optional<UiCall> chosen;
  const auto rows = [&](UiMenu menu) { return [&, menu] { draw_rows(menu, desk, outputs, chosen); }; };
  const std::array<Menu, 6> menus{{{tr_label("File"), true, [&] { draw_file(desk, exchange, chosen); }},
                                   {tr_label("Panels"), true, [&] { draw_panel_rows(open, chosen); }},
                                   {tr_label("Edit"), true, rows(UiMenu::kEdit)},
                                   {tr_label("View"), true, rows(UiMenu::kView)},
                                   {tr_label("Play"), has_log, rows(UiMenu::kPlayback)},
                                   {tr_label("Outputs"), outputs != nullptr, rows(UiMenu::kOutputs)}}};
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, menu_spacing(menus));
  for (const Menu& menu : menus) {
    if (!menu.is_there || !ImGui::BeginMenu(menu.title)) continue;
    menu.draw();
    ImGui::EndMenu();
  }
  ImGui::PopStyleVar();
  return chosen;
}

}  // namespace footlight::tools
