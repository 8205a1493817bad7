// The field that searches actions, without a window.
#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "render/display.h"
#include "tests/tools/footlight/edit_ui.h"
#include "tools/footlight/preview/key_presses.h"
#include "tools/footlight/preview/preview_panel.h"
#include "tools/footlight/preview/ui/actions.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/palette.h"
#include "tools/footlight/preview/ui/run_action.h"

namespace footlight::tools {
namespace {

using footlight::testing::EditUi;
using footlight::testing::kDown;
using footlight::testing::kEnter;
using footlight::testing::kEscape;
using footlight::testing::kUiRig;
using footlight::testing::kUp;
using footlight::testing::parsed_rig;
using footlight::testing::rig_with_cameras;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// One armed output during a blackout: everything of outputs is possible.
OutputsView dark_output() {
  OutputsView view;
  view.rows.emplace_back();
  view.rows.back().state = ArmState::kArmed;
  view.darkness = Darkness::kAsked;
  return view;
}

// A palette over a rig with two cameras, where every action is possible.
struct PaletteUi {
  PaletteUi() : ui(rig_with_cameras()) {
    const std::vector<std::uint8_t> levels(ui.desk.compiled().universes.size() * kSlotCountMax);
    ui.desk.select(0, false);
    ui.desk.begin_gesture();
    ui.desk.take({0, 2}, 200, levels);
    ui.desk.begin_gesture();
    ui.desk.select(1, false);
    ui.desk.undo();  // so that there is something to redo
    ui.desk.comparison().a = KeptLevels{};  // that can be ended
    ui.more = [this] {
      if (const auto one = palette.draw(ui.desk, has_log, &outputs, 1)) chosen = one;
    };
  }
  void open() {
    chosen.reset();
    palette.open();
    for (int i = 0; i < 3; ++i) ui.frame();
  }
  void write(const std::string& text) {
    for (const char c : text) ImGui::GetIO().AddInputCharacter(static_cast<unsigned>(c));
    ui.frame();
    ui.frame();
  }

  EditUi ui;
  Palette palette;
  bool has_log = true;
  OutputsView outputs = dark_output();
  std::optional<UiCall> chosen;
};

TEST_CASE("the list of actions has every key that the table shows, every panel and every camera") {
  const PaletteUi one;
  const auto items = action_items(one.ui.desk, true, &one.outputs);
  const auto has = [&](const UiCall& call) {
    return std::any_of(items.begin(), items.end(), [&](const UiActionItem& item) { return item.call == call; });
  };
  std::size_t expected = panels().size() + 2;
  for (const KeyRow& row : key_rows()) {
    if (row.keys == nullptr || row.call.action == UiAction::kCamera) continue;
    ++expected;
    CHECK_MESSAGE(has(row.call), row.does);
  }
  for (const CommandRow& row : command_rows()) {
    ++expected;
    CHECK_MESSAGE(has(row.call), row.does);
  }
  expected += std::size(render::kToneCurves) + quality_choices().size();
  CHECK(items.size() == expected);
  for (std::size_t i = 0; i < panels().size(); ++i) CHECK(has({UiAction::kPanel, static_cast<int>(i)}));
  CHECK(has({UiAction::kCamera, 0}));
  CHECK(has({UiAction::kCamera, 1}));
  for (const UiActionItem& item : items) {
    const bool is_so = item.call == UiCall{UiAction::kTone, 0};  // the picture has this curve
    CHECK_MESSAGE(item.possible() != is_so, item.label, ": ", item.why_not);
  }
}

// The names of UiAction in their order, as the source has them.
std::vector<std::string> names_of_actions() {
  std::ifstream file(FOOTLIGHT_SOURCE_DIR "/tools/footlight/preview/ui/keys.h");
  std::vector<std::string> names;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("};")) inside = false;
    const std::size_t name = line.find_first_not_of(' ');
    if (inside && name != std::string::npos && line[name] == 'k') {
      names.push_back(line.substr(name, line.find(',', name) - name));
    }
    if (line.starts_with("enum class UiAction")) inside = true;
  }
  return names;
}

