// Every word that panels, menus, the palette, the side panel and questions draw is in the catalog. Texts that are
// translated are drawn in brackets; what stands outside of them must be data.
#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <unistd.h>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "fixtures/model/features.h"
#include "render/plan.h"
#include "tests/support/definition_files.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/edit_ui.h"
#include "tests/tools/footlight/po_file.h"
#include "tests/tools/footlight/words.h"
#include "tools/footlight/preview/preview_panel.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/live_band.h"
#include "tools/footlight/preview/ui/menu.h"
#include "tools/footlight/preview/ui/palette.h"
#include "tools/footlight/preview/ui/toasts.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

using testing::BracketWords;
using testing::EditDesk;
using testing::HeadlessImGui;
using testing::rig_with_cameras;
using testing::Spoken;
using testing::TempFolder;

// What is outside of brackets, which may be nested.
std::string outside(std::string_view text) {
  std::string rest;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view two = text.substr(i, 2);
    if (two == testing::kOpens || two == testing::kCloses) {
      depth += two == testing::kOpens ? 1 : -1;
      rest += ' ';
      ++i;
    } else if (depth == 0) {
      rest += text[i];
    }
  }
  return rest;
}

// Letters that are no words: units, keys, axes, and names that are the same in every language.
const std::set<std::string, std::less<>>& no_words() {
  static const std::set<std::string, std::less<>> all{
      "m",   "s",  "ms",        "us",  "Hz",  "K",     "lm",   "lx",     "MB",   "MiB", "KiB", "px",  "x",
      "y",   "z",  "X",         "Y",   "Z",   "A",     "B",    "C",      "E",    "F",   "G",   "H",   "I",
      "K",   "L",  "M",         "N",   "O",   "P",     "Q",    "R",      "T",    "V",   "W",   "D",   "°",
      "p",   "F1", "F2",        "F3",  "F4",  "F5",    "F6",   "F7",     "F8",   "F9",  "F10", "F11", "F12",
      "GPU", "EV", "FOOTLIGHT", "p50", "p90", "built", "sacn", "artnet", "mock", "midi"};
  return all;
}

// Names in the rig and in its types: data.
std::vector<std::string> names_in(const fixtures::Rig& rig) {
  std::vector<std::string> names{rig.name};
  for (const auto& fixture : rig.fixtures) names.push_back(fixture.name);
  for (const auto& camera : rig.cameras) names.push_back(camera.name);
  for (const fixtures::FixtureType& type : rig.types) {
    names.insert(names.end(), {type.name, type.manufacturer});
    for (const fixtures::Mode& mode : type.modes) {
      names.push_back(mode.name);
      for (const fixtures::Channel& channel : mode.channels) {
        names.push_back(name_of(channel));
        for (const fixtures::ChannelFunction& function : channel.functions) {
          names.insert(names.end(), {function.attribute, function.name});
          for (const auto& set : function.sets) names.push_back(set.name);
        }
      }
    }
    for (const auto& wheel : type.wheels) {
      names.push_back(wheel.name);
      for (const auto& slot : wheel.slots) names.push_back(slot.name);
    }
  }
  return names;
}

// The words outside of brackets that are no data.
std::vector<std::string> bare_words(const std::string& drawn, std::vector<std::string> data) {
  std::string rest = outside(drawn);
  std::sort(data.begin(), data.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (const std::string& name : data) {
    if (name.empty()) continue;
    for (std::size_t at = rest.find(name); at != std::string::npos; at = rest.find(name, at))
      rest.replace(at, name.size(), " ");
  }
  std::vector<std::string> words;
  std::string word;
  for (const char c : rest + ' ') {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      word += c;
      continue;
    }
    const bool power = word.find_first_not_of("0123456789e") == std::string::npos && word[0] != 'e';  // "1.939e-05"
    const bool letters = !power && std::any_of(word.begin(), word.end(),
                                               [](char l) { return std::isalpha(static_cast<unsigned char>(l)) != 0; });
    if (letters && !no_words().contains(word)) words.push_back(word);
    word.clear();
  }
  return words;
}

