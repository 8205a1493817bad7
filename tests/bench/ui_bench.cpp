// CPU time of the panels of the window for one picture, without a window: each panel alone, all of them, and none, with
// a rig of as many fixtures as the argument says. Its figures are in docs/window.md.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui/imgui.h>

#include "fixtures/files/definition_list.h"
#include "tests/support/definition_files.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/edit_desk.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/light_strips.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/stage_marks.h"

using namespace footlight;
using namespace footlight::tools;

namespace {

// Fixtures as a camera above the audience sees them.
struct Stage {
  explicit Stage(int fixtures) : rig(testing::many_fixtures(fixtures)) {
    fixtures::Camera camera;
    camera.position_m = {50, -120, 60};
    camera.target_m = {50, 50, 0};
    place = {render::view_of(camera), {1920, 1080}};
  }
  testing::UiRig rig;
  StagePick pick{rig.rig};
  StagePlace place;
};

// words: of the open panels. everything: all fixtures are selected, and all levels change all the time.
void draw_panels(benchmark::State& state, const std::string& words, bool everything) {
  const Stage stage(static_cast<int>(state.range(0)));
  const testing::UiRig& rig = stage.rig;
  UiDesk desk(rig.rig, rig.compiled);
  UiPanels open;
  if (!open.open_words(words, desk)) state.SkipWithError("no such panel");
  desk.select(0, false);
  if (everything) desk.select_all();
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);

  const testing::HeadlessImGui imgui(1920, 1080);
  ImGuiIO& io = ImGui::GetIO();
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;  // as the window has it
  UiInput input;
  input.now_ns = kNsPerS;
  // A log of three hours with a moment every 2 s.
  Transport transport;
  transport.duration_ns = transport.known_ns = 10'800 * kNsPerS;
  LightCurve curve(rig.rig, desk.index());
  for (TimeNs at_ns = 0; at_ns < transport.duration_ns; at_ns += 2 * kNsPerS) curve.add(at_ns, levels);
  input.transport = &transport;
  input.curve = &curve;
  std::uint8_t level = 0;
  const auto draw = [&] {
    if (everything) std::fill(levels.begin(), levels.end(), ++level);
    input.now_ns += 16 * kNsPerMs;
    input.levels = levels;
    io.DeltaTime = 0.016f;
    open.step(levels, 16 * kNsPerMs, true);
    ImGui::NewFrame();
    open.draw(desk, input, 1920, 1080);
    if (everything) draw_marks(rig.rig, stage.pick, stage.place, desk.state().selection, 1);
    ImGui::Render();
    benchmark::DoNotOptimize(ImGui::GetDrawData()->TotalVtxCount);
  };
  for (int i = 0; i < 3; ++i) draw();  // what is made once
  for (auto _ : state) draw();
}

void closed(benchmark::State& state) { draw_panels(state, "", false); }
void universes(benchmark::State& state) { draw_panels(state, "universes", false); }
void universes_changing(benchmark::State& state) { draw_panels(state, "universes", true); }
void patch(benchmark::State& state) { draw_panels(state, "fixtures", false); }
void inspector(benchmark::State& state) { draw_panels(state, "inspector", false); }

// A drag that selects by a rectangle over the whole picture.
void rectangle(benchmark::State& state) {
  const Stage stage(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(stage.pick.fixtures_in(stage.place, {0, 0}, {1920, 1080}).size());
}

// One moment of the timeline's strips.
void strips(benchmark::State& state) {
  const testing::UiRig rig = testing::many_fixtures(static_cast<int>(state.range(0)));
  LightStrips all(rig.rig, rig.compiled);
  const std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax, 200);
  TimeNs at_ns = 0;
  for (auto _ : state) all.add(at_ns += 2 * kNsPerS, levels);
}

