#include "tools/footlight/preview/ui/live_band.h"

#include <algorithm>
#include <string>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/transport.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 255);
constexpr ImU32 kBlack = IM_COL32(0, 0, 0, 255);

// Text of a size on a ground, around x, below y. Returns where it ends.
float draw_tag(ImDrawList& draw, const std::string& words, float size, float x, float y, ImU32 ground, ImU32 colour) {
  ImFont* font = ImGui::GetFont();
  const ImVec2 needed = font->CalcTextSizeA(size, 1e5f, 0, words.c_str());
  const float pad = size * 0.4f;
  const ImVec2 low{x - needed.x / 2 - pad, y};
  const ImVec2 high{x + needed.x / 2 + pad, y + needed.y + pad};
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
  const float middle = std::max(stage_width, 1.0f) / 2;
  if (!dark) return draw_tag(draw, words, text * 1.25f, middle, 0, kLiveColour, kWhite);
  const float below = draw_tag(draw, words, text * 2, middle, 0, kBlack, kLiveColour);
  return draw_tag(draw, blackout_words(outputs), text, middle, below, kBlack, kWhite);
}

void draw_made_up_tag(const InputsView& made_up, float stage_width, float y) {
  const std::string words = made_up_words(made_up);
  if (words.empty()) return;
  draw_tag(*ImGui::GetForegroundDrawList(), words, ImGui::GetFontSize() * 1.25f, std::max(stage_width, 1.0f) / 2, y,
           kMadeUpColour, kBlack);
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
