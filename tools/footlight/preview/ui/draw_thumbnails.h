// Small pictures of the show in panels.
#pragma once

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/thumbnails.h"
#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {

// A picture from low to high. whole: with all its pixels, which is four times the work; else half as many a side.
void draw_thumbnail(ImDrawList& draw, const Thumbnails::Picture& picture, ImVec2 low, ImVec2 high, bool whole);

// A row of pictures over the time of the log, from left to right over `size`: as many as fit beside each other, each
// where its time is.
void draw_thumbnails(ImDrawList& draw, const Thumbnails& thumbnails, DurationNs duration_ns, ImVec2 low, ImVec2 size);

// In a tooltip: the picture nearest to this time and its own time, if there is one.
void draw_thumbnail_tip(const Thumbnails& thumbnails, TimeNs at_ns, DurationNs duration_ns, float scale);

}  // namespace footlight::tools
