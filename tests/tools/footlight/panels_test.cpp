// The panels of the window without a window: Dear ImGui makes the lists that a GPU would draw.
#include <array>
#include <set>
#include <vector>

#include <GLFW/glfw3.h>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/stage_marks.h"

namespace footlight::tools {
namespace {

using footlight::testing::compiled_rig;
using footlight::testing::kUiRig;
using footlight::testing::many_fixtures;
using footlight::testing::parsed_rig;
using footlight::testing::UiRig;

constexpr std::size_t kKeys = 0;
constexpr std::size_t kUniverses = 1;
constexpr std::size_t kFixtures = 2;
constexpr std::size_t kInspector = 3;

// A user interface of one size with a mouse.
class HeadlessUi {
 public:
  explicit HeadlessUi(const UiRig& rig, float width = 1280, float height = 720)
      : desk(rig.rig, rig.compiled), levels(rig.compiled.universes.size() * kSlotCountMax) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {width, height};
    io.DeltaTime = 1.0f / 60;
    unsigned char* pixels = nullptr;
    int unused = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &unused, &unused);
  }
  ~HeadlessUi() { ImGui::DestroyContext(); }
  HeadlessUi(const HeadlessUi&) = delete;
  HeadlessUi& operator=(const HeadlessUi&) = delete;

  // Returns the number of vertices that it draws.
  int frame() {
    now_ns += kNsPerS / 60;
    UiInput input;
    input.levels = levels;
    input.now_ns = now_ns;
    ImGui::NewFrame();
    open.draw(desk, input, ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    ImGui::Render();
    return ImGui::GetDrawData()->TotalVtxCount;
  }
  void show(std::size_t panel) {
    open.set_open(panel, true, desk);
    for (int i = 0; i < 3; ++i) frame();  // sizes settle
  }
  void click(float x, float y) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {x, y};
    frame();
    desk.begin_gesture();
    io.MouseDown[0] = true;
    frame();
    io.MouseDown[0] = false;
    frame();
  }
  // Clicks down a line until `done`; the place, or a negative one.
  template <class Done>
  ImVec2 click_down(float x, float from_y, float to_y, Done done) {
    for (float y = from_y; y < to_y; y += 5) {
      click(x, y);
      if (done()) return {x, y};
    }
    return {-1, -1};
  }

  UiDesk desk;
  UiPanels open;
  std::vector<std::uint8_t> levels;
  TimeNs now_ns = kNsPerS;
};

TEST_CASE("closed panels draw nothing and are not there") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  CHECK(!ui.open.any_open());
  CHECK(ui.frame() == 0);
  ui.show(kUniverses);
  CHECK(ui.frame() > 2 * kSlotCountMax);
  ui.open.set_open(kUniverses, false, ui.desk);
  CHECK(ui.frame() == 0);
}

TEST_CASE("every panel survives an empty rig, modes without channels, no levels and 10,000 fixtures, in any size") {
  fixtures::Rig none = parsed_rig(kUiRig);
  none.fixtures.clear();
  fixtures::Rig bare = parsed_rig(kUiRig);
  for (fixtures::FixtureType& type : bare.types) {
    for (fixtures::Mode& mode : type.modes) {
      mode.channels.clear();
      mode.relations.clear();
    }
  }
  std::vector<UiRig> rigs;
  rigs.push_back(compiled_rig(std::move(none)));
  rigs.push_back(compiled_rig(std::move(bare)));
  rigs.push_back(compiled_rig(parsed_rig(kUiRig)));
  rigs.push_back(many_fixtures(10'000));
  for (const UiRig& rig : rigs) {
    for (const ImVec2 size : {ImVec2(640, 400), ImVec2(1920, 1080), ImVec2(1, 1)}) {
      HeadlessUi ui(rig, size.x, size.y);
      for (std::size_t i = 0; i < panels().size(); ++i) ui.show(i);
      CHECK(ui.frame() > 0);
      ui.desk.select_all();
      ui.desk.set_highlight(true);
      ui.frame();
      if (!rig.rig.fixtures.empty() && ui.desk.index().channel_count(0) > 0) ui.desk.take({0, 0}, 3);
      ui.open.step(ui.levels, kNsPerMs, true);
      ui.open.restart();
      ui.levels.clear();
      ui.frame();
    }
  }
}

TEST_CASE("a slot of the grid says which fixture it belongs to and selects it") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  // In the middle of the third row are slots 65 and up: nobody's. The first row belongs to the spots.
  const ImVec2 at = ui.click_down(300, 250, 700, [&] { return ui.desk.state().selection.lead >= 0; });
  CHECK(at.y > 0);
  CHECK(ui.desk.state().selection.lead < 3);
}

TEST_CASE("levels are drawn as bars, until the grid is frozen") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kUniverses);
  // Vertices with all levels down, and with all up.
  const auto drawn = [&] {
    std::array<int, 2> vertices{};
    for (std::size_t i = 0; i < 2; ++i) {
      std::fill(ui.levels.begin(), ui.levels.end(), static_cast<std::uint8_t>(200 * i));
      for (int frame = 0; frame < 2; ++frame) vertices[i] = ui.frame();
      ui.now_ns += 2 * kNsPerS;  // no change is recent
      vertices[i] = ui.frame();
    }
    return vertices;
  };
  const auto live = drawn();
  CHECK(live[1] > live[0] + kSlotCountMax * 4);
  // The box to tick is in the first line, behind the universe.
  bool frozen = false;
  for (float y = 410; y < 450 && !frozen; y += 8) {
    for (float x = 300; x > 180 && !frozen; x -= 10) {
      ui.click(x, y);
      const auto now = drawn();
      frozen = now[0] == now[1];
    }
  }
  CHECK(frozen);
}

