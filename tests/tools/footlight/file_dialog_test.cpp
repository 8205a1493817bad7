// The dialog that opens and saves files, with a keyboard and without a window.
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include <sys/stat.h>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tools/footlight/preview/ui/file_dialog.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kDownKey = 1;
constexpr int kEnterKey = 13;
constexpr int kBackKey = 8;
constexpr int kEscapeKey = 27;

struct DialogUi : testing::DrawnUi {
  DialogUi() {
    ImGuiIO& io = ImGui::GetIO();
    io.KeyMap[ImGuiKey_Enter] = kEnterKey;
    io.KeyMap[ImGuiKey_Escape] = kEscapeKey;
    io.KeyMap[ImGuiKey_DownArrow] = kDownKey;
    io.KeyMap[ImGuiKey_Backspace] = kBackKey;
    fs::create_directories(folder.file("shows/tour"));
    std::ofstream(folder.file("shows/hall.toml")) << "rig";
    std::ofstream(folder.file("shows/tour/club.mvr")) << "rig";
    std::ofstream(folder.file("shows/notes.txt")) << "text";
  }
  void draw() override {
    dialog.draw(1, [this](const FileDialog::Chosen& one) -> Status {
      if (!refuses.empty()) return fail(ErrorCode::kIo, "{}", refuses);
      chosen = one;
      return {};
    });
  }
  void open(FileDialog::Use use, const std::string& name = "") {
    dialog.open({use, folder.file("shows"), name, folder.path().string(), {{"home", folder.path().string()}}});
    settle();
  }
  // Until the folder is read.
  void settle() {
    for (int i = 0; i < 4; ++i) frame();
    while (words().find("reading ...") != std::string::npos) std::this_thread::yield();
    frame();
  }
  void type(const std::string& text) {
    for (const char c : text) ImGui::GetIO().AddInputCharacter(static_cast<unsigned>(c));
    frame();
    frame();
  }
  void hit(int key) {
    ImGui::GetIO().KeysDown[key] = true;
    frame();
    ImGui::GetIO().KeysDown[key] = false;
    frame();
    settle();
  }
  void press_id(const char* id) {
    testing::activate("###files", {id});
    frame();
    settle();
  }
  [[nodiscard]] std::string marked() const {
    return dialog.list().marked() < 0 ? "" : dialog.list().at(static_cast<std::size_t>(dialog.list().marked())).name;
  }