TEST_CASE("every action of the list is carried out by the window, by its outputs or by the desk") {
  std::string source;
  for (const char* path : {"preview_input.cpp", "preview_outputs.cpp", "ui/run_action.cpp"}) {
    std::ifstream file(std::string(FOOTLIGHT_SOURCE_DIR "/tools/footlight/preview/") + path);
    REQUIRE(file.is_open());
    source += std::string{std::istreambuf_iterator<char>(file), {}};
  }
  const std::vector<std::string> names = names_of_actions();
  REQUIRE(names.size() == static_cast<std::size_t>(UiAction::kEscape) + 1);
  CHECK(names.back() == "kEscape");
  CHECK(names[static_cast<std::size_t>(UiAction::kLibrary)] == "kLibrary");
  const auto is_done = [&](const std::string& name) {
    return contains(source, "case UiAction::" + name + ":") || contains(source, "action == UiAction::" + name) ||
           contains(source, "action != UiAction::" + name);
  };
  CHECK(!is_done("kNothingOfThisName"));
  const PaletteUi one;
  for (const UiActionItem& item : action_items(one.ui.desk, true, &one.outputs)) {
    const std::string& name = names[static_cast<std::size_t>(item.call.action)];
    CHECK_MESSAGE(is_done(name), name, " of the action '", item.label, "' does nothing");
  }
}

// What actions of the desk change.
std::string seen_of(const UiDesk& desk) {
  const UiState& state = desk.state();
  std::string seen;
  const auto add = [&](auto value) { seen += std::to_string(value) + " "; };
  add(state.revision);
  add(state.selection.fixtures.size());
  add(state.taken.size());
  add(static_cast<int>(state.look.tone));
  add(static_cast<int>(desk.handles()));
  add(static_cast<int>(desk.highlights()));
  add(static_cast<int>(desk.locates()));
  add(static_cast<int>(desk.measure().on));
  add(static_cast<int>(desk.floor_lines()));
  add(static_cast<int>(desk.comparison().a.has_value()));
  add(static_cast<int>(desk.fly().on()));
  add(static_cast<int>(desk.flashes()));
  return seen;
}

TEST_CASE("every action that needs no window changes something on the desk where the list says that it can") {
  std::size_t ran = 0;
  const auto items = [] {
    const PaletteUi one;
    return action_items(one.ui.desk, true, &one.outputs);
  }();
  for (const UiActionItem& item : items) {
    PaletteUi fresh;
    UiDesk& desk = fresh.ui.desk;
    if (!why_not(item.call, desk, true, &fresh.outputs).empty()) continue;
    if (item.call.action == UiAction::kReleaseAll) REQUIRE(!desk.state().taken.empty());
    const std::string before = seen_of(desk);
    const auto news = run_on_desk(desk, item.call);
    if (!news) continue;  // needs the window
    ++ran;
    CHECK_MESSAGE((seen_of(desk) != before || !news->text.empty()), item.label);
  }
  CHECK(ran > 15);
}

TEST_CASE("keys belong to the palette from the moment it is asked for") {
  Palette palette;
  CHECK(!palette.is_open());
  palette.open();
  CHECK(palette.is_open());
}

TEST_CASE("each action is found by its words and run by Enter") {
  PaletteUi one;
  for (const UiActionItem& item : action_items(one.ui.desk, true, &one.outputs)) {
    if (item.call.action == UiAction::kPalette || !item.possible()) continue;
    CAPTURE(item.label);
    one.open();
    REQUIRE(EditUi::has_popup());
    CHECK(one.palette.is_open());
    // Backwards, since the order of words does not matter.
    one.write(item.keys + " " + item.label);
    one.ui.hit(kEnter);
    REQUIRE(one.chosen);
    CHECK(*one.chosen == item.call);
    CHECK(!EditUi::has_popup());
  }
}

