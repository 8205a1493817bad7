#include "tools/footlight/preview/ui/live_band.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>  // where windows have their titles

#include "tools/footlight/preview/ui/transport.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 255);
constexpr ImU32 kLockColour = IM_COL32(0, 114, 178, 255);  // the blue of Okabe and Ito
constexpr ImU32 kBlack = IM_COL32(0, 0, 0, 255);

constexpr float kLowLines = 4;  // a window without a title that is lower than this is covered by no tag

// What tags leave free: titles of panels and of dialogs, and lines over the stage, which have buttons.
std::vector<ImRect> kept_free() {
  std::vector<ImRect> places;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    constexpr ImGuiWindowFlags kOthers = ImGuiWindowFlags_ChildWindow | ImGuiWindowFlags_Tooltip;
    if (!window->Active || window->Hidden || (window->Flags & kOthers) != 0) continue;
    const bool titled = (window->Flags & ImGuiWindowFlags_NoTitleBar) == 0;
    if (titled) {
      places.push_back(window->TitleBarRect());
    } else if ((window->Flags & ImGuiWindowFlags_NoInputs) == 0 &&
               window->Size.y < kLowLines * ImGui::GetFontSize()) {
      places.push_back(window->Rect());
    }
  }
  return places;
}

// Where a tag of this size goes: the place nearest to the middle in the first row with room. Without any it covers what
// is in the middle, since it must be seen.
ImVec2 tag_place(ImVec2 size, float stage_width, float y) {
  const std::vector<ImRect> taken = kept_free();
  const float middle = (stage_width - size.x) / 2;
  const float step = ImGui::GetFontSize() / 2;
  for (float top = y; top + size.y < ImGui::GetIO().DisplaySize.y / 2; top += step) {
    std::vector<float> lefts{middle};
    for (const ImRect& one : taken) {
      if (one.Max.y <= top || one.Min.y >= top + size.y) continue;
      lefts.push_back(one.Min.x - size.x - 1);
      lefts.push_back(one.Max.x + 1);
    }
    std::optional<float> best;
    for (const float left : lefts) {
      const ImRect place({left, top}, {left + size.x, top + size.y});
      if (left != middle && (left < 0 || place.Max.x > stage_width)) continue;
      const bool free =
          std::none_of(taken.begin(), taken.end(), [&](const ImRect& one) { return one.Overlaps(place); });
      if (free && (!best || std::abs(left - middle) < std::abs(*best - middle))) best = left;
    }
    if (best) return {*best, top};
  }
  return {middle, y};
}

// Text on a ground, at most as wide as the stage, not above y. Returns where it ends.
float draw_tag(const std::string& words, float size, float stage_width, float y, ImU32 ground, ImU32 colour) {
  ImFont* font = ImGui::GetFont();
  const float room = std::max(stage_width, 1.0f);
  const float wide = font->CalcTextSizeA(size, 1e5f, 0, words.c_str()).x + size * 0.8f;
  if (wide > room) size = std::max(size * room / wide, 1.0f);
  const ImVec2 needed = font->CalcTextSizeA(size, 1e5f, 0, words.c_str());
  const float pad = size * 0.4f;
  const ImVec2 low = tag_place({needed.x + 2 * pad, needed.y + pad}, room, y);
  const ImVec2 high{low.x + needed.x + 2 * pad, low.y + needed.y + pad};
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  draw.AddRectFilled(low, high, ground);
  draw.AddText(font, size, {low.x + pad, low.y + pad / 2}, colour, words.c_str());
  return high.y;
}

}  // namespace

float draw_live_band(const OutputsView& outputs, float stage_width, float scale) {
  const std::string words = live_words(outputs);
  if (words.empty()) return 0;
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const bool dark = outputs.darkness != Darkness::kNone;
  const float width = (dark ? 8.0f : 4.0f) * scale;
  const auto frame = [&](float inset, float thick, ImU32 colour) {
    draw.AddRect({inset + thick / 2, inset + thick / 2}, {size.x - inset - thick / 2, size.y - inset - thick / 2},
                 colour, 0, 0, thick);
  };
  if (outputs.live_count() > 0) {
    frame(0, width, kLiveColour);
    if (dark) frame(0, width / 2, kBlack);  // black and red: not to be taken for LIVE
  }
  const float text = ImGui::GetFontSize();
  if (!dark) return draw_tag(words, text * 1.25f, stage_width, 0, kLiveColour, kWhite);
  const float below = draw_tag(words, text * 2, stage_width, 0, kBlack, kLiveColour);
  return draw_tag(blackout_words(outputs), text, stage_width, below, kBlack, kWhite);
}

float draw_input_tags(const InputsView& inputs, float stage_width, float y) {
  const float text = ImGui::GetFontSize();
  if (const std::string dark = hand_blackout_words(inputs); !dark.empty()) {
    y = draw_tag(dark, text * 1.25f, stage_width, y, kBlack, kMadeUpColour);
    y = draw_tag(hand_blackout_end(), text, stage_width, y, kBlack, kWhite);
  }
  const std::string made_up = made_up_words(inputs);
  return made_up.empty() ? y : draw_tag(made_up, text * 1.25f, stage_width, y, kMadeUpColour, kBlack);
}

float draw_lock(float stage_width, float scale, float y) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float inset = 8 * scale;  // the frame of outputs is as thick
  const float thick = 3 * scale;
  const float middle = inset + thick / 2;
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  draw.AddRect({middle, middle}, {size.x - middle, size.y - middle}, kLockColour, 0, 0, thick);
  const float text = ImGui::GetFontSize() * 1.25f;
  return draw_tag(tr("LOCKED: Ctrl+Shift+L unlocks"), text, stage_width, y, kLockColour, kWhite);
}

void draw_recording_mark(DurationNs elapsed_ns, float scale) {
  const std::string words = trf("REC {}", time_text(elapsed_ns));
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  const float size = ImGui::GetFontSize();
  const float pad = size * 0.4f;
  const ImVec2 needed = ImGui::CalcTextSize(words.c_str());
  const ImVec2 low{8 * scale, 8 * scale};
  const ImVec2 high{low.x + needed.x + size + 3 * pad, low.y + needed.y + 2 * pad};
  draw.AddRectFilled(low, high, kBlack);
  draw.AddCircleFilled({low.x + pad + size / 2, (low.y + high.y) / 2}, size * 0.4f, kLiveColour);
  draw.AddText({low.x + size + 2 * pad, low.y + pad}, kWhite, words.c_str());
}

}  // namespace footlight::tools
