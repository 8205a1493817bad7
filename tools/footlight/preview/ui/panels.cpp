#include "tools/footlight/preview/ui/panels.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string>

#include <GLFW/glfw3.h>

#include <imgui/imgui.h>

#include <fmt/format.h>

#include "tools/footlight/preview/ui/words.h"

#include "sim/core/check.h"

namespace footlight::tools {
namespace {

constexpr float kEdge = 8;  // between a panel and the edge of the stage

constexpr std::array<PanelInfo, 9> kPanels{{
    {"keys",
     tr_mark("Keys"),
     GLFW_KEY_F1,
     "F1, ?",
     tr_mark("this list"),
     {0.5f, 0.5f, 560, 620, 1},
     make_keys_panel},
    {"universes",
     tr_mark("Universes"),
     GLFW_KEY_F2,
     "F2",
     tr_mark("the levels of a universe"),
     {0, 1, 830, 430, 0.43f},
     make_universes_panel},
    {"fixtures",
     tr_mark("Fixtures"),
     GLFW_KEY_F3,
     "F3",
     tr_mark("the patch of the rig"),
     {0, 0, 560, 420, 0.54f},
     make_fixtures_panel},
    {"inspector",
     tr_mark("Inspector"),
     GLFW_KEY_F4,
     "F4",
     tr_mark("values and controls of what is selected"),
     {1, 0, 420, 640, 0.54f},
     make_inspector_panel},
    {"timeline",
     tr_mark("Timeline"),
     GLFW_KEY_F5,
     "F5",
     tr_mark("the log in time: seek, speed, a part that repeats"),
     {0.5f, 1, 900, 170, 0.3f},
     make_timeline_panel},
    {"devices",
     tr_mark("Devices"),
     GLFW_KEY_F6,
     "F6",
     tr_mark("inputs and outputs; arms outputs to real lamps"),
     {0.5f, 0.5f, 700, 540, 0.75f, true},
     make_devices_panel},
    {"library",
     tr_mark("Library"),
     GLFW_KEY_F7,
     "F7",
     tr_mark("the installed definitions: add fixtures"),
     {0.5f, 0.5f, 900, 480, 0.8f},
     make_library_panel},
    {"messages",
     tr_mark("Messages"),
     GLFW_KEY_F8,
     "F8",
     tr_mark("the last messages and errors of the window"),
     {0, 1, 560, 220, 0.4f},
     make_messages_panel},
    {"report",
     tr_mark("Report"),
     GLFW_KEY_F10,
     "F10",
     tr_mark("error and time of the picture, memory, what is left out"),
     {1, 1, 620, 420, 0.6f},
     make_report_panel},
}};

Status for_words(std::string_view words, const std::function<void(std::size_t)>& act) {
  while (!words.empty()) {
    const std::size_t comma = words.find(',');
    const std::string_view word = words.substr(0, comma);
    words = comma == std::string_view::npos ? std::string_view() : words.substr(comma + 1);
    const auto at =
        std::find_if(kPanels.begin(), kPanels.end(), [&](const PanelInfo& one) { return word == one.word; });
    if (at == kPanels.end()) {
      std::string known;
      for (const PanelInfo& one : kPanels) known += (known.empty() ? "" : ", ") + std::string(one.word);
      return fail(ErrorCode::kBadInput, "--panels {}: expected words of {}, separated by commas", word, known);
    }
    act(static_cast<std::size_t>(at - kPanels.begin()));
  }
  return {};
}

}  // namespace

std::span<const PanelInfo> panels() { return kPanels; }

std::size_t panel_of(std::string_view word) {
  const auto at = std::find_if(kPanels.begin(), kPanels.end(), [&](const PanelInfo& one) { return word == one.word; });
  FL_CHECK(at != kPanels.end());
  return static_cast<std::size_t>(at - kPanels.begin());
}

Status check_panel_words(std::string_view words) {
  return for_words(words, [](std::size_t) {});
}

UiPanels::UiPanels() : open_(kPanels.size()) {}

bool UiPanels::any_open() const {
  return std::any_of(open_.begin(), open_.end(), [](const auto& panel) { return panel != nullptr; });
}

void UiPanels::set_open(std::size_t index, bool open, UiDesk& desk) {
  if (open == is_open(index)) return;
  open_[index] = open ? kPanels[index].make(desk) : nullptr;
}

Status UiPanels::open_words(std::string_view words, UiDesk& desk) {
  return for_words(words, [&](std::size_t index) { set_open(index, true, desk); });
}

void UiPanels::draw(UiDesk& desk, const UiInput& input, float stage_width, float stage_height) {
  desk.list({});
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (!open_[i]) continue;
    const PanelInfo& info = kPanels[i];
    const float width = std::clamp(info.place.width * input.scale, 1.0f, std::max(stage_width - 2 * kEdge, 1.0f));
    const float height = std::clamp(std::min(info.place.height * input.scale, info.place.height_share * stage_height),
                                    1.0f, std::max(stage_height - 2 * kEdge, 1.0f));
    const float left = kEdge + info.place.left * std::max(stage_width - 2 * kEdge - width, 0.0f);
    const float top = kEdge + info.place.top * std::max(stage_height - 2 * kEdge - height, 0.0f);
    ImGui::SetNextWindowPos({left, top}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({width, height}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSizeConstraints({200 * input.scale, 100 * input.scale}, {1e5f, 1e5f});
    bool stays = true;
    const ImGuiWindowFlags scrolls = info.place.has_scrollbar ? ImGuiWindowFlags_AlwaysVerticalScrollbar : 0;
    if (ImGui::Begin(tr_label(info.title), &stays, ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav | scrolls)) {
      open_[i]->draw(desk, input);
    }
    ImGui::End();
    if (!stays) open_[i].reset();
  }
}

void UiPanels::step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
  if (pauses_) return;
  for (const auto& panel : open_) {
    if (panel) panel->step(levels, dt_ns, new_exposure);
  }
}

void UiPanels::restart() {
  for (const auto& panel : open_) {
    if (panel) panel->restart();
  }
}

}  // namespace footlight::tools
