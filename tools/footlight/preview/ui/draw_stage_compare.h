// What is written over A and B on the stage, and over their difference. Dear ImGui only.
#pragma once

#include <optional>
#include <string>

#include "tools/footlight/preview/picture_difference.h"
#include "tools/footlight/preview/ui/level_comparison.h"

namespace footlight::tools {

// The top edge of a picture, in units of Dear ImGui.
struct CompareTagPlace {
  float x = 0;
  float y = 0;
  float width = 0;
};

// "A  monday.dmxlog  1:23.4", "B  now".
[[nodiscard]] std::string compare_words(const LevelComparison& compared, bool a);
// "A - B: largest 12.3 %, mean 0.41 %"; nothing: there is none yet.
[[nodiscard]] std::string difference_words(const std::optional<PictureDifference>& difference);

void draw_compare_tag(const LevelComparison& compared, bool a, const CompareTagPlace& place, float scale);
// With the colours of differences.
void draw_difference_tag(const std::optional<PictureDifference>& difference, const CompareTagPlace& place,
                         float scale);

}  // namespace footlight::tools
