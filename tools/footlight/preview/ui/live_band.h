// What lies over everything else: the frame of armed outputs, and tags that say what the stage does not show. Dear
// ImGui only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

// Places of tags in one picture, after all panels of it: in the middle of the stage's upper edge, else in the first row
// where no panel and no other tag is. If panels leave no room, their titles and lines with buttons stay free.
class StageTags {
 public:
  // Of the part of the window beside the side panel, in units of the user interface.
  explicit StageTags(float stage_width) : stage_width_(stage_width) {}

  struct Tag {
    std::string words;
    std::string more;  // a line below, in the size of text; may be empty
    float size = 0;    // of words
    std::uint32_t ground = 0;
    std::uint32_t colour = 0;
  };
  void draw(const Tag& tag);
  // Where the lowest one at the upper edge ends; 0: there is none.
  [[nodiscard]] float bottom() const;

 private:
  struct Place {
    float left, top, right, bottom;
  };
  float stage_width_;
  std::vector<Place> taken_;  // by tags of this picture
};

void draw_live_band(const OutputsView& outputs, StageTags& tags, float scale);
void draw_input_tags(const InputsView& inputs, StageTags& tags);
// That the window is locked, with the key that unlocks it: a tag, and a frame beside that of armed outputs.
void draw_lock(StageTags& tags, float scale);
// At the top left: that what the fixtures get is recorded, and for how long.
void draw_recording_mark(DurationNs elapsed_ns, float scale);

}  // namespace footlight::tools
