// Dialogs in a window of 640 x 360, in English and German: their buttons are within it.
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <unistd.h>

#include <imgui/imgui.h>
#include <imgui/imgui_internal.h>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tests/tools/footlight/words.h"
#include "tools/footlight/preview/ui/file_dialog.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/questions.h"
#include "tools/footlight/preview/ui/toasts.h"
#include "tools/footlight/preview/ui/ui_theme.h"

namespace footlight::tools {
namespace {

constexpr float kWide = 640;
constexpr float kHigh = 360;
constexpr const char* kLetters = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

struct SmallUi : testing::DrawnUi {
  SmallUi() : imgui(kWide, kHigh) {
    if (access(kLetters, R_OK) != 0) return;  // else with the smaller letters of Dear ImGui
    ImGuiIO& io = ImGui::GetIO();
    io.Fonts->Clear();
    io.Fonts->AddFontFromFileTTF(kLetters, 14, nullptr, ui_glyph_ranges());
    unsigned char* pixels = nullptr;
    int width = 0;
    int height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  }
  void draw() override { drawn(); }
  // All of the dialog is in the window, without scrolling.
  void check_dialog(const char* name) {
    for (int i = 0; i < 4; ++i) frame();
    CAPTURE(name);
    const ImGuiWindow* const dialog = ImGui::GetTopMostPopupModal();
    REQUIRE(dialog != nullptr);
    const ImRect place = dialog->Rect();
    CHECK(place.Min.x >= 0);
    CHECK(place.Min.y >= 0);
    CHECK(place.Max.x <= kWide);
    CHECK(place.Max.y <= kHigh);
    CHECK(dialog->ScrollMax.x == 0);
    CHECK(dialog->ScrollMax.y == 0);
  }