void timeline(benchmark::State& state) { draw_panels(state, "timeline", false); }
// 10,000 files are listed: the panel draws those that are in sight.
void library(benchmark::State& state) {
  const testing::TempFolder folder;
  for (int i = 0; i < state.range(0); ++i) {
    folder.write(fmt::format("{:05}.qxf", i), testing::qxf_head("Maker", fmt::format("Head {:05}", i), {{"m", 4}}));
  }
  const testing::UiRig rig = testing::many_fixtures(24);
  UiDesk desk(rig.rig, rig.compiled);
  desk.list_definitions_in({{folder.path().string()}});
  UiPanels open;
  if (!open.open_words("library", desk)) state.SkipWithError("no such panel");
  const testing::HeadlessImGui imgui(1920, 1080);
  const UiInput input;
  const auto draw = [&] {
    ImGui::NewFrame();
    open.draw(desk, input, 1920, 1080);
    ImGui::Render();
    benchmark::DoNotOptimize(ImGui::GetDrawData()->TotalVtxCount);
  };
  // Until all are read: the line with "reading" has gone.
  for (std::string words = "stop"; words.find("stop") != std::string::npos;) {
    ImGui::NewFrame();
    ImGui::LogToClipboard();
    open.draw(desk, input, 1920, 1080);
    ImGui::LogFinish();
    ImGui::Render();
    words = ImGui::GetClipboardText();
  }
  for (auto _ : state) draw();
}

void library_search(benchmark::State& state) {
  std::vector<fixtures::Definition> all;
  for (int i = 0; i < state.range(0); ++i) {
    all.push_back({{fmt::format("/usr/share/fixtures/{}.qxf", i), "qxf", fmt::format("Maker {}", i % 97),
                    fmt::format("Model {}", i)},
                   "par, flood",
                   {{"standard", 8, 8}, {"extended 16 bit", 24, 24}},
                   0,
                   ""});
  }
  fixtures::DefinitionList list;
  list.add(std::move(all));
  for (auto _ : state) benchmark::DoNotOptimize(list.search("bit 99").size());
}

void all_selected(benchmark::State& state) { draw_panels(state, "universes,fixtures,inspector", true); }

// A click on the picture.
void click(benchmark::State& state) {
  const Stage stage(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(stage.pick.fixture_at(stage.place, {960, 540}));
}

// One step of a slider's drag with all fixtures selected.
void take_all(benchmark::State& state) {
  const testing::UiRig rig = testing::many_fixtures(static_cast<int>(state.range(0)));
  UiDesk desk(rig.rig, rig.compiled);
  desk.select_all();
  desk.begin_gesture();
  std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);
  std::uint32_t raw = 0;
  for (auto _ : state) {
    desk.take({0, 2}, ++raw & 0xFFFF, levels);
    desk.overlay(levels);
  }
}

// One fixture is selected, then all of them.
void select_all(benchmark::State& state) {
  const testing::UiRig rig = testing::many_fixtures(static_cast<int>(state.range(0)));
  UiDesk desk(rig.rig, rig.compiled);
  for (auto _ : state) {
    desk.select(0, false);
    desk.select_all();
  }
}

// A step of a drag that moves all fixtures: the edit, and the tables of the new rig, without a frame of it.
void move_all(benchmark::State& state) {
  testing::EditDesk edit(testing::many_fixtures(static_cast<int>(state.range(0))).rig);
  edit.desk.select_all();
  edit.desk.begin_gesture();
  double by_m = 0.01;
  for (auto _ : state) {
    by_m = -by_m;
    if (!edit.desk.edit(fixtures::move_fixtures(edit.desk.edited(), edit.desk.selected(), {0, 0, by_m}))) {
      state.SkipWithError("refused");
    }
  }
}

// New addresses for all fixtures, and the conflicts among them.
void patch_all(benchmark::State& state) {
  testing::EditDesk edit(testing::many_fixtures(static_cast<int>(state.range(0))).rig);
  edit.desk.select_all();
  edit.desk.begin_gesture();
  Address address = 1;
  for (auto _ : state) {
    address = 3 - address;
    if (!edit.desk.edit(fixtures::patch_fixtures(edit.desk.edited(), edit.desk.selected(), {1, address}))) {
      state.SkipWithError("refused");
    }
    benchmark::DoNotOptimize(fixtures::patch_conflicts(edit.desk.edited()).size());
  }
}

}  // namespace

BENCHMARK(closed)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(universes)->Arg(24)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(universes_changing)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(patch)->Arg(24)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(inspector)->Arg(24)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(timeline)->Arg(24)->Unit(benchmark::kMillisecond);
BENCHMARK(rectangle)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(strips)->Arg(24)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(library)->Arg(24)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(library_search)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(all_selected)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(click)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(take_all)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(select_all)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(move_all)->Arg(1'000)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK(patch_all)->Arg(1'000)->Arg(10'000)->Unit(benchmark::kMillisecond);