TEST_CASE("rows of the patch select: a click one, Ctrl another one, Shift all between") {
  const auto rig = many_fixtures(200);
  HeadlessUi ui(rig);
  ui.show(kFixtures);
  const auto& selection = ui.desk.state().selection;
  // The clicks before meet the head of the names and sort by them: Spot 2 comes before Spot 10.
  const ImVec2 first = ui.click_down(100, 20, 300, [&] { return selection.lead >= 0; });
  REQUIRE(first.y > 0);
  CHECK(selection.fixtures == std::vector<int>{0});
  const ImVec2 second = ui.click_down(100, first.y, 300, [&] { return selection.lead == 3; });
  REQUIRE(second.y > first.y);
  ImGui::GetIO().KeyCtrl = true;
  ui.click(first.x, first.y);
  CHECK(selection.fixtures == std::vector<int>{0, 3});
  ImGui::GetIO().KeyCtrl = false;
  ImGui::GetIO().KeyShift = true;
  ui.click(second.x, second.y);
  CHECK(selection.fixtures == std::vector<int>{0, 1, 2, 3});
}

TEST_CASE("a slider of the inspector takes its channel over") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.desk.select(0, false);
  ui.show(kInspector);
  // A click into a slider sets it to where the mouse is. The second column begins behind a quarter of the panel.
  const ImVec2 at = ui.click_down(1280 - 8 - 440 + 200, 60, 500, [&] { return !ui.desk.state().taken.empty(); });
  REQUIRE(at.y > 0);
  CHECK(ui.desk.state().taken.begin()->first.fixture == 0);
  CHECK(ui.desk.undo().starts_with("set "));
  CHECK(ui.desk.state().taken.empty());
}

TEST_CASE("panels are opened by their words, and a wrong word is refused with the right ones") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  UiPanels open;
  CHECK(open.open_words("universes,inspector", desk));
  CHECK(open.is_open(kUniverses));
  CHECK(open.is_open(kInspector));
  CHECK(!open.is_open(kFixtures));
  const Status wrong = check_panel_words("fixtures,nonsense");
  REQUIRE(!wrong);
  CHECK(wrong.error().message.find("nonsense") != std::string::npos);
  CHECK(wrong.error().message.find("universes") != std::string::npos);
  CHECK(check_panel_words(""));
}

TEST_CASE("no key has two meanings, and every key that does something is in the list") {
  std::set<std::pair<int, int>> seen;
  for (const KeyRow& row : key_rows()) {
    CHECK(seen.emplace(row.key, row.mods).second);
    CHECK((row.keys == nullptr) == (row.does == nullptr));
    const auto call = call_of(row.key, row.mods, false);
    REQUIRE(call);
    CHECK(call->action == row.call.action);
    CHECK(call_of(row.key, row.mods, true).has_value() == row.repeats);
    if (row.menu != UiMenu::kNone) CHECK(row.keys != nullptr);
  }
  for (std::size_t i = 0; i < panels().size(); ++i) {
    CHECK(seen.emplace(panels()[i].key, 0).second);
    const auto call = call_of(panels()[i].key, 0, false);
    REQUIRE(call);
    CHECK(call->action == UiAction::kPanel);
    CHECK(call->argument == static_cast<int>(i));
  }
  CHECK(call_of(GLFW_KEY_3, 0, false)->argument == 2);
  CHECK(call_of(GLFW_KEY_Z, kKeyControl | kKeyShift, false)->action == UiAction::kRedo);
  CHECK(call_of(GLFW_KEY_Z, kKeyControl | GLFW_MOD_NUM_LOCK, false)->action == UiAction::kUndo);
  CHECK(!call_of(GLFW_KEY_Z, 0, false));
  CHECK(!call_of(GLFW_KEY_UNKNOWN, 0, false));
}

TEST_CASE("the list of keys draws a line for every key") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  ui.show(kKeys);
  CHECK(ui.frame() > static_cast<int>(key_rows().size()) * 4 * 8);
}

TEST_CASE("marks are drawn for what is selected and in the picture only") {
  const auto rig = compiled_rig(parsed_rig(kUiRig));
  HeadlessUi ui(rig);
  const StagePick pick(rig.rig);
  fixtures::Camera camera;
  const auto vertices = [&](const Selection& selection) {
    ImGui::NewFrame();
    draw_marks(rig.rig, pick, {render::view_of(camera), {1280, 720}}, selection, 1);
    ImGui::Render();
    return ImGui::GetDrawData()->TotalVtxCount;
  };
  CHECK(vertices({}) == 0);
  CHECK(vertices({{0}, 0}) > 16);
  CHECK(vertices({{0, 1}, 0}) > vertices({{0}, 0}));
  camera.target_m = camera.position_m + glm::dvec3(0, -1, 0);  // looks away
  CHECK(vertices({{0, 1}, 0}) == 0);
}

}  // namespace
}  // namespace footlight::tools
