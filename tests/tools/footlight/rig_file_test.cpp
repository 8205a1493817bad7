// Rigs that are edited and saved, by programs that are killed, too.
#include "tools/footlight/edit/rig_file.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "fixtures/builtin/builtin.h"
#include "fixtures/edit/add_fixtures.h"
#include "fixtures/files/definition_list.h"
#include "fixtures/files/toml/fixture_toml_full.h"
#include "tests/support/definition_files.h"
#include "tests/tools/footlight/edit_rigs.h"
#include "tools/footlight/edit/autosave.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using tools::RigFile;
using tools::SaveReport;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string refused(RigFile& file) {
  const auto report = file.save();
  REQUIRE(!report);
  return report.error().message;
}

TEST_CASE("a rig of another program is saved beside it, with its definitions, and reads back as edited") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  const std::string before = read(path);
  RigFile file = opened_file(path);
  CHECK(file.target() == folder.file("show.toml"));
  REQUIRE(file.rig().fixtures.size() == 4);
  lift(file, {0, 2});
  const SaveReport report = saved(file);
  CHECK(report.path == folder.file("show.toml"));
  CHECK(report.old.empty());
  CHECK(read(path) == before);
  CHECK(fs::exists(folder.file("show_files/B.gdtf")));
  CHECK(read(folder.file("show_files/leg.3ds")) == "mesh");
  const RigFile again = opened_file(folder.file("show.toml"));
  REQUIRE(again.rig().fixtures.size() == 4);
  CHECK(fixtures::position_of(again.rig().fixtures[0]) == glm::dvec3(1, 0, 5.5));
  CHECK(fixtures::position_of(again.rig().fixtures[1]) == glm::dvec3(2, 0, 5));
  CHECK(again.rig().types.front().name == "Bar");

  lift(file, {0});
  CHECK(saved(file).old.empty());  // its own file from before is not kept
  CHECK(fixtures::position_of(opened_file(folder.file("show.toml")).rig().fixtures[0]).z == 6);
  CHECK(!fs::exists(folder.file("show.toml~")));
}

TEST_CASE("a rig that is saved as another file belongs to that from then on, and replaces one only if that is meant") {
  const TempFolder folder;
  const std::string path = folder.file("a.toml");
  RigFile show = opened_file(write_show(folder));
  REQUIRE(show.save_as(path, false));
  CHECK(show.target() == path);
  CHECK(show.path() == path);
  CHECK(!fs::exists(folder.file("show.toml")));
  CHECK(fs::exists(folder.file("a_files/B.gdtf")));
  const std::string first = read(path);
  lift(show, {0});
  folder.write("b.toml", "# another rig\n");
  const auto refused_as = show.save_as(folder.file("b.toml"), false);
  REQUIRE(!refused_as);
  CHECK(contains(refused_as.error().message, "b.toml: exists already"));
  CHECK(show.target() == path);
  CHECK(read(folder.file("b.toml")) == "# another rig\n");
  REQUIRE(show.save_as(folder.file("b.toml"), true));
  CHECK(read(folder.file("b.toml~")) == "# another rig\n");
  CHECK(read(path) == first);
  lift(show, {0});
  CHECK(saved(show).path == folder.file("b.toml"));
  CHECK(fixtures::position_of(opened_file(folder.file("b.toml")).rig().fixtures[0]).z == 6);
}

TEST_CASE("a rig is not saved as a name without a beginning, a folder or a pipe, and stays that of its file") {
  const TempFolder folder;
  RigFile show = opened_file(write_show(folder));
  fs::create_directories(folder.file("old.toml"));
  REQUIRE(mkfifo(folder.file("pipe.toml").c_str(), 0600) == 0);
  for (const auto& [name, said] : {std::pair{".toml", "no name before its ending"},
                                   {"old.toml", "is a folder"},
                                   {"pipe.toml", "is a pipe or a device"}}) {
    CAPTURE(name);
    const auto report = show.save_as(folder.file(name), true);
    REQUIRE(!report);
    CHECK(contains(report.error().message, said));
    CHECK(show.target() == folder.file("show.toml"));
  }
  CHECK(fs::is_fifo(folder.file("pipe.toml")));
  CHECK(!fs::exists(folder.file(".toml")));
}

