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

// What tags leave free. whole: panels and dialogs; else their titles only. Lines over the stage have buttons.
std::vector<ImRect> kept_free(bool whole) {
  std::vector<ImRect> places;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    constexpr ImGuiWindowFlags kOthers = ImGuiWindowFlags_ChildWindow | ImGuiWindowFlags_Tooltip;
    if (!window->Active || window->Hidden || (window->Flags & kOthers) != 0) continue;
    if (window->IsFallbackWindow) continue;  // Dear ImGui's own, which is not drawn
    if ((window->Flags & ImGuiWindowFlags_NoTitleBar) == 0) {
      places.push_back(whole ? window->Rect() : window->TitleBarRect());
    } else if ((window->Flags & ImGuiWindowFlags_NoInputs) == 0 &&
               window->Size.y < kLowLines * ImGui::GetFontSize()) {
      places.push_back(window->Rect());
    }
  }
  return places;
}

// The place nearest to the middle in the first row with room.
std::optional<ImVec2> free_place(ImVec2 size, float stage_width, const std::vector<ImRect>& taken) {
  const float middle = (stage_width - size.x) / 2;
  const float step = ImGui::GetFontSize() / 2;
  for (float top = 0; top + size.y < ImGui::GetIO().DisplaySize.y; top += step) {
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
    if (best) return ImVec2(*best, top);
  }
  return std::nullopt;
}

}  // namespace

// At most as wide as the stage.
void StageTags::draw(const Tag& tag) {
  ImFont* font = ImGui::GetFont();
  const float room = std::max(stage_width_, 1.0f);
  const auto fitting = [&](const std::string& words, float size) {
    const float wide = font->CalcTextSizeA(size, 1e5f, 0, words.c_str()).x + size * 0.8f;
    return wide > room ? std::max(size * room / wide, 1.0f) : size;
  };
  const float size = fitting(tag.words, tag.size);
  const float small = fitting(tag.more, ImGui::GetFontSize());
  const ImVec2 words = font->CalcTextSizeA(size, 1e5f, 0, tag.words.c_str());
  const ImVec2 more = tag.more.empty() ? ImVec2(0, 0) : font->CalcTextSizeA(small, 1e5f, 0, tag.more.c_str());
  const float pad = size * 0.4f;
  const ImVec2 needed(std::max(words.x, more.x) + 2 * pad, words.y + more.y + pad);
  std::optional<ImVec2> found;
  for (const bool whole : {true, false}) {
    std::vector<ImRect> taken = kept_free(whole);
    for (const Place& one : taken_) taken.emplace_back(one.left, one.top, one.right, one.bottom);
    if (!found) found = free_place(needed, room, taken);
  }
  const ImVec2 low = found.value_or(ImVec2((room - needed.x) / 2, bottom()));  // it must be seen
  const ImVec2 high(low.x + needed.x, low.y + needed.y);
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  draw.AddRectFilled(low, high, tag.ground);
  draw.AddText(font, size, {(low.x + high.x - words.x) / 2, low.y + pad / 2}, tag.colour, tag.words.c_str());
  if (!tag.more.empty()) {
    draw.AddText(font, small, {(low.x + high.x - more.x) / 2, low.y + pad / 2 + words.y}, kWhite, tag.more.c_str());
  }
  taken_.push_back({low.x, low.y, high.x, high.y});
}

float StageTags::bottom() const {
  float lowest = 0;
  for (const Place& one : taken_) {
    if (one.top <= lowest) lowest = std::max(lowest, one.bottom);
  }
  return lowest;
}

void draw_live_band(const OutputsView& outputs, StageTags& tags, float scale) {
  const std::string words = live_words(outputs);
  if (words.empty()) return;
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
  if (dark) {
    tags.draw({words, blackout_words(outputs), text * 2, kBlack, kLiveColour});
  } else {
    tags.draw({words, "", text * 1.25f, kLiveColour, kWhite});
  }
}

void draw_input_tags(const InputsView& inputs, StageTags& tags) {
  const float text = ImGui::GetFontSize() * 1.25f;
  if (const std::string dark = hand_blackout_words(inputs); !dark.empty()) {
    tags.draw({dark, hand_blackout_end(), text, kBlack, kMadeUpColour});
  }
  if (const std::string made_up = made_up_words(inputs); !made_up.empty()) {
    tags.draw({made_up, "", text, kMadeUpColour, kBlack});
  }
}

void draw_lock(StageTags& tags, float scale) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float thick = 2 * scale;
  const float middle = 4 * scale + thick / 2;  // inside the frame of outputs, and outside of panels
  ImDrawList& draw = *ImGui::GetForegroundDrawList();
  draw.AddRect({middle, middle}, {size.x - middle, size.y - middle}, kLockColour, 0, 0, thick);
  tags.draw({tr("LOCKED: Ctrl+Shift+L unlocks"), "", ImGui::GetFontSize() * 1.25f, kLockColour, kWhite});
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