class WordsUi : public testing::DrawnUi {
 public:
  WordsUi() : edit_(rig_with_cameras()), desk(edit_.desk), levels(desk.compiled().universes.size() * kSlotCountMax) {
    levels[0] = 40;
    data = names_in(desk.rig());
    data.insert(data.end(), {"/shows/club.toml", "hall.toml", "/rigs/"});
  }
  void draw() override {
    input.levels = levels;
    input.now_ns += kNsPerS / 60;
    open.draw(desk, input, ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    if (more) more();
  }
  // The panel alone and large: words that do not fit are not logged.
  std::string panel(const char* word) {
    for (std::size_t i = 0; i < panels().size(); ++i) open.set_open(i, false, desk);
    open.set_open(panel_of(word), true, desk);
    for (int i = 0; i < 3; ++i) {
      frame();
      const std::string name = "###" + std::string(panels()[panel_of(word)].title);
      ImGui::SetWindowPos(name.c_str(), {0, 0});
      ImGui::SetWindowSize(name.c_str(), {1800, 2900});
    }
    frame();
    return words();
  }
  void check(const std::string& drawn) {
    CHECK(drawn.find(testing::kOpens) != std::string::npos);
    for (const std::string& word : bare_words(drawn, data)) CHECK_MESSAGE(false, "'", word, "' is outside: ", drawn);
  }

  HeadlessImGui imgui{1900, 3000};
  EditDesk edit_;
  UiDesk& desk;
  std::vector<std::uint8_t> levels;
  UiInput input;
  UiPanels open;
  std::function<void()> more;  // draws more than panels
  std::vector<std::string> data;
};

// Every text that was asked for in this program is in the list of words.
class Asked {
 public:
  Asked() : spoken_(std::make_unique<BracketWords>(texts_)) {
    for (const auto& entry : testing::read_po(FOOTLIGHT_SOURCE_DIR "/po/footlight.pot")) {
      known_.insert(entry.one);
      known_.insert(entry.many);
    }
  }
  void check() const {
    CHECK(!texts_.empty());
    for (const std::string& text : texts_) {
      const bool key = text.size() == 1 || (text.size() <= 3 && text[0] == 'F') || text == "F1, ?";
      CHECK_MESSAGE((key || known_.contains(text)), "'", text, "' is not in po/footlight.pot: run tools/make_words");
    }
  }