constexpr const char* kGoboHead =
    "<!DOCTYPE FixtureDefinition>\n<FixtureDefinition><Manufacturer>A</Manufacturer><Model>B</Model>"
    "<Type>Moving Head</Type><Channel Name=\"Gobo wheel\"><Group Byte=\"0\">Gobo</Group>"
    "<Capability Min=\"0\" Max=\"9\" Preset=\"GoboMacro\" Res1=\"Mine/a.svg\">A</Capability>"
    "<Capability Min=\"10\" Max=\"255\" Preset=\"GoboMacro\" Res1=\"Mine/gone.svg\">Gone</Capability></Channel>"
    "<Mode Name=\"M\"><Channel Number=\"0\">Gobo wheel</Channel></Mode></FixtureDefinition>";

// Definitions of three kinds with files of their own, beside the rig file: two of them have the same names.
std::string write_heads(const TempFolder& folder) {
  const std::string head = fixtures::write_full_form(*fixtures::find_builtin_type("generic/par"), "head_files");
  for (const char* place : {"a/", "b/"}) {
    folder.write(std::string(place) + "head.toml", head);
    folder.write(std::string(place) + "head_files/wheel/star.png", place);
  }
  folder.write("wash.qxf", kGoboHead);
  folder.write("gobos/Mine/a.svg", "hole");
  folder.write("Unpacked.gdtf/description.xml",
               "<GDTF DataVersion='1.2'><FixtureType Name='Bar' Manufacturer='Us'><Geometries><Beam Name='B'/>"
               "</Geometries><DMXModes><DMXMode Name='M' Geometry='B'><DMXChannels><DMXChannel Geometry='B' Offset='1'>"
               "<LogicalChannel Attribute='Dimmer'><ChannelFunction/></LogicalChannel></DMXChannel></DMXChannels>"
               "</DMXMode></DMXModes></FixtureType></GDTF>");
  std::string rig = "[rig]\nname = \"Heads\"\n";
  int number = 0;
  for (const char* type : {"a/head.toml", "b/head.toml", "wash.qxf", "Unpacked.gdtf"}) {
    rig +=
        fmt::format("[[fixture]]\nname = \"F{0}\"\ntype = \"{1}\"\nuniverse = {0}\naddress = 1\nposition = [0, 0, 5]\n",
                    ++number, type);
  }
  return folder.write("rig.toml", rig);
}