// All of a desk that an action can change.
struct DeskMark {
  explicit DeskMark(const UiDesk& desk)
      : selection(desk.state().selection),
        taken(desk.state().taken),
        look(desk.state().look),
        revision(desk.state().revision),
        on{desk.highlights(),
           desk.locates(),
           desk.handles(),
           desk.measure().on,
           desk.floor_lines(),
           desk.fly().on(),
           desk.comparison().a.has_value(),
           desk.locked()},
        flashes(desk.flashes()) {}
  Selection selection;
  std::map<ChannelKey, std::uint32_t> taken;
  PictureLook look;
  std::uint64_t revision;
  std::array<bool, 8> on;
  FlashMode flashes;
  bool operator==(const DeskMark&) const = default;
};

TEST_CASE("each action of the desk changes it, and those that are not possible say why") {
  std::vector<UiActionItem> all;
  {
    PaletteUi many;
    all = action_items(many.ui.desk, true, &many.outputs);
  }
  int ran = 0;
  for (const UiActionItem& item : all) {
    if (!item.possible()) continue;
    PaletteUi one;
    CAPTURE(item.label);
    const DeskMark before(one.ui.desk);
    const auto news = run_on_desk(one.ui.desk, item.call);
    if (!news) continue;  // the window's
    ++ran;
    CHECK(!(DeskMark(one.ui.desk) == before));
  }
  CHECK(ran >= 20);

  EditUi bare(parsed_rig(kUiRig));
  std::map<UiAction, std::string> reasons;
  for (const UiActionItem& item : action_items(bare.desk, false, nullptr)) {
    if (!item.possible()) reasons[item.call.action] = item.why_not;
  }
  for (const auto action : {UiAction::kHighlight, UiAction::kLocate, UiAction::kDelete, UiAction::kNudge,
                            UiAction::kUnpatch, UiAction::kEditField}) {
    CHECK(reasons[action] == "select a fixture first");
  }
  CHECK(contains(reasons[UiAction::kPlay], "no log plays"));
  CHECK(contains(reasons[UiAction::kBlackout], "F6 or --output"));
  for (const auto action : {UiAction::kUndo, UiAction::kRedo, UiAction::kReleaseAll, UiAction::kEndCompare}) {
    CHECK(!reasons[action].empty());
  }
  CHECK(why_not({UiAction::kCamera, 7}, bare.desk, false, nullptr) == "the rig has no such camera; C stores one");
  bare.desk.set_exposure({4, true});
  CHECK(why_not({UiAction::kBrighter}, bare.desk, false, nullptr) == "the exposure is automatic");
}

TEST_CASE("a row of the list opens the field of the selected fixtures in the patch, and unpatches them") {
  EditUi ui(parsed_rig(kUiRig));
  ui.desk.select(0, false);
  ui.open.set_open(panel_of("fixtures"), true, ui.desk);
  ui.desk.ask_field(EditField::kNumber);
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(EditUi::has_popup());
  CHECK(contains(ui.words(), "Number of Spot 1"));
  ui.type("41");
  CHECK(ui.edit.fixture(0).labels.fixture_id_numeric == 41);
  const auto news = run_on_desk(ui.desk, {UiAction::kUnpatch});
  REQUIRE(news);
  CHECK(contains(news->text, "Ctrl+Z brings it back"));
  CHECK(!ui.edit.fixture(0).patched);
}

TEST_CASE("words narrow the list in any order and case, and what has none of them says so") {
  PaletteUi one;
  one.open();
  CHECK(contains(one.ui.words(), "work light"));
  CHECK(contains(one.ui.words(), "camera wings"));
  CHECK(contains(one.ui.words(), "Ctrl+Shift+Z"));
  CHECK(!contains(one.ui.words(), "find an action"));  // not itself
  one.write("LIGHT wor");
  CHECK(contains(one.ui.words(), "work light"));
  CHECK(!contains(one.ui.words(), "camera wings"));
  one.write(" nothing");
  CHECK(contains(one.ui.words(), "No action has these words."));
  one.ui.hit(kEnter);
  CHECK(!one.chosen);
  CHECK(EditUi::has_popup());
}

