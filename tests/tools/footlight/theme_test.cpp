// The colours of the window's themes: contrast by WCAG 2.1, and how they look with protanopia, deuteranopia and
// tritanopia (Machado, Oliveira and Fernandes 2009, severity 1), in CIELAB.
#include <array>
#include <cmath>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include <glm/glm.hpp>

#include "fixtures/model/color.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/ui/pick_colour.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

glm::dvec3 linear(const ImVec4& colour) {
  const auto part = [](float value) { return linear_of_screen(static_cast<double>(value)); };
  return {part(colour.x), part(colour.y), part(colour.z)};
}
double contrast(const ImVec4& a, const ImVec4& b) {
  const double one = fixtures::luminance(linear(a)) + 0.05;
  const double other = fixtures::luminance(linear(b)) + 0.05;
  return std::max(one, other) / std::min(one, other);
}
glm::dvec3 lab(const glm::dvec3& rgb) {
  const glm::dvec3 share =
      fixtures::rgb_to_xyz(glm::clamp(rgb, glm::dvec3(0), glm::dvec3(1))) / fixtures::rgb_to_xyz(glm::dvec3(1));
  glm::dvec3 f;
  for (int i = 0; i < 3; ++i) f[i] = share[i] > 0.008856 ? std::cbrt(share[i]) : 7.787 * share[i] + 16.0 / 116;
  return {116 * f.y - 16, 500 * (f.x - f.y), 200 * (f.y - f.z)};
}

// In columns.
const std::array<glm::dmat3, 4> kEyes{
    glm::dmat3(1),
    glm::dmat3(0.152286, 0.114503, -0.003882, 1.052583, 0.786281, -0.048116, -0.204868, 0.099216, 1.051998),
    glm::dmat3(0.367322, 0.280085, -0.011820, 0.860646, 0.672501, 0.042940, -0.227968, 0.047413, 0.968881),
    glm::dmat3(1.255528, -0.078411, 0.004733, -0.076749, 0.930809, 0.691367, -0.178779, 0.147602, 0.303900)};

TEST_CASE("colours of states differ for every kind of eye, and all text has a contrast of 4.5 in both themes") {
  for (const UiTheme theme : {UiTheme::kDark, UiTheme::kLight}) {
    CAPTURE(word_of(theme));
    const UiColours colours = colours_of(theme);
    for (const ImVec4& text : {colours.accent, colours.good, colours.bad, colours.dim, colours.text}) {
      CHECK(contrast(text, colours.window) >= 4.5);
    }
    for (const ImVec4& ground : {colours.ground, colours.even, colours.odd, colours.bar}) {
      CHECK(contrast(colours.text, ground) >= 4.5);
    }
    const std::array<ImVec4, 4> states{colours.accent, colours.good, colours.bad, colours.text};
    for (std::size_t eye = 0; eye < kEyes.size(); ++eye) {
      CAPTURE(eye);
      for (std::size_t a = 0; a < states.size(); ++a) {
        for (std::size_t b = a + 1; b < states.size(); ++b) {
          CAPTURE(a);
          CAPTURE(b);
          CHECK(glm::length(lab(kEyes[eye] * linear(states[a])) - lab(kEyes[eye] * linear(states[b]))) >= 20);
        }
      }
    }
  }
}

TEST_CASE("a theme that is set twice has the sizes of once, and changes the colours of states") {
  const testing::HeadlessImGui imgui(640, 480);
  set_ui_style(2, UiTheme::kLight);
  const ImGuiStyle once = ImGui::GetStyle();
  CHECK(kUiGreen.y == colours_of(UiTheme::kLight).good.y);
  set_ui_style(2, UiTheme::kLight);
  CHECK(ImGui::GetStyle().FramePadding.x == once.FramePadding.x);
  CHECK(ImGui::GetStyle().IndentSpacing == once.IndentSpacing);
  set_ui_style(1, UiTheme::kDark);
  CHECK(ImGui::GetStyle().FramePadding.x == once.FramePadding.x / 2);
  CHECK(kUiGreen.y == colours_of(UiTheme::kDark).good.y);
}

}  // namespace
}  // namespace footlight::tools