std::string file_of(const fixtures::FixtureType& type, const std::string& name) {
  REQUIRE(type.files != nullptr);
  const auto bytes = type.files->read(name, 1000);
  REQUIRE_MESSAGE(bytes, bytes.error().message);
  return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

void check_heads(const RigFile& file) {
  REQUIRE(file.rig().types.size() == 4);
  CHECK(file_of(file.rig().types[0], "wheel/star.png") == "a/");
  CHECK(file_of(file.rig().types[1], "wheel/star.png") == "b/");
  CHECK(file_of(file.rig().types[2], "Mine/a.svg") == "hole");
  CHECK(file.rig().types[3].name == "Bar");
}

fixtures::RigEdit add_to(RigFile& file, const std::string& path, int mode = 0) {
  auto type = fixtures::open_definition(path);
  REQUIRE_MESSAGE(type, type.error().message);
  fixtures::NewFixtures row;
  row.type = std::make_shared<const fixtures::FixtureType>(std::move(*type));
  row.mode = mode;
  row.count = 2;
  auto edit = fixtures::add_fixtures(file.rig(), row);
  REQUIRE_MESSAGE(edit, edit.error().message);
  edit->apply(file.rig());
  return std::move(*edit);
}

TEST_CASE(
    "fixtures that were added are saved with their definitions and its images, and read back without the originals") {
  const TempFolder folder;
  RigFile file = opened_file(write_show(folder));
  const std::string head = qxf_head("Robe", "Spot One", {{"short", 3}, {"long", 4}});
  add_to(file, folder.write("library/Robe/one.qxf", head), 1);
  folder.write("library/Robe/gobos/Others/dots.png", "picture");
  add_to(file, folder.write("library/maker/flat.json", kOflPar));
  add_to(file, "generic/wash");
  (void)saved(file);
  CHECK(read(folder.file("show_files/one/one.qxf")) == head);
  fs::remove_all(folder.file("library"));
  fs::remove(folder.file("show.mvr"));
  RigFile again = opened_file(folder.file("show.toml"));
  const fixtures::Rig& rig = again.rig();
  REQUIRE(rig.fixtures.size() == 10);
  const auto type_at = [&](std::size_t i) { return fixtures::type_of(rig, rig.fixtures[i]).name; };
  CHECK(rig.fixtures[4].name == "Spot One 1");
  CHECK(type_at(4) == "Spot One");
  CHECK(fixtures::mode_of(rig, rig.fixtures[5]).name == "long");
  CHECK(type_at(7) == "Flat Par");
  CHECK(fixtures::type_of(rig, rig.fixtures[9]).id == "generic/wash");
  CHECK(fixtures::text_of_patch(rig.fixtures[4]) == "1.9");
  // The next session may add the same definition from the folder of files, and save.
  add_to(again, folder.file("show_files/one/one.qxf"));
  CHECK(again.rig().types.size() == rig.types.size());
  (void)saved(again);
  CHECK(opened_file(folder.file("show.toml")).rig().fixtures.size() == 12);
}

TEST_CASE("a definition that was added and undone is not in the file, and another one takes its place") {
  const TempFolder folder;
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  const fixtures::RigEdit first = add_to(file, folder.write("a/one.qxf", qxf_head("Robe", "One", {{"m", 4}})));
  first.undo(file.rig());
  (void)saved(file);
  CHECK(!fs::exists(folder.file("club_files")));
  add_to(file, folder.write("b/one.qxf", qxf_head("Robe", "Other", {{"m", 3}})));
  (void)saved(file);
  const RigFile again = opened_file(folder.file("club.toml"));
  CHECK(again.rig().types.back().name == "Other");
  CHECK(again.rig().fixtures.size() == 10);
}

TEST_CASE("files that definitions name beside them are saved, copied and recovered with a rig") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  const std::string path = write_heads(folder);
  {
    RigFile file = opened_file(path);
    check_heads(file);
    tools::Autosave copies(file, state);
    lift(file, {0});
    const Status copied = copies.write_now(1);
    REQUIRE_MESSAGE(copied, copied.error().message);
    saved(file);
    lift(file, {0});
    saved(file);
  }
  for (const char* each : {"a", "b", "wash.qxf", "gobos", "Unpacked.gdtf"}) fs::remove_all(folder.file(each));
  RigFile again = opened_file(path);
  check_heads(again);
  CHECK(fixtures::position_of(again.rig().fixtures[0]).z == 6);
  lift(again, {0});
  saved(again);
  check_heads(opened_file(path));
  const auto lost = tools::find_lost_edits(state, path);
  REQUIRE(lost);
  CHECK(lost->older);
  const auto recovered = tools::open_lost_edits(*lost);
  REQUIRE_MESSAGE(recovered, recovered.error().message);
  check_heads(*recovered);
}

TEST_CASE("a rig that could not be read again is not saved, and no file is left") {
  const TempFolder folder;
  RigFile file = opened_file(write_show(folder));
  file.rig().fixtures[0].pose = glm::dmat4(1);
  (*file.rig().fixtures[0].pose)[3].x = 20'000;
  CHECK(contains(refused(file), "show.toml: is not written, since it could not be read again: "));
  CHECK(!fs::exists(folder.file("show.toml")));
  CHECK(!fs::exists(folder.file("show_files")));
}

