// The panel beside the picture, without a window.
#pragma once

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/preview_panel.h"

namespace footlight::testing {

class SidePanelUi : public DrawnUi {
 public:
  SidePanelUi(float width, float height) : imgui_(width, height) {}

  tools::PreviewFacts facts;
  tools::PreviewControls controls;
  const tools::LiveLevels* live = nullptr;
  tools::HandLevels* hand = nullptr;

 private:
  void draw() override {
    tools::draw_panel(facts, controls, live, hand, 1, [] {});
  }

  HeadlessImGui imgui_;
};

}  // namespace footlight::testing
