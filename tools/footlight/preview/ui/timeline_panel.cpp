// The log in time: how bright the rig is over it, where it plays, how fast, and which part repeats.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/transport.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

class TimelinePanel final : public Panel {
 public:
  void draw(UiDesk&, const UiInput& input) override {
    if (input.transport == nullptr) {
      ui_text(kUiDim,
              "No log plays: the rig follows live inputs or faders. `footlight preview RIG --log LOG` plays one.");
      return;
    }
    draw_controls(*input.transport, input.scale);
    draw_curve(*input.transport, input.curve);
  }

 private:
  static void draw_controls(Transport& transport, float scale) {
    if (ImGui::Button(transport.playing ? "pause" : "play", {64 * scale, 0})) transport.playing = !transport.playing;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(84 * scale);
    if (ImGui::BeginCombo("##speed", fmt::format("x {}", transport.speed).c_str())) {
      for (const double speed : kSpeeds) {
        if (ImGui::Selectable(fmt::format("x {}", speed).c_str(), speed == transport.speed)) transport.speed = speed;
      }
      ImGui::EndCombo();
    }
    ImGui::SameLine();
    ImGui::Checkbox("repeat", &transport.repeats);
    ImGui::SameLine();
    if (ImGui::Button("from here")) transport.repeat_from(transport.now_ns);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The part that repeats begins at this time.");
    ImGui::SameLine();
    if (ImGui::Button("to here")) transport.repeat_to(transport.now_ns);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The part that repeats ends at this time.");
    if (transport.from_ns || transport.to_ns) {
      ImGui::SameLine();
      if (ImGui::Button("whole log")) transport.repeat_all();
    }
    ImGui::SameLine();
    ui_text(fmt::format("{} of {}", time_text(transport.now_ns), time_text(transport.duration_ns)));
    if (transport.from_ns || transport.to_ns) {
      ImGui::SameLine();
      ui_text(kUiAmber, fmt::format("repeats {} to {}", time_text(transport.from_ns.value_or(0)),
                                    time_text(transport.to_ns.value_or(transport.duration_ns))));
    }
  }

  // Time runs from left to right; a click or a drag seeks.
  static void draw_curve(Transport& transport, const LightCurve* curve) {
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
    draw->AddRectFilled(at, {at.x + size.x, bottom}, ImGui::GetColorU32({0.075f, 0.080f, 0.090f, 1}));
    draw->AddRectFilled(at, {x_of(transport.known_ns), bottom}, ImGui::GetColorU32({0.105f, 0.115f, 0.135f, 1}));
    if (transport.from_ns || transport.to_ns) {
      draw->AddRectFilled({x_of(transport.from_ns.value_or(0)), at.y},
                          {x_of(transport.to_ns.value_or(transport.duration_ns)), bottom},
                          ImGui::GetColorU32({0.95f, 0.66f, 0.25f, 0.16f}));
    }
    if (curve != nullptr) draw_points(*draw, *curve, x_of, bottom, size.y);
    const auto line = [&](TimeNs time_ns, const ImVec4& colour) {
      const float x = x_of(time_ns);
      draw->AddLine({x, at.y}, {x, bottom}, ImGui::GetColorU32(colour), 1.5f);
    };
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
      line(under_ns, kUiDim);
      ImGui::SetTooltip("%s", time_text(under_ns).c_str());
    }
    line(transport.seek_ns.value_or(transport.now_ns), kUiAmber);
    const bool partly = transport.known_ns > 0 && transport.known_ns < transport.duration_ns;
    ui_text(kUiDim, partly ? fmt::format("mean level of all dimmers; known up to {}", time_text(transport.known_ns))
                           : std::string("mean level of all dimmers"));
  }

  // One bar for each column of pixels: as high as the highest point in it.
  template <class XOf>
  static void draw_points(ImDrawList& draw, const LightCurve& curve, const XOf& x_of, float bottom, float height) {
    const ImU32 colour = ImGui::GetColorU32({0.20f, 0.36f, 0.56f, 1});
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
};

}  // namespace

std::unique_ptr<Panel> make_timeline_panel(UiDesk&) { return std::make_unique<TimelinePanel>(); }

}  // namespace footlight::tools