TEST_CASE("an unpacked MVR with a slash at its end, far meshes and names with braces are saved and read again") {
  const TempFolder folder;
  std::string objects;
  for (const char* x : {"1000", "30000000"}) {
    objects += fmt::format(
        "<Truss name=\"T\"><Matrix>{{1,0,0}}{{0,1,0}}{{0,0,1}}{{{0},0,5000}}</Matrix><Geometries><Geometry3D "
        "fileName=\"leg.3ds\"/></Geometries></Truss><FocusPoint "
        "name=\"P\"><Matrix>{{1,0,0}}{{0,1,0}}{{0,0,1}}{{{0},0,0}}"
        "</Matrix></FocusPoint>",
        x);
  }
  folder.write("unpacked/leg.3ds", "mesh");
  folder.write("unpacked/GeneralSceneDescription.xml",
               "<GeneralSceneDescription verMajor=\"1\" verMinor=\"6\"><Scene><Layers><Layer name=\"L\"><ChildList>"
               "<Fixture name=\"A{}\"><GDTFSpec>Generic@Par</GDTFSpec><Addresses><Address>1</Address></Addresses>"
               "</Fixture>" +
                   objects + "</ChildList></Layer></Layers></Scene></GeneralSceneDescription>");
  RigFile file = opened_file(folder.file("unpacked") + "/");
  CHECK(file.target() == folder.file("unpacked.toml"));
  CHECK(file.rig().objects.size() == 1);
  CHECK(file.rig().focus_points.size() == 1);
  saved(file);
  const RigFile again = opened_file(folder.file("unpacked.toml"));
  CHECK(again.rig().name == "unpacked");
  CHECK(again.rig().fixtures[0].name == "A{ }");
  // Cameras that the import made up are made up again, so that the window starts with its own view.
  CHECK(again.rig().made_up_cameras);
  CHECK(again.rig().cameras.size() == file.rig().cameras.size());
}

TEST_CASE("values of the rig that have no effect now are kept by a save") {
  const TempFolder folder;
  const std::string path = folder.write("rig.toml", R"([rig]
name = "Dormant"
files = "meshes"
[haze]
size_m = 7
wind_m_s = [1, 0, 0]
seed = 9
[sun]
direction = [0, 1, 0]
illuminance_lx = 1234
[[fixture]]
name = "Spare"
type = "generic/par"
patched = false
universe = 3
address = 510
breaks = [{ break = 2, universe = 4, address = 101 }]
position = [0, 0, 5]
[[object]]
name = "Truss"
parts = [
  { file = "gone.3ds", pose = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 5] },
]
[[scenery]]
kind = "crowd"
width_m = 0.5
depth_m = 0.5
density_per_m2 = 6
)");
  fs::create_directory(folder.file("meshes"));
  RigFile file = opened_file(path);
  CHECK(file.rig().usual_camera);
  saved(file);
  const RigFile again = opened_file(path);
  const fixtures::Rig& rig = again.rig();
  CHECK(rig.usual_camera);
  CHECK(rig.haze.size_m == 7);
  CHECK(rig.haze.wind_m_s.x == 1);
  CHECK(rig.haze.seed == 9);
  CHECK(rig.sun.illuminance_lx == 1234);
  CHECK(rig.sun.direction == glm::dvec3(0, 1, 0));
  REQUIRE(rig.fixtures.size() == 1);
  CHECK(!rig.fixtures[0].patched);
  CHECK(rig.fixtures[0].universe == 3);
  CHECK(rig.fixtures[0].address == 510);
  CHECK(rig.fixtures[0].further_addresses.size() == 1);
  REQUIRE(rig.objects.size() == 1);
  REQUIRE(rig.objects[0].parts.size() == 1);
  CHECK(rig.objects[0].parts[0].file == "gone.3ds");
  CHECK(rig.scenery.at(0).count == 2);
}

TEST_CASE("comments that were written after a save are kept by the next session, and those before while none are") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  const auto session = [&] {
    RigFile file = opened_file(path);
    lift(file, {0});
    return saved(file).old;
  };
  CHECK(session() == path + "~");
  CHECK(session().empty());  // nothing of it would be lost
  CHECK(read(path + "~") == kCommentedRig);
  folder.write("club.toml", read(path) + "# by hand\n");
  CHECK(session() == path + "~");
  CHECK(contains(read(path + "~"), "# by hand"));
}