 private:
  std::set<std::string> texts_;
  std::set<std::string> known_;
  Spoken spoken_;
};

PumpStatus three_ports() {
  PumpStatus status;
  status.ports.resize(3);
  const std::array names{"sacn:1", "artnet:2", "midi:Pads"};
  for (std::size_t i = 0; i < 3; ++i) status.ports[i].name = names[i];
  status.ports[0].universes.push_back({1, 3});
  status.ports[0].frames = 3;
  status.ports[0].port.rejected = status.ports[0].port.dropped = status.ports[0].port.errors = 2;
  status.ports[0].refused = status.ports[0].unrouted = 2;
  status.ports[1].universes.push_back({2, 0});
  status.ports[1].state = PortState::kGone;
  status.ports[2].state = PortState::kEnded;
  return status;
}

OutputsView many_outputs() {
  OutputsView view;
  const std::array states{ArmState::kOff, ArmState::kOpening, ArmState::kArmed, ArmState::kClosing};
  for (const ArmState state : states) {
    OutputRow& row = view.rows.emplace_back();
    row.endpoint = "sacn:1";
    row.universes = {1, 9};
    row.left_out = {9};
    row.state = state;
    row.made_up = state == ArmState::kArmed;
    row.can_move = state == ArmState::kOff;
  }
  view.universes = {1, 2};
  return view;
}

TEST_CASE("panels draw no word outside of the catalog, with nothing selected, with one fixture and with several") {
  Asked asked;
  WordsUi ui;
  for (const int selected : {0, 1, 3}) {
    for (int i = 0; i < selected; ++i) ui.desk.select(i, i > 0);
    if (selected == 3) {
      ui.desk.take({0, 0}, 3, ui.levels);
      ui.desk.set_highlight(true);
    }
    for (const char* word :
         {"keys", "universes", "fixtures", "inspector", "timeline", "devices", "messages", "report"}) {
      INFO(word);
      ui.check(ui.panel(word));
    }
  }
  asked.check();
}

TEST_CASE("the panel of a log that plays draws no word outside of the catalog") {
  Asked asked;
  WordsUi ui;
  Transport transport;
  transport.duration_ns = 60 * kNsPerS;
  transport.known_ns = 30 * kNsPerS;
  transport.repeat_from(kNsPerS);
  ui.input.transport = &transport;
  REQUIRE(ui.desk.add_marker(2 * kNsPerS));
  ui.check(ui.panel("timeline"));
  ui.check(ui.panel("devices"));
  ui.check(ui.panel("inspector"));
  asked.check();
}

TEST_CASE("inputs and outputs in any state draw no word outside of the catalog") {
  Asked asked;
  WordsUi ui;
  const PumpStatus status = three_ports();
  OutputsView outputs = many_outputs();
  InputsView inputs;
  inputs.inputs = {"sacn:1", "mock:chase"};
  inputs.made_up = {"mock:chase"};
  inputs.by_hand = trf_n("{} slot by hand", "{} slots by hand", 2, 2);
  inputs.dark_by_hand = inputs.has_patterns = true;
  ui.input.status = &status;
  ui.input.outputs = &outputs;
  ui.input.inputs = &inputs;
  ui.data.insert(ui.data.end(), {"sacn:1-9", "enttec-pro", "mock:chase", "chase", "rainbow", "pulse", "sweep", "ramp",
                                 "noise", "Pads"});
  for (const Darkness darkness : {Darkness::kNone, Darkness::kAsked, Darkness::kSilence}) {
    outputs.darkness = darkness;
    inputs.learns = darkness == Darkness::kNone;
    ui.check(ui.panel("devices"));
    ui.check(live_words(outputs) + blackout_words(outputs) + testing::kOpens + testing::kCloses);
  }
  ui.check(made_up_words(inputs));
  ui.check(hand_blackout_words(inputs) + hand_blackout_end());
  asked.check();
}

TEST_CASE("the comparison of levels and nine universes draw no word outside of the catalog") {
  Asked asked;
  WordsUi ui;
  ui.desk.comparison().a = keep_levels(ui.desk.compiled().universes, ui.levels, std::nullopt);
  ui.levels[0] = 90;
  ui.check(ui.panel("universes"));
  ui.desk.comparison().b = keep_levels(ui.desk.compiled().universes, ui.levels, std::nullopt);
  ui.check(ui.panel("universes"));
  asked.check();
}

TEST_CASE("the library draws no word outside of the catalog") {
  Asked asked;
  const TempFolder folder;
  folder.write("one.qxf", testing::qxf_head("Robe", "Spot One", {{"short", 3}, {"long", 4}}));
  folder.write("cut.qxf", "<?xml version=\"1.0\"?><FixtureDefinition><Manufacturer>Robe</Manufacturer><Model>Cut");
  WordsUi ui;
  ui.desk.list_definitions_in({{folder.path().string()}});
  std::string drawn = ui.panel("library");
  while (drawn.find("<<stop>>") != std::string::npos) {
    std::this_thread::yield();
    drawn = ui.words();
  }
  CHECK(drawn.find("<<cannot be read>>") != std::string::npos);
  CHECK(drawn.find("<<moving head>>") != std::string::npos);
  // Names of definitions are in a table with them: heads, hints and kinds are what is left of its words.
  for (const char* head : {"Maker", "Name", "Kind", "Modes", "Slots", "File"}) {
    CHECK(drawn.find("<<" + std::string(head) + ">>") != std::string::npos);
  }
  asked.check();
}

TEST_CASE("the report draws no word outside of the catalog but names of passes and knobs") {
  Asked asked;
  WordsUi ui;
  ReportView view;
  ui.input.report = &view;
  view.picture = 1;
  view.passes = {{"beams", 3}, {"tonemap", 1}};
  view.picture_ms = 4;
  view.memory = {{"gobos", 1 << 20}, {"beams by tile", 1 << 10}};
  view.bytes = 1 << 22;
  view.has_left_out = true;
  for (const fixtures::Feature& feature : fixtures::features()) {
    view.left_out.rows.push_back(
        {.name = std::string(feature.name), .text = std::string(feature.without), .times = {}});
    ui.data.emplace_back(feature.name);
  }
  fixtures::Needs needs{};
  for (const auto& pass : render::left_out_passes(needs, {})) {
    view.left_out.rows.push_back(
        {.name = std::string(pass.name), .text = std::string(pass.loss), .pass = true, .times = {}});
  }
  ui.data.insert(ui.data.end(), {"beams", "tonemap"});
  ui.check(ui.panel("report"));
  for (int tab = 0; tab < 4; ++tab) {
    ImGuiTabBar& bar = *ImGui::GetCurrentContext()->TabBars.TryGetMapData(0);
    bar.NextSelectedTabId = bar.Tabs[tab].ID;
    for (int i = 0; i < 3; ++i) ui.frame();
    ui.check(ui.words());
  }
  asked.check();
}

TEST_CASE("menus, the palette and questions draw no word outside of the catalog") {
  Asked asked;
  WordsUi ui;
  OutputsView outputs = many_outputs();
  ui.desk.list_recent({"/rigs/hall.toml"});
  ui.desk.select(0, false);
  ExchangeView exchange;
  exchange.stations = {{"10.0.0.7:42424", "Desk", "grandMA3", "Default", true, "", {}},
                       {"10.0.0.8:42424", "Other", "", "Default", false, "", {}}};
  exchange.receiving = "old.mvr";
  ui.data.insert(ui.data.end(), {"Desk", "grandMA3", "Other", "old.mvr", "show.mvr", "10.0.0.7:42424"});
  for (const bool shares : {false, true}) {
    exchange.sharing = shares ? "show.mvr" : "";
    for (const char* menu : {"File", "Panels", "Edit", "View", "Play", "Outputs", "Receive a rig"}) {
      ui.more = [&] {
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({kPanelWidth, 200});
        ImGui::Begin("panel", nullptr, ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoTitleBar);
        ImGui::BeginMenuBar();
        ImGui::OpenPopup(("###" + std::string(menu)).c_str());
        (void)draw_menu(ui.desk, ui.open, true, &outputs, &exchange);
        ImGui::EndMenuBar();
        ImGui::End();
      };
      for (int i = 0; i < 3; ++i) ui.frame();
      INFO(menu);
      ui.check(ui.words());
    }
  }
  ui.more = {};
  for (int i = 0; i < 3; ++i) ui.frame();
  Palette palette;
  palette.open();
  ui.more = [&] { (void)palette.draw(ui.desk, true, &outputs, 1); };
  for (int i = 0; i < 3; ++i) ui.frame();
  ui.check(ui.words());
  CloseQuestion close;
  OpenQuestion opens;
  ui.more = [&] { (void)close.draw("/shows/club.toml", ""); };
  for (int i = 0; i < 3; ++i) ui.frame();
  ui.check(ui.words());
  ui.more = [&] { (void)opens.draw(trf("Open {}?", "show.mvr"), tr(" Armed outputs go dark."), true); };
  for (int i = 0; i < 3; ++i) ui.frame();
  ui.check(ui.words());
  for (const bool older : {false, true}) {
    ui.more = [&] { (void)draw_lost_edits("12:31", older, 1); };
    for (int i = 0; i < 3; ++i) ui.frame();
    ui.check(ui.words());
  }
  asked.check();
}

TEST_CASE("each action of the palette is translated, with its keys") {
  Asked asked;
  WordsUi ui;
  const OutputsView outputs = many_outputs();
  for (const UiActionItem& item : action_items(ui.desk, true, &outputs)) {
    INFO(item.label);
    CHECK(bare_words(item.label, ui.data).empty());
    CHECK(bare_words(item.keys, {}).empty());
    CHECK(item.label.starts_with(testing::kOpens));
  }
  asked.check();
}

TEST_CASE("the palette finds an action by a word of the language, in capitals too") {
  const Spoken german(std::make_unique<testing::TableWords>(
      std::map<std::string, std::string>{{"work light", "Arbeitslicht über allem"}}));
  WordsUi ui;
  Palette palette;
  std::optional<UiCall> chosen;
  palette.open();
  ui.more = [&] {
    if (const auto one = palette.draw(ui.desk, true, nullptr, 1)) chosen = one;
  };
  for (int i = 0; i < 3; ++i) ui.frame();
  for (const unsigned c : {0xdcu, 0x42u, 0x45u, 0x52u}) ImGui::GetIO().AddInputCharacter(c);  // "ÜBER"
  ui.frame();
  const std::string words = ui.words();
  CHECK(words.find("Arbeitslicht über allem") != std::string::npos);
  CHECK(words.find("undo") == std::string::npos);
}

TEST_CASE("the side panel draws no word outside of the catalog") {
  Asked asked;
  HeadlessImGui imgui(800, 3000);
  PreviewFacts facts;
  PreviewControls controls;
  facts.rig = "Club";
  facts.device = "llvmpipe";
  facts.cameras = {"stalls"};
  facts.can_edit = facts.can_haze = facts.has_log = true;
  facts.machines = 1;
  facts.passes = {{"beams", 1}};
  facts.shadows = 2;
  facts.shadows_lost = 1;
  facts.flashes_harmful = true;
  const std::vector<std::string> data{"Club", "llvmpipe", "stalls", "beams", "agx"};
  for (int kind = 0; kind < 3; ++kind) {
    facts.quality.error = kind == 1 ? 0.001 : 0;
    facts.quality.ms = kind == 2 ? 8 : 0;
    controls.balances_white = controls.work_light = kind == 1;
    controls.auto_exposure = kind == 2;
    facts.error.samples = kind == 1 ? 100 : 0;
    facts.flashes_held = kind == 2;
    controls.panel = kind == 2 ? PanelState::kStrip : PanelState::kFull;
    std::string words;
    for (int i = 0; i < 4; ++i) {
      ImGui::NewFrame();
      if (i == 3) ImGui::LogToClipboard();
      draw_panel(facts, controls, nullptr, nullptr, 1, [] {});
      if (i == 3) ImGui::LogFinish();
      ImGui::Render();
    }
    words = ImGui::GetClipboardText();
    for (const std::string& word : bare_words(words, data)) CHECK_MESSAGE(false, "'", word, "' is outside: ", words);
  }
  asked.check();
}

TEST_CASE("in German the menus fit beside each other in the side panel") {
  if (languages_in(FOOTLIGHT_WORDS_FOLDER).empty()) return;
  REQUIRE(choose_words("de", FOOTLIGHT_WORDS_FOLDER));
  {
    WordsUi ui;
    OutputsView outputs = many_outputs();
    ui.desk.list_recent({"/rigs/hall.toml"});
    float last_px = 0;
    float edge_px = 0;
    ui.more = [&] {
      ImGui::SetNextWindowSize({kPanelWidth, 200});
      ImGui::Begin("panel", nullptr, ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoTitleBar);
      ImGui::BeginMenuBar();
      (void)draw_menu(ui.desk, ui.open, true, &outputs);
      last_px = ImGui::GetItemRectMax().x;
      edge_px = ImGui::GetWindowPos().x + ImGui::GetWindowSize().x;
      ImGui::EndMenuBar();
      ImGui::End();
    };
    for (int i = 0; i < 3; ++i) ui.frame();
    CHECK(last_px <= edge_px);
  }
  use_words(nullptr);
}

TEST_CASE("the font has every letter of every translation") {
  HeadlessImGui imgui(800, 600);
  ImGuiIO& io = ImGui::GetIO();
  const char* const path = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  if (access(path, R_OK) != 0) {
    MESSAGE("skipped: needs DejaVu Sans; 'sudo apt-get install fonts-dejavu-core'");
    return;
  }
  ImFont* const font = io.Fonts->AddFontFromFileTTF(path, 14, nullptr, ui_glyph_ranges());
  unsigned char* pixels = nullptr;
  int width = 0;
  int height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  std::string letters = "ÄÖÜäöüßéèçñåøæŁłŐőŠšČčŽžĞğİıΩωЖж°–„“…";
  for (const std::string& language : {std::string("de")}) {
    for (const auto& entry : testing::read_po(FOOTLIGHT_SOURCE_DIR "/po/" + language + ".po")) {
      for (const std::string& text : entry.translated) letters += text;
    }
  }
  for (const char* at = letters.c_str(); *at != 0;) {
    unsigned code = 0;
    at += ImTextCharFromUtf8(&code, at, nullptr);
    if (code >= ' ') CHECK_MESSAGE(font->FindGlyphNoFallback(static_cast<ImWchar>(code)) != nullptr, code);
  }
}

}  // namespace
}  // namespace footlight::tools