  testing::HeadlessImGui imgui{1280, 720};
  const testing::TempFolder folder;
  FileDialog dialog;
  std::optional<FileDialog::Chosen> chosen;  // and taken
  std::string refuses;                       // with this error; empty: nothing
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("words and Enter open a file, folders are entered, and Backspace in an empty field goes back to them") {
  DialogUi ui;
  ui.open(FileDialog::Use::kOpen);
  const std::string words = ui.words();
  CHECK(has(words, "hall.toml"));
  CHECK(has(words, "tour/"));
  CHECK(has(words, "3 B"));
  CHECK(!has(words, "notes.txt"));
  ui.type("tour");
  ui.hit(kEnterKey);
  CHECK(ui.dialog.folder() == ui.folder.file("shows/tour"));
  CHECK(has(ui.words(), "club.mvr"));
  ui.hit(kBackKey);
  CHECK(ui.dialog.folder() == ui.folder.file("shows"));
  CHECK(ui.marked() == "tour");
  ui.type("x");
  ui.hit(kBackKey);  // deletes the letter
  CHECK(ui.dialog.folder() == ui.folder.file("shows"));
  ui.hit(kDownKey);
  ui.hit(kDownKey);
  CHECK(ui.marked() == "hall.toml");
  ui.hit(kEnterKey);
  REQUIRE(ui.chosen);
  CHECK(ui.chosen->path == ui.folder.file("shows/hall.toml"));
  CHECK(!ui.dialog.is_open());
}

TEST_CASE("buttons go to the folder above, open what is marked and close the dialog, and so does Esc") {
  DialogUi ui;
  ui.open(FileDialog::Use::kOpen);
  ui.press_id("###folder above");
  CHECK(ui.dialog.folder() == ui.folder.path().string());
  CHECK(ui.marked() == "shows");
  ui.press_id("###Open");
  CHECK(ui.dialog.folder() == ui.folder.file("shows"));
  ui.type(ui.folder.file("shows/tour/club.mvr"));  // a path
  ui.press_id("###Open");
  REQUIRE(ui.chosen);
  CHECK(ui.chosen->path == ui.folder.file("shows/tour/club.mvr"));
  ui.chosen.reset();
  ui.open(FileDialog::Use::kOpen);
  ui.press_id("###Cancel");
  CHECK(!ui.dialog.is_open());
  ui.open(FileDialog::Use::kOpen);
  CHECK(ui.dialog.is_open());
  ui.hit(kEscapeKey);
  CHECK(!ui.dialog.is_open());
  CHECK(!ui.chosen);
}

TEST_CASE("a file is saved under the name in the field, and one that is there is replaced only after a question") {
  DialogUi ui;
  ui.open(FileDialog::Use::kSave, "hall.toml");
  ui.press_id("###Save");
  CHECK(!ui.chosen);
  CHECK(has(ui.words(), "There is a file hall.toml."));
  ui.press_id("###Stay");
  CHECK(!ui.chosen);
  CHECK(ui.dialog.is_open());
  ui.press_id("###Save");
  ui.press_id("###Replace");
  REQUIRE(ui.chosen);
  CHECK(ui.chosen->replaces);
  CHECK(ui.chosen->path == ui.folder.file("shows/hall.toml"));
  ui.chosen.reset();
  ui.open(FileDialog::Use::kSave, "second");
  ui.press_id("###Save");
  REQUIRE(ui.chosen);
  CHECK(!ui.chosen->replaces);
  CHECK(ui.chosen->path == ui.folder.file("shows/second.toml"));
}

TEST_CASE("a dialog whose file cannot be saved stays open with the reason, and closes once it is saved") {
  DialogUi ui;
  ui.refuses = "hall.toml: the disk is full";
  ui.open(FileDialog::Use::kSave, "hall.toml");
  ui.press_id("###Save");
  ui.press_id("###Replace");
  CHECK(ui.dialog.is_open());
  CHECK(has(ui.words(), "the disk is full"));
  CHECK(!has(ui.words(), "There is a file"));
  ui.refuses.clear();
  ui.press_id("###Save");
  CHECK(!has(ui.words(), "the disk is full"));
  ui.press_id("###Replace");
  CHECK(ui.chosen);
  CHECK(!ui.dialog.is_open());
}

TEST_CASE("a rig is not saved without a name, as a folder, as a pipe or as a device") {
  DialogUi ui;
  fs::create_directories(ui.folder.file("shows/old.toml"));
  REQUIRE(mkfifo(ui.folder.file("shows/pipe.toml").c_str(), 0600) == 0);
  fs::create_symlink("/dev/null", ui.folder.file("shows/null.toml"));
  for (const auto& [name, said] : {std::pair{".toml", "no name before its ending"},
                                   {"old", "is a folder"},
                                   {"pipe.toml", "is a pipe or a device"},
                                   {"null.toml", "is a pipe or a device"}}) {
    CAPTURE(name);
    ui.open(FileDialog::Use::kSave, name);
    ui.press_id("###Save");
    CHECK(!ui.chosen);
    CHECK(ui.dialog.is_open());
    CHECK(has(ui.words(), said));
    CHECK(!has(ui.words(), "There is a file"));
  }
}

TEST_CASE("a folder that cannot be read is named, and a file that is not there opens nothing") {
  DialogUi ui;
  ui.open(FileDialog::Use::kOpen);
  ui.type("./missing/a.toml");
  ui.hit(kEnterKey);
  CHECK(!ui.chosen);
  CHECK(has(ui.words(), "missing/a.toml: there is no such file"));
  fs::remove_all(ui.folder.file("shows"));
  ui.open(FileDialog::Use::kOpen);
  CHECK(has(ui.words(), ui.folder.file("shows") + ": No such file or directory"));
  CHECK(ui.dialog.is_open());
  ui.press_id("###folder above");
  CHECK(!has(ui.words(), "No such file"));
}

}  // namespace
}  // namespace footlight::tools