TEST_CASE("a file that is read-only is not replaced, and a private one stays private") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  RigFile file = opened_file(path);
  lift(file, {0});
  fs::permissions(path, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read);
  CHECK(refused(file) == path + ": is read-only; allow to write it, then save again");
  CHECK(read(path) == kCommentedRig);
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  saved(file);
  CHECK(fs::status(path).permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("of programs that save one rig at once, each file is whole and only one saves over what it read") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  std::vector<pid_t> children;
  int ready[2] = {-1, -1};
  int go[2] = {-1, -1};
  REQUIRE(pipe(ready) == 0);
  REQUIRE(pipe(go) == 0);
  for (int i = 0; i < 6; ++i) {
    children.push_back(fork());
    REQUIRE(children.back() >= 0);
    if (children.back() != 0) continue;
    RigFile file = opened_file(path);
    for (int k = 0; k <= i; ++k) lift(file, {0});
    close(go[1]);
    char word = '+';
    if (write(ready[1], &word, 1) != 1) _exit(2);
    if (::read(go[0], &word, 1) != 0) _exit(2);  // ends when all have read the file
    _exit(file.save() ? 0 : 1);
  }
  char word = 0;
  for (int i = 0; i < 6; ++i) REQUIRE(::read(ready[0], &word, 1) == 1);
  for (const int end : {go[0], go[1], ready[0], ready[1]}) close(end);
  int done = 0;
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    done += WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 1 : 0;
  }
  CHECK(done == 1);
  (void)opened_file(path);
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    CHECK(!entry.path().string().ends_with(".part"));
  }
}

TEST_CASE("a rig file is saved to itself, and the file from before is kept once") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  for (int session = 0; session < 2; ++session) {
    RigFile file = opened_file(path);
    CHECK(file.target() == path);
    lift(file, {0});
    CHECK(saved(file).old == (session == 0 ? path + "~" : ""));
    lift(file, {1});
    CHECK(saved(file).old.empty());
  }
  CHECK(read(path + "~") == kCommentedRig);
  CHECK(fixtures::position_of(opened_file(path).rig().fixtures[1]) == glm::dvec3(1, 0, 6));
  CHECK((fs::status(path).permissions() & fs::perms::others_read) == fs::perms::none);
}

TEST_CASE("a file that others made or changed is not replaced") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  RigFile file = opened_file(path);
  lift(file, {0});
  const std::string theirs = std::string(kCommentedRig) + "# theirs\n";
  folder.write("club.toml", theirs);
  CHECK(refused(file) == path + ": was changed by another program since it was read; move it away, then save again");
  CHECK(read(path) == theirs);
  fs::rename(path, folder.file("theirs.toml"));
  saved(file);
  CHECK(fixtures::position_of(opened_file(path).rig().fixtures[0]).z == 5.5);

  RigFile show = opened_file(write_show(folder));
  folder.write("show.toml", kCommentedRig);
  CHECK(refused(show) ==
        folder.file("show.toml") +
            ": exists already and was not opened here; save under another name, or move it away, then save again");
  CHECK(read(folder.file("show.toml")) == kCommentedRig);
}

TEST_CASE("a file of the folder of definitions that is another one is not replaced") {
  const TempFolder folder;
  RigFile file = opened_file(write_show(folder));
  folder.write("show_files/leg.3ds", "another mesh");
  CHECK(refused(file) ==
        folder.file("show_files/leg.3ds") + ": is another file than the one of the rig; move it away, then try again");
  CHECK(read(folder.file("show_files/leg.3ds")) == "another mesh");
  CHECK(!fs::exists(folder.file("show.toml")));
  folder.write("show_files/leg.3ds", "mesh");
  saved(file);
}

TEST_CASE("links, definitions of one fixture and folders are never written") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  fs::create_symlink(path, folder.file("link.toml"));
  RigFile link = opened_file(folder.file("link.toml"));
  lift(link, {0});
  CHECK(contains(refused(link), "link.toml: is a link; open the file that it names"));
  CHECK(read(path) == kCommentedRig);

  const std::string fixture =
      folder.write("head.toml", read(std::string(FOOTLIGHT_SOURCE_DIR) + "/fixtures/builtin/par.toml"));
  RigFile lone = opened_file(fixture);
  CHECK(lone.target() == folder.file("head_rig.toml"));
  const std::string before = read(fixture);
  saved(lone);
  CHECK(read(fixture) == before);
  CHECK(opened_file(folder.file("head_rig.toml")).rig().fixtures.size() == 1);
}