  testing::HeadlessImGui imgui;
  std::function<void()> drawn;
};

std::string long_path(const testing::TempFolder& folder) {
  std::string path = folder.path().string();
  for (int i = 0; i < 6; ++i) path += "/a folder with a long name " + std::to_string(i);
  return path + "/show.toml";
}

void check_all_dialogs() {
  const testing::TempFolder folder;
  const std::string path = long_path(folder);
  const std::string trouble = path + ": cannot be written: the disk is full; make room and save again";
  {
    SmallUi ui;
    CloseQuestion question;
    ui.drawn = [&] { (void)question.draw(path, trouble); };
    ui.check_dialog("close");
  }
  {
    SmallUi ui;
    OpenQuestion question;
    ui.drawn = [&] { (void)question.draw("Open " + path + "?", std::string(200, 'w') + " " + trouble, true); };
    ui.check_dialog("open");
  }
  for (const bool older : {false, true}) {
    SmallUi ui;
    ui.drawn = [&] { (void)draw_lost_edits("23:59, 30 November", older, 1); };
    for (int i = 0; i < 3; ++i) ui.frame();
    const ImGuiWindow* const line = ImGui::FindWindowByName("lost edits");
    REQUIRE(line != nullptr);
    CHECK(line->Rect().Max.x <= kWide);
  }
  {
    SmallUi ui;
    FileDialog dialog;
    const auto refuse = [&](const FileDialog::Chosen&) -> Status { return fail(ErrorCode::kIo, "{}", trouble); };
    ui.drawn = [&] { dialog.draw(1, refuse); };
    dialog.open({FileDialog::Use::kSave, folder.path().string(), "show.toml", folder.path().string(), {}});
    for (int i = 0; i < 4; ++i) ui.frame();
    testing::activate("###files", {"###Save"});
    for (int i = 0; i < 4; ++i) ui.frame();
    REQUIRE(ui.words().find("disk is full") != std::string::npos);
    ui.check_dialog("save as");
  }
  {
    SmallUi ui;
    const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
    UiDesk desk(rig.rig, rig.compiled);
    UiPanels open;
    OutputsView outputs;
    outputs.needs_hold = true;
    for (int i = 0; i < 30; ++i) {
      OutputRow& row = outputs.rows.emplace_back();
      row.endpoint = "sacn:1-2@10.0.0." + std::to_string(i + 1) + ",10.0.1.1%enp0s31f6";
      row.universes = {1, 2};
    }
    InputsView inputs;
    inputs.made_up = {"mock:chase"};
    const std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);
    ui.drawn = [&] {
      UiInput input;
      input.levels = levels;
      input.outputs = &outputs;
      input.inputs = &inputs;
      open.draw(desk, input, kWide, kHigh);
    };
    REQUIRE(open.open_words("devices", desk));
    for (int i = 0; i < 4; ++i) ui.frame();
    testing::activate("###Devices", {"###arm all ..."});
    ui.check_dialog("arm");
  }
}

TEST_CASE("in a window of 640 x 360 all of each dialog is in sight, with long paths, errors and many outputs") {
  check_all_dialogs();
}

TEST_CASE("in a window of 640 x 360 all of each dialog is in sight in German") {
  auto words = open_words("de", FOOTLIGHT_WORDS_FOLDER);
  REQUIRE(words);
  const testing::Spoken german(std::move(*words));
  check_all_dialogs();
}

TEST_CASE("each panel opens within a window of 640 x 360 and one of 7680 x 4320, at their scales") {
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  const float large = ui_scale_for(4320, 4320);
  CHECK(large == 3);
  for (const auto& [wide, high, scale] : {std::tuple{kWide, kHigh, 1.0f}, {7680.0f, 4320.0f, large}}) {
    SmallUi ui;
    ImGui::GetIO().DisplaySize = {wide, high};
    ImGui::GetIO().FontGlobalScale = scale;
    UiDesk desk(rig.rig, rig.compiled);
    UiPanels open;
    OutputsView outputs;
    InputsView inputs;
    MessageLog messages;
    ReportView report;
    const std::vector<std::uint8_t> levels(rig.compiled.universes.size() * kSlotCountMax);
    ui.drawn = [&, w = wide, h = high, s = scale] {
      UiInput input;
      input.levels = levels;
      input.outputs = &outputs;
      input.inputs = &inputs;
      input.messages = &messages;
      input.report = &report;
      input.scale = s;
      open.draw(desk, input, w, h);
    };
    for (std::size_t i = 0; i < panels().size(); ++i) {
      const PanelInfo& info = panels()[i];
      CAPTURE(std::string(info.word));
      CAPTURE(wide);
      open.set_open(i, true, desk);
      for (int frame = 0; frame < 4; ++frame) ui.frame();
      const ImGuiWindow* const window = ImGui::FindWindowByName(("###" + std::string(info.title)).c_str());
      REQUIRE(window != nullptr);
      const ImRect place = window->Rect();
      CHECK(place.Min.x >= 0);
      CHECK(place.Min.y >= 0);
      CHECK(place.Max.x <= wide);
      CHECK(place.Max.y <= high);
      CHECK(place.GetWidth() <= info.place.width * scale + 1);
      CHECK(place.GetWidth() >= std::min(info.place.width * scale, wide - 32 * scale) - 1);
      CHECK(place.GetHeight() >=
            std::min({info.place.height * scale, info.place.height_share * high, 150 * scale}) - 1);
      open.set_open(i, false, desk);
      ui.frame();
    }
  }
}

TEST_CASE("after a recording a line offers to play it, or goes away") {
  SmallUi ui;
  std::optional<RecordedAnswer> answer;
  ui.drawn = [&] {
    if (const auto one = draw_recorded("show_2026-11-28_05-40-00.dmxlog", 1)) answer = one;
  };
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(ui.words().find("show_2026-11-28_05-40-00.dmxlog") != std::string::npos);
  CHECK(!answer);
  for (const auto& [button, expected] :
       {std::pair{"###Play it", RecordedAnswer::kPlay}, {"###Close", RecordedAnswer::kClose}}) {
    testing::activate("recorded", {button});
    for (int i = 0; i < 3; ++i) ui.frame();
    CHECK(answer == expected);
  }
  CHECK(ImGui::FindWindowByName("recorded")->Rect().Max.x <= kWide);
}

TEST_CASE("messages lie below a dialog, and over the stage without one") {
  SmallUi ui;
  MessageLog log;
  log.add("no route", true, "", 0);
  CloseQuestion question;
  bool asks = false;
  ui.drawn = [&] {
    draw_toasts(log, 1, {kWide, kHigh}, 1);
    if (asks) (void)question.draw("show.toml", "");
  };
  const auto over = [&] { return ImGui::GetForegroundDrawList()->VtxBuffer.Size; };
  const auto below = [&] { return ImGui::GetBackgroundDrawList()->VtxBuffer.Size; };
  ui.frame();
  CHECK(over() > 0);
  CHECK(below() == 0);
  asks = true;
  for (int i = 0; i < 3; ++i) ui.frame();
  CHECK(over() == 0);
  CHECK(below() > 0);
}

}  // namespace
}  // namespace footlight::tools