TEST_CASE("up and down mark another row, a click runs its own, and Esc closes without running") {
  PaletteUi one;
  one.open();
  one.write("camera of stalls");
  one.ui.hit(kEnter);
  CHECK(!one.chosen);  // "of" is no word of it
  one.ui.hit(kEscape);
  CHECK(!EditUi::has_popup());
  CHECK(!one.chosen);

  one.open();
  one.write("camera");
  one.ui.hit(kDown);
  one.ui.hit(kEnter);
  REQUIRE(one.chosen);
  CHECK(*one.chosen == UiCall{UiAction::kCamera, 1});
  one.open();
  one.write("camera");
  one.ui.hit(kUp);  // from the first row to the last
  one.ui.hit(kEnter);
  REQUIRE(one.chosen);
  CHECK(*one.chosen == UiCall{UiAction::kCamera, 1});
  one.open();
  CHECK(contains(one.ui.words(), "undo"));  // the field is empty again
  one.write("camera wings");
  for (float y = 100; y < 200 && !one.chosen; y += 5) one.ui.press(640, y);
  REQUIRE(one.chosen);
  CHECK(*one.chosen == UiCall{UiAction::kCamera, 1});
  one.open();
  one.ui.press(5, 700);  // beside it
  one.ui.frame();
  CHECK(!EditUi::has_popup());
  CHECK(!one.chosen);
}

TEST_CASE("what is not possible now is shown and not run") {
  PaletteUi one;
  one.has_log = false;
  one.ui.desk.release_all();
  one.open();
  CHECK(contains(one.ui.words(), "pause or play the log"));
  one.write("pause play");
  one.ui.hit(kEnter);
  CHECK(!one.chosen);
  one.ui.hit(kEscape);
  one.open();
  one.write("release all values");
  one.ui.hit(kEnter);
  CHECK(!one.chosen);
}

TEST_CASE("the menus of a window with recent rigs, a log and outputs fit beside each other in the side panel") {
  PaletteUi one;
  one.ui.desk.list_recent({"/rigs/hall.toml"});
  const UiPanels panels;
  float last_px = 0;
  float edge_px = 0;
  one.ui.more = [&] {
    ImGui::SetNextWindowSize({kPanelWidth, 200});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoTitleBar);
    ImGui::BeginMenuBar();
    (void)draw_menu(one.ui.desk, panels, true, &one.outputs);
    last_px = ImGui::GetItemRectMax().x;
    edge_px = ImGui::GetWindowPos().x + ImGui::GetWindowSize().x;
    ImGui::EndMenuBar();
    ImGui::End();
  };
  for (int i = 0; i < 3; ++i) one.ui.frame();
  CHECK(last_px > edge_px - 100);  // it is the last menu
  CHECK(last_px <= edge_px);
}

TEST_CASE("the File menu lists stations with their files, and asks for the one that is clicked") {
  PaletteUi one;
  ExchangeView exchange;
  const UiPanels panels;
  one.ui.more = [&] {
    ImGui::SetNextWindowPos({400, 0});
    ImGui::SetNextWindowSize({kPanelWidth, 200});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoTitleBar);
    ImGui::BeginMenuBar();
    (void)draw_menu(one.ui.desk, panels, false, nullptr, &exchange);
    ImGui::EndMenuBar();
    ImGui::End();
  };
  exchange.stations = {{"10.0.0.7:42424", "Desk", "grandMA3", "Default", true, "", {{"a", "old.mvr", "", 0}}},
                       {"10.0.0.8:42424", "Other", "", "Default", false, "refused", {}}};
  exchange.stations[0].files.push_back({"b", "new.mvr", "truss 2", 1'200'000});
  one.ui.press(420, 10);  // File
  CHECK(!exchange.looks);
  for (float y = 20; y < 140 && !exchange.looks; y += 5) {  // the mouse over the entry of stations
    ImGui::GetIO().MousePos = {430, y};
    for (int i = 0; i < 30 && !exchange.looks; ++i) one.ui.frame();
  }
  REQUIRE(exchange.looks);
  for (int i = 0; i < 3; ++i) one.ui.frame();
  const std::string words = one.ui.words();
  CHECK(contains(words, "Desk (grandMA3)"));
  CHECK(contains(words, "does not answer"));
  CHECK(words.find("new.mvr  1.2 MB  truss 2") < words.find("old.mvr"));  // the newest first
  const ImVec2 entry = ImGui::GetIO().MousePos;
  for (float x = 1010; x > 20 && !exchange.receive; x -= 90) {  // the list is beside the menu, to its left or right
    for (float y = 10; y < 220 && !exchange.receive; y += 6) {
      one.ui.press(x, y);
      if (exchange.receive || ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel)) {
        continue;
      }
      one.ui.press(420, 10);
      ImGui::GetIO().MousePos = entry;
      for (int i = 0; i < 30; ++i) one.ui.frame();
    }
  }
  REQUIRE(exchange.receive);
  CHECK(exchange.receive->address == "10.0.0.7:42424");
  CHECK((exchange.receive->uuid == "a" || exchange.receive->uuid == "b"));
  CHECK(!exchange.receive->name.empty());
}

