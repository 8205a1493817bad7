#include "tools/footlight/preview/ui/draw_handles.h"

#include <algorithm>
#include <cmath>

namespace footlight::tools {
namespace {

constexpr std::size_t kGhostsMax = 100;
constexpr double kGuideM = 200;  // of the line along which a fixture is dragged, to each side

constexpr ImU32 kShade = IM_COL32(0, 0, 0, 150);
constexpr ImU32 kAimColour = IM_COL32(255, 214, 90, 255);
constexpr ImU32 kGhost = IM_COL32(255, 255, 255, 190);

ImVec2 vec(glm::dvec2 at) { return {static_cast<float>(at.x), static_cast<float>(at.y)}; }

ImU32 colour_of(HandlePart part) {
  switch (part) {
    case HandlePart::kX: return IM_COL32(240, 84, 80, 255);
    case HandlePart::kY: return IM_COL32(104, 204, 104, 255);
    case HandlePart::kZ: return IM_COL32(94, 150, 255, 255);
    case HandlePart::kFloor: return IM_COL32(235, 235, 240, 255);
    case HandlePart::kAim:
    case HandlePart::kNone: break;
  }
  return kAimColour;
}

ImU32 with_alpha(ImU32 colour, ImU32 alpha) { return (colour & ~IM_COL32_A_MASK) | (alpha << IM_COL32_A_SHIFT); }

void draw_arrow(ImDrawList& draw, const StageHandles::Arrow& arrow, bool strong, float scale) {
  const glm::dvec2 way = arrow.to - arrow.from;
  const double length = glm::length(way);
  if (arrow.along || !(length > 1)) return;
  const ImU32 colour = colour_of(arrow.part);
  const glm::dvec2 ahead = way / length;
  const glm::dvec2 aside(-ahead.y, ahead.x);
  const double head = std::min(11.0 * static_cast<double>(scale), length);
  const glm::dvec2 neck = arrow.to - ahead * head;
  const float width = (strong ? 4.0f : 2.5f) * scale;
  draw.AddLine(vec(arrow.from), vec(neck), kShade, width + 2 * scale);
  draw.AddLine(vec(arrow.from), vec(neck), colour, width);
  draw.AddTriangleFilled(vec(arrow.to), vec(neck + aside * (head * 0.45)), vec(neck - aside * (head * 0.45)), colour);
  const char letter[2] = {arrow.part == HandlePart::kX ? 'X' : arrow.part == HandlePart::kY ? 'Y' : 'Z', '\0'};
  const ImVec2 size = ImGui::CalcTextSize(letter);
  const ImVec2 at = vec(arrow.to + ahead * (0.8 * static_cast<double>(size.y)));
  draw.AddText({at.x - size.x / 2 + 1, at.y - size.y / 2 + 1}, kShade, letter);
  draw.AddText({at.x - size.x / 2, at.y - size.y / 2}, colour, letter);
}

// The box of a fixture, moved.
void draw_ghost(ImDrawList& draw, const StagePlace& place, const StagePick& pick, const fixtures::Rig& rig, int fixture,
                const glm::dvec3& by_m, float scale) {
  const StagePick::Box& box = pick.box_of(fixture);
  const glm::dmat4 pose = fixtures::pose_of(rig.fixtures[static_cast<std::size_t>(fixture)]);
  const auto corner = [&](int number) {
    const glm::dvec4 at((number & 1) != 0 ? box.high_m.x : box.low_m.x, (number & 2) != 0 ? box.high_m.y : box.low_m.y,
                        (number & 4) != 0 ? box.high_m.z : box.low_m.z, 1);
    return glm::dvec3(pose * at) + by_m;
  };
  for (int from = 0; from < 8; ++from) {
    for (int bit = 1; bit < 8; bit *= 2) {
      if ((from & bit) == 0) draw_stage_line(draw, place, corner(from), corner(from | bit), kGhost, 1.2f * scale);
    }
  }
}

void draw_aim(ImDrawList& draw, const StageHandles& handles, const StagePlace& place, bool strong, float scale) {
  const auto& aim = handles.aim_shape();
  if (!aim) return;
  draw_stage_line(draw, place, aim->beam.from_m, aim->point_m, with_alpha(kAimColour, strong ? 220 : 120),
                  1.2f * scale);
  const ImVec2 at = vec(aim->point);
  const float radius = (strong ? 9.0f : 7.0f) * scale;
  draw.AddCircle(at, radius, kShade, 0, 5 * scale);
  draw.AddCircle(at, radius, kAimColour, 0, 2 * scale);
  draw.AddCircleFilled(at, 2.2f * scale, kAimColour);
}

void draw_drag(ImDrawList& draw, const StageHandles& handles, const UiDesk& desk, const StagePick& pick,
               const StagePlace& place, float scale) {
  const HandlePart part = handles.dragged();
  if (part == HandlePart::kNone || part == HandlePart::kAim || !handles.shape()) return;
  const glm::dvec3 origin_m = handles.shape()->origin_m;
  for (int axis = 0; axis < 3; ++axis) {
    const bool along =
        part == HandlePart::kFloor ? axis < 2 : static_cast<int>(part) - static_cast<int>(HandlePart::kX) == axis;
    if (!along) continue;
    glm::dvec3 way(0);
    way[axis] = kGuideM;
    const auto own = static_cast<HandlePart>(static_cast<int>(HandlePart::kX) + axis);
    draw_stage_line(draw, place, origin_m - way, origin_m + way, with_alpha(colour_of(own), 120), scale);
  }
  const auto& which = desk.state().selection.fixtures;
  for (std::size_t i = 0; i < std::min(which.size(), kGhostsMax); ++i) {
    draw_ghost(draw, place, pick, desk.rig(), which[i], handles.moved_m(), scale);
  }
}

}  // namespace

void draw_stage_line(ImDrawList& draw, const StagePlace& place, const glm::dvec3& from_m, const glm::dvec3& to_m,
                     unsigned colour, float width) {
  if (const auto line = projected_line(place, from_m, to_m))
    draw.AddLine(vec(line->first), vec(line->second), colour, width);
}

void draw_stage_text(ImDrawList& draw, const StagePlace& place, glm::dvec2 at, const std::string& words, float scale) {
  if (words.empty()) return;
  const ImVec2 size = ImGui::CalcTextSize(words.c_str());
  const float edge = 4 * scale;
  const auto within = [&](double value, float needed, double from, double to) {
    const double least = from + static_cast<double>(edge);
    return static_cast<float>(std::clamp(value, least, std::max(to - static_cast<double>(needed + edge), least)));
  };
  const glm::dvec2 end = place.end();
  const ImVec2 low{within(at.x + 18.0 * static_cast<double>(scale), size.x, place.origin.x, end.x),
                   within(at.y + 10.0 * static_cast<double>(scale), size.y, place.origin.y, end.y)};
  draw.AddRectFilled({low.x - edge, low.y - edge / 2}, {low.x + size.x + edge, low.y + size.y + edge / 2},
                     IM_COL32(12, 13, 16, 215), 3 * scale);
  draw.AddText(low, IM_COL32(240, 240, 240, 255), words.c_str());
}

void draw_handles(const StageHandles& handles, const UiDesk& desk, const StagePick& pick, const StagePlace& place,
                  float scale) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  draw.PushClipRect(vec(place.origin), vec(place.end()));
  const HandlePart strong = handles.dragging() ? handles.dragged() : handles.hovered();
  const auto shows = [&](HandlePart part) { return !handles.dragging() || strong == part; };
  draw_drag(draw, handles, desk, pick, place, scale);
  if (shows(HandlePart::kAim)) draw_aim(draw, handles, place, strong == HandlePart::kAim, scale);
  glm::dvec2 beside(0);
  if (const auto& shape = handles.shape(); shape && strong != HandlePart::kAim) {
    if (shape->floor && shows(HandlePart::kFloor)) {
      const auto& corners = *shape->floor;
      const ImU32 colour = colour_of(HandlePart::kFloor);
      draw.AddQuadFilled(vec(corners[0]), vec(corners[1]), vec(corners[2]), vec(corners[3]),
                         with_alpha(colour, strong == HandlePart::kFloor ? 150 : 70));
      draw.AddQuad(vec(corners[0]), vec(corners[1]), vec(corners[2]), vec(corners[3]), colour, 1.5f * scale);
    }
    for (const auto& arrow : shape->arrows) {
      if (shows(arrow.part)) draw_arrow(draw, arrow, strong == arrow.part, scale);
      if (strong == arrow.part) beside = arrow.to;
    }
    if (strong == HandlePart::kFloor) beside = shape->origin;
    draw.AddCircleFilled(vec(shape->origin), 3 * scale, IM_COL32(235, 235, 240, 255));
  }
  if (strong == HandlePart::kAim && handles.aim_shape()) beside = handles.aim_shape()->point;
  draw.PopClipRect();
  if (strong == HandlePart::kNone) return;
  draw_stage_text(*ImGui::GetForegroundDrawList(), place, beside, handles.text(), scale);  // also over panels
}

}  // namespace footlight::tools
