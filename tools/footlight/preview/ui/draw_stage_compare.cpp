#include "tools/footlight/preview/ui/draw_stage_compare.h"

#include <algorithm>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr ImU32 kGround = IM_COL32(0, 0, 0, 190);
constexpr ImU32 kText = IM_COL32(255, 255, 255, 255);

// At the right end of the edge. Returns the place below the text.
ImVec2 draw_words(const std::string& words, const CompareTagPlace& place, float scale, float more) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const float pad = 5 * scale;
  const ImVec2 needed = ImGui::CalcTextSize(words.c_str());
  const float left = std::max(place.x + place.width - needed.x - 4 * pad, place.x);
  const ImVec2 low{left + pad, place.y + 2 * pad};
  draw.AddRectFilled(low, {low.x + needed.x + 2 * pad, low.y + needed.y + 2 * pad + more}, kGround, 2 * scale);
  draw.AddText({low.x + pad, low.y + pad}, kText, words.c_str());
  return {low.x + pad, low.y + pad + needed.y};
}

}  // namespace

std::string compare_words(const LevelComparison& compared, bool a) {
  const std::optional<KeptLevels>& kept = a ? compared.a : compared.b;
  const char* const side = a ? "A" : "B";
  if (!kept) return fmt::format("{}  {}", side, tr("now"));
  return kept->log.empty() ? fmt::format("{}  {}", side, kept->when)
                           : fmt::format("{}  {}  {}", side, kept->log, kept->when);
}

std::string difference_words(const std::optional<PictureDifference>& difference) {
  if (!difference) return tr("A - B: not yet computed");
  return trf("A - B: largest {:.1f} %, mean {:.2f} %", 100 * difference->largest, 100 * difference->mean);
}

void draw_compare_tag(const LevelComparison& compared, bool a, const CompareTagPlace& place, float scale) {
  (void)draw_words(compare_words(compared, a), place, scale, 0);
}

void draw_difference_tag(const std::optional<PictureDifference>& difference, const CompareTagPlace& place,
                         float scale) {
  constexpr int kParts = 64;
  const float bar = 8 * scale;
  const float line = ImGui::GetTextLineHeight();
  const std::string words = difference_words(difference);
  const float width = ImGui::CalcTextSize(words.c_str()).x;
  const ImVec2 low = draw_words(words, place, scale, bar + line + 6 * scale);
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const float top = low.y + 4 * scale;
  const auto x_of = [&](double share) { return low.x + static_cast<float>(share) * width; };
  for (int i = 0; i < kParts; ++i) {
    const double share = (i + 0.5) / kParts;
    const DifferenceColour colour = colour_of_difference(share * share);
    draw.AddRectFilled({x_of(share - 0.5 / kParts), top}, {x_of(share + 0.5 / kParts), top + bar},
                       ImGui::GetColorU32({colour.r, colour.g, colour.b, 1}));
  }
  // The bar goes by the square root, as the colours do.
  for (const auto& [share, text] : {std::pair{0.0, "0"}, {0.2, "4 %"}, {0.5, "25 %"}, {1.0, "100 %"}}) {
    const float wide = ImGui::CalcTextSize(text).x;
    draw.AddText({std::clamp(x_of(share) - wide / 2, low.x, low.x + width - wide), top + bar}, kText, text);
  }
}

}  // namespace footlight::tools