TEST_CASE("Ctrl+A and Del between two pictures empty a field of text") {
  constexpr int kA = 65, kDelete = 261, kEnd = 269, kPress = 1, kRelease = 0, kControl = 2;  // of GLFW
  ImGuiContext* const context = ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.DisplaySize = {400, 300};
  io.KeyMap[ImGuiKey_A] = kA;
  io.KeyMap[ImGuiKey_Delete] = kDelete;
  io.KeyMap[ImGuiKey_End] = kEnd;
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  KeyTaps taps;
  std::array<char, 32> text{"Mover 3"};
  bool focus = true;
  const auto picture = [&] {
    const auto command = taps.hold(io.KeysDown);
    io.KeyCtrl = command && (*command & kControl) != 0;
    ImGui::NewFrame();
    if (std::exchange(focus, false)) ImGui::SetKeyboardFocusHere();
    ImGui::InputText("name", text.data(), text.size());
    ImGui::Render();
  };
  const auto tap = [&](int code, int mods) {
    for (const int action : {kPress, kRelease}) {
      taps.take_key(code, action, mods);
      io.KeysDown[code] = action == kPress;
    }
  };
  for (int i = 0; i < 3; ++i) picture();
  tap(kEnd, 0);  // the focus has selected all
  for (int i = 0; i < 3; ++i) picture();
  tap(kA, kControl);
  tap(kDelete, 0);
  for (int i = 0; i < 4; ++i) picture();
  CHECK(std::string(text.data()).empty());
  ImGui::DestroyContext(context);
}

TEST_CASE("Ctrl+P is the key of the palette") {
  const auto rows = key_rows();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [](const KeyRow& one) { return one.call.action == UiAction::kPalette; });
  REQUIRE(row != rows.end());
  CHECK(std::string(row->keys) == "Ctrl+P");
  const auto call = call_of({row->key, row->mods, false});
  REQUIRE(call);
  CHECK(call->action == UiAction::kPalette);
}

TEST_CASE("a locked window refuses each action that edits or sets levels, and no other one") {
  PaletteUi palette;
  UiDesk& desk = palette.ui.desk;
  desk.list_recent({"rig.toml"}, {"show.dmxlog"});
  const auto refused = [&] {
    std::vector<UiAction> actions;
    for (const UiActionItem& item : action_items(desk, true, &palette.outputs)) {
      if (item.why_not == locked_words()) actions.push_back(item.call.action);
    }
    std::sort(actions.begin(), actions.end());
    actions.erase(std::unique(actions.begin(), actions.end()), actions.end());
    return actions;
  };
  CHECK(refused().empty());
  CHECK(run_on_desk(desk, {UiAction::kLock})->text == locked_words());
  CHECK(desk.locked());
  using A = UiAction;
  std::vector<UiAction> expected{A::kUndo,      A::kOpen,       A::kOpenRecent, A::kOpenRecentLog, A::kDelete,
                                 A::kUnpatch,   A::kEditField,  A::kNudge,      A::kStoreCamera,   A::kHighlight,
                                 A::kLocate,    A::kReleaseAll, A::kTap};
  std::sort(expected.begin(), expected.end());
  CHECK(refused() == expected);
  CHECK(run_on_desk(desk, {UiAction::kLock})->text == "unlocked");
  CHECK(refused().empty());
}

}  // namespace
}  // namespace footlight::tools
