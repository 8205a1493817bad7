// The report panel: what it is made of, and the panel without a window.
#include <cmath>
#include <string>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {
namespace {

render::KnobPoint knob(std::uint32_t nodes, double error, double ms) {
  render::KnobPoint point;
  point.knobs.nodes = nodes;
  point.error = error;
  point.ms = ms;
  return point;
}

ReportView measured_view() {
  ReportView view;
  view.picture = 1;
  view.passes = {{"beams", 3}, {"tonemap", 1}};
  view.picture_ms = 4;
  view.ladder = {knob(4, 1e-4, 10), knob(3, 1e-3, 2), knob(1, 1e-2, 0.5)};
  view.present = view.ladder[1];
  return view;
}

class ReportUi final : public testing::DrawnUi {
 public:
  explicit ReportUi(float height = 720)
      : imgui_(1280, height),
        rig_(testing::compiled_rig(testing::parsed_rig(testing::kUiRig))),
        desk_(rig_.rig, rig_.compiled),
        panel_(make_report_panel(desk_)) {}
  ReportView view = measured_view();

 private:
  void draw() override {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize(ImGui::GetIO().DisplaySize);
    UiInput input;
    input.report = &view;
    if (ImGui::Begin("report")) panel_->draw(desk_, input);
    ImGui::End();
  }

