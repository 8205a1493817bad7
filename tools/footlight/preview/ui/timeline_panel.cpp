// The log in time: how bright the rig is over it, where it plays, how fast, which part repeats, and its markers.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/draw_thumbnails.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/pick_colour.h"
#include "tools/footlight/preview/ui/transport.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

class TimelinePanel final : public Panel {
 public:
  void draw(UiDesk& desk, const UiInput& input) override {
    if (input.transport == nullptr) {
      ui_text(kUiDim,
              tr("No log plays: the rig follows live inputs or faders. `footlight preview RIG --log LOG` plays one."));
      return;
    }
    draw_controls(*input.transport, input.scale);
    draw_markers(desk, *input.transport);
    draw_curve(*input.transport, input);
    draw_marker_menu(desk);
  }

 private:
  static void draw_controls(Transport& transport, float scale) {
    if (ImGui::Button(transport.playing ? tr_label("pause", "play") : tr_label("play"), {64 * scale, 0}))
      transport.playing = !transport.playing;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(84 * scale);
    if (ImGui::BeginCombo("##speed", fmt::format("x {}", transport.speed).c_str())) {
      for (const double speed : kSpeeds) {
        if (ImGui::Selectable(fmt::format("x {}", speed).c_str(), speed == transport.speed)) transport.speed = speed;
      }
      ImGui::EndCombo();
    }
    ui_same_line_for(tr_label("repeat"), true);
    ImGui::Checkbox(tr_label("repeat"), &transport.repeats);
    ui_same_line_for(tr_label("from here"));
    if (ImGui::Button(tr_label("from here"))) transport.repeat_from(transport.now_ns);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("The part that repeats begins at this time."));
    ui_same_line_for(tr_label("to here"));
    if (ImGui::Button(tr_label("to here"))) transport.repeat_to(transport.now_ns);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("The part that repeats ends at this time."));
    if (transport.from_ns || transport.to_ns) {
      ui_same_line_for(tr_label("whole log"));
      if (ImGui::Button(tr_label("whole log"))) transport.repeat_all();
    }
    const std::string times = trf("{} of {}", time_text(transport.now_ns), time_text(transport.duration_ns));
    ui_same_line_for(times.c_str());
    ui_text(times);
    if (transport.from_ns || transport.to_ns) {
      const std::string part = trf("repeats {} to {}", time_text(transport.from_ns.value_or(0)),
                                   time_text(transport.to_ns.value_or(transport.duration_ns)));
      ui_same_line_for(part.c_str());
      ui_text(kUiAmber, part);
    }
  }

  // A row of names above the curve, each where its time is and as long as there is room. A click goes there.
  void draw_markers(const UiDesk& desk, Transport& transport) {
    const Markers& markers = desk.state().markers;
    if (markers.empty()) return;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = std::max(ImGui::GetContentRegionAvail().x, 16.0f);
    const float height = ImGui::GetTextLineHeight();
    const double length_ns = static_cast<double>(std::max<DurationNs>(transport.duration_ns, 1));
    const auto x_of = [&](TimeNs time_ns) {
      return at.x + static_cast<float>(std::clamp(static_cast<double>(time_ns) / length_ns, 0.0, 1.0)) * width;
    };
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const ImU32 amber = ImGui::GetColorU32(kUiAmber);
    for (std::size_t i = 0; i < markers.size(); ++i) {
      const float left = x_of(markers[i].at_ns);
      const float next = i + 1 < markers.size() ? x_of(markers[i + 1].at_ns) : at.x + width;
      const float tip = height * 0.35f;
      // At the right end there is no room for a name: it stands on the left.
      const float needed = ImGui::CalcTextSize(markers[i].name.c_str()).x + 2 * tip;
      const bool last = i + 1 == markers.size() && next - left < needed;
      draw->AddTriangleFilled({left - tip, at.y + height * 0.4f}, {left + tip, at.y + height * 0.4f},
                              {left, at.y + height}, amber);
      const ImVec2 low{last ? std::max(left - needed, at.x) : left + tip, at.y};
      const ImVec2 high{last ? left - tip : std::max(next - 2 * tip, low.x), at.y + height};
      draw->PushClipRect(low, high, true);
      draw->AddText(low, amber, markers[i].name.c_str());
      draw->PopClipRect();
      const float from = std::min(low.x, left - tip);
      const float to = std::max(std::min(high.x, low.x + needed), left + tip);
      ImGui::SetCursorScreenPos({from, at.y});
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::InvisibleButton("marker", {std::max(to - from, 1.0f), height})) transport.seek_ns = markers[i].at_ns;
      if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip(
            "%s", trf("{} at {}; the right button names or deletes it", markers[i].name, time_text(markers[i].at_ns))
                      .c_str());
        if (ImGui::IsMouseReleased(ImGuiMouseButton_Right)) ask_about(markers[i], i);
      }
      ImGui::PopID();
    }
    ImGui::SetCursorScreenPos({at.x, at.y + height});
    ImGui::Dummy({width, 2});
  }

  void ask_about(const Marker& marker, std::size_t index) {
    asked_ = index;
    asked_name_ = marker.name;
    text_.fill(0);
    marker.name.copy(text_.data(), text_.size() - 1);
    trouble_.clear();
    opens_ = true;
  }

  // The name of one marker, and a button that deletes it.
  void draw_marker_menu(UiDesk& desk) {
    constexpr const char* kMenu = "marker";
    const bool begins = std::exchange(opens_, false);
    if (begins) ImGui::OpenPopup(kMenu);
    if (!ImGui::BeginPopup(kMenu)) return;
    const Markers& markers = desk.state().markers;
    // After an undo by a key the index may be that of another one.
    if (asked_ >= markers.size() || markers[asked_].name != asked_name_) {
      ImGui::CloseCurrentPopup();
      ImGui::EndPopup();
      return;
    }
    if (begins) ImGui::SetKeyboardFocusHere();
    constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll;
    const bool entered = ImGui::InputText(tr_label("name"), text_.data(), text_.size(), kFlags);
    if (entered) {
      const Status named = desk.rename_marker(asked_, text_.data());
      trouble_ = named ? "" : tr_known(named.error().message);
      if (named) ImGui::CloseCurrentPopup();
    }
    if (!trouble_.empty()) ui_text(kUiRed, trouble_);
    if (ImGui::Button(tr_label("delete"))) {
      desk.remove_marker(asked_);
      ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
  }

  // Time runs from left to right; a click or a drag seeks.
  static void draw_curve(Transport& transport, const UiInput& input) {
    const LightCurve* curve = input.curve;
    const LightStrips* strips = input.strips;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const ImVec2 size{std::max(room.x, 16.0f), std::max(room.y - ImGui::GetTextLineHeightWithSpacing(), 16.0f)};
    const double length_ns = static_cast<double>(std::max<DurationNs>(transport.duration_ns, 1));
    const auto x_of = [&](TimeNs time_ns) {
      return at.x + static_cast<float>(std::clamp(static_cast<double>(time_ns) / length_ns, 0.0, 1.0)) * size.x;
    };
    ImGui::InvisibleButton("curve", size);
    const double share =
        std::clamp(static_cast<double>(ImGui::GetIO().MousePos.x - at.x) / static_cast<double>(size.x), 0.0, 1.0);
    const auto under_ns = static_cast<TimeNs>(share * length_ns);
    // A seek that is slow waits for the release.
    if ((ImGui::IsItemActive() && transport.is_quick(under_ns)) || ImGui::IsItemDeactivated())
      transport.seek_ns = under_ns;

    ImDrawList* draw = ImGui::GetWindowDrawList();
    const float bottom = at.y + size.y;
    draw->AddRectFilled(at, {at.x + size.x, bottom}, ImGui::GetColorU32(ui_colours.ground));
    draw->AddRectFilled(at, {x_of(transport.known_ns), bottom}, ImGui::GetColorU32(ui_colours.even));
    if (transport.from_ns || transport.to_ns) {
      draw->AddRectFilled({x_of(transport.from_ns.value_or(0)), at.y},
                          {x_of(transport.to_ns.value_or(transport.duration_ns)), bottom},
                          ImGui::GetColorU32({0.95f, 0.66f, 0.25f, 0.16f}));
    }
    const float strip = strips != nullptr ? strip_height(size.y, strips->strips().size()) : 0;
    float above = strip * static_cast<float>(strips != nullptr ? strips->strips().size() : 0);
    const float strips_top = bottom - above;
    if (const float row = row_height(size.y - above, input.thumbnails); row > 0) {
      above += row;
      draw_thumbnails(*draw, *input.thumbnails, transport.duration_ns, {at.x, bottom - above + 1}, {size.x, row - 2});
    }
    if (curve != nullptr) draw_points(*draw, *curve, x_of, bottom - above, size.y - above);
    if (input.selected_curve != nullptr) draw_line(*draw, *input.selected_curve, x_of, bottom - above, size.y - above);
    const LightStrips::Strip* under = nullptr;
    for (std::size_t i = 0; strip > 0 && i < strips->strips().size(); ++i) {
      const float top = strips_top + static_cast<float>(i) * strip;
      draw_strip(*draw, strips->strips()[i], strips->times(), x_of, {at.x, top}, strip);
      const float mouse = ImGui::GetIO().MousePos.y;
      if (mouse >= top && mouse < top + strip) under = &strips->strips()[i];
    }
    const auto line = [&](TimeNs time_ns, const ImVec4& colour) {
      const float x = x_of(time_ns);
      draw->AddLine({x, at.y}, {x, bottom}, ImGui::GetColorU32(colour), 1.5f);
    };
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
      line(under_ns, kUiDim);
      ImGui::BeginTooltip();
      ImGui::TextUnformatted((time_text(under_ns) + (under == nullptr ? "" : text_of(*under))).c_str());
      if (input.thumbnails != nullptr) {
        draw_thumbnail_tip(*input.thumbnails, under_ns, transport.duration_ns, input.scale);
      }
      ImGui::EndTooltip();
    }
    line(transport.seek_ns.value_or(transport.now_ns), kUiAmber);
    if (transport.seeking) line(transport.seeking->at_ns, kUiGreen);
    const bool partly = transport.known_ns > 0 && transport.known_ns < transport.duration_ns;
    ui_text(kUiDim, partly ? trf("mean level of all dimmers; known up to {}", time_text(transport.known_ns))
                           : std::string(tr("mean level of all dimmers")));
    if (input.selected_curve == nullptr) return;
    ImGui::SameLine();
    ui_text(kUiAmber, tr("of the selected ones"));
  }

  // Of the row of pictures; 0: there are none, or there is no room for them beside the curve.
  static float row_height(float height, const Thumbnails* thumbnails) {
    if (thumbnails == nullptr || thumbnails->all().empty()) return 0;
    const float row = std::min(0.7f * height, static_cast<float>(Thumbnails::kHeight) * 1.5f);
    return row < 1.5f * ImGui::GetTextLineHeight() ? 0 : std::floor(row);
  }

  // Of one strip; 0: there is no room for them beside the curve.
  static float strip_height(float height, std::size_t strips) {
    if (strips == 0) return 0;
    const float each = std::min(0.6f * height / static_cast<float>(strips), ImGui::GetTextLineHeight());
    return each < 3 ? 0 : std::floor(each);
  }

  static std::string text_of(const LightStrips::Strip& strip) {
    return trf("\n{}: mean light of {} of {} fixtures", strip.name, std::min(strip.heads.size(), strip.fixtures),
               strip.fixtures);
  }

  // The light of a group: a colour for each column of pixels, the brightest moment in it.
  template <class XOf>
  static void draw_strip(ImDrawList& draw, const LightStrips::Strip& strip, const std::vector<TimeNs>& times,
                         const XOf& x_of, ImVec2 at, float height) {
    draw.AddRectFilled(at, {x_of(INT64_MAX), at.y + height - 1}, IM_COL32_BLACK);
    const auto screen = [](float value) { return static_cast<float>(screen_of_linear(static_cast<double>(value))); };
    for (std::size_t i = 0; i < times.size();) {
      const float x = std::floor(x_of(times[i]));
      glm::vec3 brightest(-1);
      std::size_t next = i;
      for (; next < times.size() && std::floor(x_of(times[next])) <= x; ++next) {
        const glm::vec3& colour = strip.colours[next];
        if (colour.r + colour.g + colour.b > brightest.r + brightest.g + brightest.b) brightest = colour;
      }
      const float right = next < times.size() ? std::floor(x_of(times[next])) : x + 1;
      draw.AddRectFilled({x, at.y}, {right, at.y + height - 1},
                         ImGui::GetColorU32({screen(brightest.r), screen(brightest.g), screen(brightest.b), 1}));
      i = next;
    }
    const float size = ImGui::GetFontSize() * 0.8f;
    if (height < size) return;
    const ImVec2 text{at.x + 3, at.y + (height - size) / 2 - 1};
    draw.AddText(ImGui::GetFont(), size, {text.x + 1, text.y + 1}, IM_COL32(0, 0, 0, 220), strip.name.c_str());
    draw.AddText(ImGui::GetFont(), size, text, IM_COL32(255, 255, 255, 220), strip.name.c_str());
  }

  // One bar for each column of pixels: as high as the highest point in it.
  template <class XOf>
  static void draw_points(ImDrawList& draw, const LightCurve& curve, const XOf& x_of, float bottom, float height) {
    const ImU32 colour = ImGui::GetColorU32(ui_colours.bar);
    const auto& points = curve.points();
    for (std::size_t i = 0; i < points.size();) {
      const float x = std::floor(x_of(points[i].at_ns));
      float light = 0;
      std::size_t next = i;
      for (; next < points.size() && std::floor(x_of(points[next].at_ns)) <= x; ++next) {
        light = std::max(light, points[next].light);
      }
      const float right = next < points.size() ? std::floor(x_of(points[next].at_ns)) : x + 1;
      draw.AddRectFilled({x, bottom - light * height}, {right, bottom}, colour);
      i = next;
    }
  }

  // A line from moment to moment: the highest point in each column of pixels.
  template <class XOf>
  static void draw_line(ImDrawList& draw, const LightCurve& curve, const XOf& x_of, float bottom, float height) {
    const ImU32 colour = ImGui::GetColorU32(kUiAmber);
    std::optional<ImVec2> last;
    const auto& points = curve.points();
    for (std::size_t i = 0; i < points.size();) {
      const float x = std::floor(x_of(points[i].at_ns));
      float light = 0;
      for (; i < points.size() && std::floor(x_of(points[i].at_ns)) <= x; ++i) light = std::max(light, points[i].light);
      const ImVec2 at{x, bottom - 1 - light * std::max(height - 2, 0.0f)};
      if (last) draw.AddLine(*last, at, colour, 1.5f);
      last = at;
    }
  }

  std::size_t asked_ = 0;  // the marker of the menu
  std::string asked_name_;
  std::array<char, kMarkerNameMax + 2> text_{};
  std::string trouble_;
  bool opens_ = false;
};

}  // namespace

std::unique_ptr<Panel> make_timeline_panel(UiDesk&) { return std::make_unique<TimelinePanel>(); }

}  // namespace footlight::tools