TEST_CASE("fixtures that share slots are saved so that the file can be read again") {
  const TempFolder folder;
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  auto edit = fixtures::patch_fixtures(file.rig(), std::vector{3}, {1, 3});
  REQUIRE(edit);
  edit->apply(file.rig());
  CHECK(saved(file).shared == 3);                 // it reaches into two others
  CHECK(!file.rig().fixtures[3].shares_address);  // a later edit may end the conflict
  const RigFile again = opened_file(folder.file("club.toml"));
  CHECK(fixtures::text_of_patch(again.rig().fixtures[3]) == "1.3");
  CHECK(again.rig().fixtures[3].shares_address);
}

// Runs `work` in a process of its own, which is killed after this time.
template <class Work>
void killed_after(std::chrono::microseconds time, Work work) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    work();
    _exit(0);
  }
  ::usleep(static_cast<useconds_t>(time.count()));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
}

TEST_CASE("a program that is killed while it saves leaves a whole file from before or after") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  {
    RigFile file = opened_file(path);
    saved(file);
  }
  const std::string target = folder.file("show.toml");
  std::mt19937 random(5);
  double highest = 5;
  for (int round = 0; round < 12; ++round) {
    killed_after(std::chrono::microseconds(100'000 + random() % 200'000), [&] {
      RigFile file = opened_file(target);
      for (;;) {
        lift(file, {0, 1, 2, 3});
        if (!file.save()) _exit(1);
      }
    });
    const RigFile again = opened_file(target);
    REQUIRE(again.rig().fixtures.size() == 4);
    const double height = fixtures::position_of(again.rig().fixtures[0]).z;
    CHECK(height >= highest);
    for (const auto& fixture : again.rig().fixtures) CHECK(fixtures::position_of(fixture).z == height);
    highest = height;
    CHECK(read(folder.file("show_files/leg.3ds")) == "mesh");
  }
  CHECK(highest > 5);
}

TEST_CASE("edits of a program that was killed are found by the next one, and lead to the same file") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  const std::string state = folder.file("state");
  int ready[2] = {-1, -1};
  REQUIRE(pipe(ready) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    RigFile file = opened_file(path);
    tools::Autosave copies(file, state);
    lift(file, {1});
    const bool written = copies.write_now(1).has_value();
    if (write(ready[1], written ? "+" : "-", 1) != 1) _exit(1);
    for (;;) pause();
  }
  char word = 0;
  REQUIRE(::read(ready[0], &word, 1) == 1);
  CHECK(word == '+');
  CHECK(!tools::find_lost_edits(state, path));  // the program runs
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  close(ready[0]);
  close(ready[1]);

  CHECK(!tools::find_lost_edits(state, folder.file("other.mvr")));
  auto lost = tools::find_lost_edits(state, path);
  REQUIRE(lost);
  CHECK(lost->written_s > 1'500'000'000);
  auto recovered = tools::open_lost_edits(*lost);
  REQUIRE_MESSAGE(recovered, recovered.error().message);
  CHECK(fixtures::position_of(recovered->rig().fixtures[1]) == glm::dvec3(2, 0, 5.5));
  CHECK(recovered->target() == folder.file("show.toml"));
  {
    tools::Autosave copies(*recovered, state, std::move(lost->claim));
    lift(*recovered, {2});
    CHECK(copies.write_now(1).has_value());  // to the same folder
    saved(*recovered);
    copies.forget();
    lift(*recovered, {3});
    saved(*recovered);  // its definitions can still be read
  }
  CHECK(!tools::find_lost_edits(state, path));
  const RigFile again = opened_file(folder.file("show.toml"));
  for (const std::size_t i : {1u, 2u, 3u}) CHECK(fixtures::position_of(again.rig().fixtures[i]).z == 5.5);
  CHECK(fs::is_empty(state + "/rigs"));
}

}  // namespace
}  // namespace footlight::testing