  testing::HeadlessImGui imgui_;
  testing::UiRig rig_;
  UiDesk desk_;
  std::unique_ptr<Panel> panel_;
};

TEST_CASE("the history of a pass has a time for each picture, also of those before it came and after it went") {
  PassHistory history;
  history.add(std::vector<render::PassTime>{{"beams", 2}});
  history.add(std::vector<render::PassTime>{{"gobos", 5}, {"beams", 4}});
  history.add(std::vector<render::PassTime>{{"beams", 9}});
  REQUIRE(history.rows().size() == 2);
  CHECK(history.rows()[0].name == "beams");
  CHECK(history.rows()[0].ms == std::vector<float>{2, 4, 9});
  CHECK(history.rows()[0].last_ms() == 9);
  CHECK(history.rows()[0].median_ms() == 4);
  CHECK(history.rows()[1].ms == std::vector<float>{0, 5, 0});
  CHECK(history.rows()[1].most_ms() == 5);
  CHECK(history.total().ms == std::vector<float>{2, 9, 9});
}

TEST_CASE("a history keeps the last pictures, and forgets a pass that none of them has") {
  PassHistory history;
  history.add(std::vector<render::PassTime>{{"gobos", 5}, {"beams", 1}});
  for (std::size_t i = 1; i < PassHistory::kPicturesMax; ++i) {
    history.add(std::vector<render::PassTime>{{"beams", static_cast<double>(i)}});
  }
  CHECK(history.rows().size() == 2);
  history.add(std::vector<render::PassTime>{{"beams", 7}});
  REQUIRE(history.rows().size() == 1);
  CHECK(history.pictures() == PassHistory::kPicturesMax);
  CHECK(history.rows()[0].ms.size() == PassHistory::kPicturesMax);
  CHECK(history.rows()[0].ms.front() == 1);
}

TEST_CASE("the plot has logarithmic axes of whole decades, and the curve at the times of this picture") {
  ReportView view = measured_view();
  const auto plot = plot_of(view);
  REQUIRE(plot);
  CHECK(plot->scale == 2);  // the picture takes 4 ms, and the present setting 2 ms where it was measured
  REQUIRE(plot->curve.size() == 3);
  CHECK(plot->curve[0].point.ms == 20);
  // Times from 1 to 20 ms: 1 to 100; errors from 1e-4 to 1e-2.
  CHECK(plot->ticks_x.size() == 3);
  CHECK(plot->ticks_x.back().text == "100 ms");
  CHECK(plot->ticks_y.size() == 3);
  CHECK(plot->ticks_y.front().text == "0.01 %");
  CHECK(plot->curve[0].at.x == doctest::Approx(std::log10(20) / 2));
  CHECK(plot->curve[0].at.y == doctest::Approx(0));
  CHECK(plot->curve[1].at.y == doctest::Approx(0.5));
  CHECK(plot->curve[2].at.x == doctest::Approx(0));
  REQUIRE(plot->present);
  CHECK(plot->present->x == plot->curve[1].at.x);
  CHECK(plot->present->y == plot->curve[1].at.y);
  CHECK(!plot->measured);
  CHECK(!plot->target_x);
  CHECK(!plot->target_y);
}

TEST_CASE("what is measured and what is asked for are in the plot, whatever the curve has") {
  ReportView view = measured_view();
  view.error = {.rel_l2 = 1e-1, .low = 1e-2, .high = 0, .samples = 9};
  view.error.high = 0.5;
  view.target.error = 1e-6;
  const auto by_error = plot_of(view);
  REQUIRE(by_error);
  REQUIRE(by_error->measured);
  CHECK(by_error->ticks_y.size() == 6);  // 1e-6 to 1e-1
  CHECK(by_error->measured->y == doctest::Approx(1));
  CHECK(by_error->measured->x == by_error->present->x);
  CHECK(by_error->measured_low == doctest::Approx(0.8));
  CHECK(by_error->measured_high == 1);  // beyond the axis
  CHECK(*by_error->target_y == doctest::Approx(0));
  CHECK(!by_error->target_x);
  view.target = {.ms = 1000};
  const auto by_time = plot_of(view);
  REQUIRE(by_time);
  CHECK(*by_time->target_x == doctest::Approx(1));
  CHECK(!by_time->target_y);
}

TEST_CASE("a plot survives errors and times of 0, and there is none without a curve") {
  ReportView view = measured_view();
  view.ladder[0].error = 0;
  view.ladder[2].ms = 0;
  view.picture_ms = 0;
  const auto plot = plot_of(view);
  REQUIRE(plot);
  CHECK(plot->scale == 1);
  for (const ErrorPlot::Knob& one : plot->curve) {
    CHECK(std::isfinite(one.at.x));
    CHECK(std::isfinite(one.at.y));
  }
  view.ladder.clear();
  CHECK(!plot_of(view));
}

TEST_CASE("without a curve a button asks for its measurement, unless the view says why not") {
  ReportUi ui;
  CHECK(ui.words().find("present setting") != std::string::npos);
  ui.view.ladder.clear();
  ui.view.why_not_measure = "outputs are armed";
  CHECK(ui.words().find("outputs are armed") != std::string::npos);
  const auto press_all = [&] {
    for (float y = 40; y < 300 && !ui.view.measure; y += 6) ui.press(60, y);
    return ui.view.measure;
  };
  CHECK(!press_all());
  ui.view.why_not_measure.clear();
  CHECK(press_all());
  ui.view.measures = true;
  CHECK(ui.words().find("measuring this machine") != std::string::npos);
}

TEST_CASE("each page of the report has its figures") {
  ReportUi ui;
  ui.view.bytes = 3 << 20;
  ui.view.memory = {{"gobos", 2 << 20}, {"beams", 1 << 20}};
  std::string all;
  for (float x = 20; x < 400; x += 12) {  // along the tabs
    ui.press(x, 34);
    all += ui.words();
  }
  CHECK(all.find("tonemap") != std::string::npos);
  CHECK(all.find("3.00 ms") != std::string::npos);
  CHECK(all.find("2048.0 KiB") != std::string::npos);
  CHECK(all.find("looking ...") != std::string::npos);
  ui.view.has_left_out = true;
  ui.view.left_out.used_code_bytes = 7;
  LeftOutRow row;
  row.name = "lasers";
  row.pass = true;
  row.text = "scanned lasers";
  row.code_bytes = 9;
  ui.view.left_out.rows = {row};
  all.clear();
  for (float x = 20; x < 400; x += 12) {
    ui.press(x, 34);
    all += ui.words();
  }
  CHECK(all.find("pass lasers") != std::string::npos);
  CHECK(all.find("7 B in use") != std::string::npos);
}

}  // namespace
}  // namespace footlight::tools
