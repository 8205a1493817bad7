// Fixture definitions through the commands check and show, as text and as JSON.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/definition_files.h"
#include "tests/support/model_bytes.h"
#include "tests/support/temp_folder.h"
#include "tests/support/zip_bytes.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

constexpr const char* kHead =
    "<GDTF DataVersion='1.2'><FixtureType Name='Head' Manufacturer='Us'>\n"
    "<Wheels><Wheel Name='Gobos'><Slot Name='Open'/><Slot Name='Red' Color='0.64,0.33,21.3'/></Wheel></Wheels>\n"
    "<Geometries><Geometry Name='Base'><Axis Name='Yoke'><Beam Name='Lens' LuminousFlux='9000'/></Axis></Geometry>\n"
    "</Geometries><DMXModes>\n"
    "<DMXMode Name='Small' Geometry='Base'><DMXChannels><DMXChannel Geometry='Lens' Offset='1'>\n"
    "<LogicalChannel Attribute='Dimmer'><ChannelFunction DMXFrom='0/1'>\n"
    "<ChannelSet Name='off' DMXFrom='WRONG'/></ChannelFunction></LogicalChannel></DMXChannel></DMXChannels></DMXMode>\n"
    "<DMXMode Name='Large' Geometry='Base'><DMXChannels><DMXChannel Geometry='Yoke' Offset='1,2'>\n"
    "<LogicalChannel Attribute='Pan'><ChannelFunction Name='P' PhysicalFrom='-270' PhysicalTo='270' RealFade='3.5'/>\n"
    "</LogicalChannel></DMXChannel><DMXChannel Geometry='Lens' Offset='3'><LogicalChannel Attribute='Gobo1'>\n"
    "<ChannelFunction Wheel='Gobos' ModeMaster='Yoke_Pan' ModeFrom='0/2' ModeTo='99/2'>\n"
    "<ChannelSet Name='red' DMXFrom='10/1' WheelSlotIndex='2'/></ChannelFunction></LogicalChannel></DMXChannel>\n"
    "<DMXChannel Geometry='Base' Offset='4'><LogicalChannel Attribute='RoboSpot'><ChannelFunction/>"
    "</LogicalChannel></DMXChannel>\n"
    "</DMXChannels></DMXMode></DMXModes></FixtureType></GDTF>\n";

std::vector<Json> lines_of(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

TEST_CASE("check finds the definitions in folders, and its exit code is 1 if one is refused") {
  TempFolder folder;
  const std::string head = folder.write("a/head.gdtf", make_zip({{"description.xml", kHead, 8}}));
  folder.write("unpacked/description.xml", kHead);
  folder.write("unpacked/wheels/x.png", "png");
  folder.write("notes.txt", "no definition");
  const Outcome good = footlight({"fixtures", "check", folder.path().string(), "--json"});
  CHECK(good.exit_code == 0);
  CHECK(contains(good.err, "2 files: 0 loaded, 2 with warnings, 0 refused; 1 other files are not fixture definitions"));
  const auto lines = lines_of(good.out);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0]["file"] == head);
  CHECK(lines[0]["format"] == "gdtf");
  CHECK(lines[0]["status"] == "warnings");
  CHECK(lines[0]["name"] == "Head");
  CHECK(lines[0]["modes"] == 2);
  REQUIRE(lines[0]["diagnostics"].size() == 2);
  CHECK(lines[0]["diagnostics"][1]["code"] == "not-simulated");
  CHECK(lines[0]["diagnostics"][1]["message"] == "RoboSpot");
  const Json& reported = lines[0]["diagnostics"][0];
  CHECK(reported["severity"] == "error");
  CHECK(reported["code"] == "dmx-value");
  CHECK(reported["file"] == head + ":description.xml");
  CHECK(reported["line"] == 7);
  CHECK(reported["column"] == 41);
  CHECK(reported["assumed"] == "the set is not there");
  CHECK(lines[1]["file"] == folder.path().string() + "/unpacked");

  folder.write("b/broken.gdtf", make_zip({{"description.xml", "<GDTF>\n<oops"}}));
  const Outcome bad = footlight({"fixtures", "check", folder.path().string()});
  CHECK(bad.exit_code == 1);
  CHECK(contains(bad.out, "refused   " + folder.path().string() + "/b/broken.gdtf\n"));
  CHECK(contains(bad.out, "broken.gdtf:description.xml:2:"));
  CHECK(contains(bad.out, "warnings  " + head + ": Us Head, 2 modes"));
}

TEST_CASE("check prints a summary first, then one line per file and its errors, and the rest with --notes") {
  TempFolder folder;
  std::string head = kHead;
  // Two fades longer than those of any motor, and the set that is lost.
  head.replace(head.find("RealFade='3.5'"), 14, "RealFade='999'");
  head.replace(head.find("<ChannelFunction DMXFrom='0/1'>"), 31, "<ChannelFunction DMXFrom='0/1' RealFade='1e3'>");
  const std::string wrong = folder.write("a.gdtf", make_zip({{"description.xml", head, 8}}));
  const std::string lamp = folder.write("b.ies", "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 5\n0 180\n0\n100 100\n");
  const Outcome brief = footlight({"fixtures", "check", folder.path().string()});
  CHECK(brief.exit_code == 0);
  std::istringstream stream(brief.out);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  REQUIRE(lines.size() == 4);
  CHECK(lines[0] == "2 files: 1 loaded, 1 with warnings, 0 refused; --notes lists the warnings");
  CHECK(lines[1] == "warnings  " + wrong + ": Us Head, 2 modes; 1 error (dmx-value); 2 warnings (range 2)");
  CHECK(contains(lines[2], "a.gdtf:description.xml:7:"));
  CHECK(contains(lines[2], ": error: "));
  CHECK(lines[3] == "loaded    " + lamp + ": b.ies, 1 mode");
  CHECK(brief.err.empty());
  const Outcome all = footlight({"fixtures", "check", folder.path().string(), "--notes"});
  CHECK(all.out.starts_with("2 files: 1 loaded, 1 with warnings, 0 refused\n"));
  CHECK(contains(all.out, "RealFade of 999 s"));
  CHECK(contains(all.out, "[not-simulated]"));
  CHECK(contains(all.out, "[measured]"));
}

TEST_CASE("convert, import and export replace a file, or the folder of its files, only with --overwrite") {
  TempFolder folder;
  const std::string head = folder.write("head.gdtf", make_zip({{"description.xml", kHead, 8}}));
  const std::string out = folder.file("mine.toml");
  const std::string mvr = folder.file("mine.mvr");
  const std::vector<std::vector<std::string>> commands = {
      {"fixtures", "convert", head, "-o", out}, {"rig", "import", head, "-o", out}, {"rig", "export", head, "-o", mvr}};
  const auto text_of = [](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  for (auto command : commands) {
    CAPTURE(command[1]);
    const std::string& path = command.back();
    CHECK(footlight(command).exit_code == 0);
    const std::string written = text_of(path);
    CHECK_FALSE(written.empty());
    folder.write(fs::path(path).filename().string(), "by hand");
    const Outcome refused = footlight(command);
    CHECK(refused.exit_code == 2);
    CHECK(contains(refused.err, path + ": exists; choose another name or allow overwriting"));
    CHECK(text_of(path) == "by hand");
    auto replacing = command;
    replacing.push_back("--overwrite");
    CHECK(footlight(replacing).exit_code == 0);
    CHECK(text_of(path) == written);
    fs::remove(path);
    if (command[1] == "export") continue;
    fs::remove_all(folder.file("mine_files"));
    folder.write("mine_files/notes.txt", "by hand");
    const Outcome files = footlight(command);
    CHECK(files.exit_code == 2);
    CHECK(contains(files.err, "mine_files: exists"));
    CHECK_FALSE(fs::exists(path));
    fs::remove_all(folder.file("mine_files"));
  }
}

TEST_CASE("a conversion that ends on a full disk leaves nothing, so that it can be repeated") {
  TempFolder folder;
  std::string text = kHead;
  text.replace(text.find("Name='Open'"), 11, "Name='Open' MediaFileName='dots'");
  const std::string head =
      folder.write("head.gdtf", make_zip({{"description.xml", text, 8}, {"wheels/dots.png", "0123456789"}}));
  const std::vector<std::string> command = {"fixtures", "convert", head, "-o", folder.file("to/mine.toml")};
  // A limit on the size of files makes writes fail like a full disk. The program inherits both.
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{100, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const Outcome full = footlight(command);
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, previous);
  CHECK(full.exit_code == 1);
  CHECK(contains(full.err, "mine.toml: cannot be written"));
  CHECK_FALSE(fs::exists(folder.file("to")));
  CHECK(footlight(command).exit_code == 0);
  CHECK(fs::exists(folder.file("to/mine_files/wheels/dots.png")));
}

TEST_CASE("a read-only file is not replaced") {
  TempFolder folder;
  const std::string head = folder.write("head.gdtf", make_zip({{"description.xml", kHead, 8}}));
  const std::string mine = folder.write("mine.toml", "by hand");
  fs::permissions(mine, fs::perms::owner_read);
  const Outcome refused = footlight({"fixtures", "convert", head, "-o", mine, "--overwrite"});
  CHECK(refused.exit_code == 1);
  CHECK(contains(refused.err, mine + ": is read-only; allow writing (chmod u+w) or choose another name"));
  CHECK(fs::file_size(mine) == 7);
}

TEST_CASE("check refuses unreadable arguments, and finds nothing in an empty folder") {
  TempFolder folder;
  const Outcome text = footlight({"fixtures", "check", folder.write("a.txt", "hello"), "--json"});
  CHECK(text.exit_code == 1);
  CHECK(lines_of(text.out).at(0)["status"] == "refused");
  CHECK(lines_of(text.out).at(0)["format"] == "");
  // A missing path is refused, and the rest is checked.
  const std::string head = folder.write("head.gdtf", make_zip({{"description.xml", kHead, 8}}));
  fs::create_symlink("nowhere.gdtf", folder.path() / "lost.gdtf");
  const std::string gone = folder.path().string() + "/gone";
  const auto mixed = lines_of(footlight({"fixtures", "check", gone, folder.path().string(), "--json"}).out);
  REQUIRE(mixed.size() == 3);
  CHECK(mixed[0]["file"] == gone);
  CHECK(mixed[0]["status"] == "refused");
  CHECK(mixed[0]["diagnostics"][0]["message"] == "No such file or directory");
  CHECK(mixed[1]["file"] == head);
  CHECK(mixed[2]["status"] == "refused");
  CHECK(footlight({"fixtures", "check", gone}).exit_code == 3);  // as for any command that finds nothing
  for (const char* name : {"/a.txt", "/head.gdtf", "/lost.gdtf"}) fs::remove(folder.path().string() + name);
  CHECK(footlight({"fixtures", "check", folder.path().string()}).exit_code == 3);
}

TEST_CASE("a full disk behind standard output is a failure of every command") {
  TempFolder folder;
  const std::string head = folder.write("head.gdtf", make_zip({{"description.xml", kHead}}));
  for (const char* command : {"check", "show"}) {
    CAPTURE(command);
    const std::string line =
        std::string("'") + FOOTLIGHT_BINARY + "' fixtures " + command + " '" + head + "' > /dev/full 2> /dev/null";
    CHECK(WEXITSTATUS(std::system(line.c_str())) == 1);
  }
  const std::string help = std::string("'") + FOOTLIGHT_BINARY + "' --help > /dev/full 2> /dev/null";
  CHECK(WEXITSTATUS(std::system(help.c_str())) == 1);
}

TEST_CASE("a name with terminal sequences is printed without them") {
  TempFolder folder;
  std::string head = kHead;
  head.replace(head.find("'Head'"), 6, "'\x1b[2JHead'");
  const std::string path = folder.write("head.gdtf", make_zip({{"description.xml", head}}));
  for (const char* command : {"check", "show"}) {
    const Outcome outcome = footlight({"fixtures", command, path});
    CHECK(contains(outcome.out, "\xEF\xBF\xBD[2JHead"));
    CHECK_FALSE(contains(outcome.out, "\x1b"));
  }
}

TEST_CASE("rig check reports files in the same form as fixtures check") {
  TempFolder folder;
  const std::string cut = folder.write("cut.mvr", "");
  const std::string good = folder.write("rig.toml",
                                        "[rig]\nname = \"r\"\n[[fixture]]\nname = \"a\"\ntype = \"generic/par\"\n"
                                        "universe = 1\naddress = 1\nposition = [0, 0, 3]\n");
  const Outcome outcome = footlight({"rig", "check", cut, good, "--json"});
  CHECK(outcome.exit_code == 1);
  const auto lines = lines_of(outcome.out);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0]["file"] == cut);
  CHECK(lines[0]["format"] == "mvr");
  CHECK(lines[0]["status"] == "refused");
  CHECK(lines[0]["diagnostics"][0]["message"] == "not an MVR file: expected a zip archive");
  CHECK(lines[0]["diagnostics"][0]["assumed"] == "");
  CHECK(lines[1]["format"] == "toml");
  CHECK(lines[1]["status"] == "loaded");
  CHECK(lines[1]["fixtures"] == 1);
  CHECK(contains(outcome.err, "2 files: 1 loaded, 0 with warnings, 1 refused"));
}

TEST_CASE("rig check counts panes of glass and displays") {
  TempFolder folder;
  const std::string samples = folder.file("samples");
  REQUIRE(footlight({"samples", samples}).exit_code == 0);
  CHECK(contains(footlight({"rig", "check", samples + "/chapel.toml"}).out, ", 3 panes of glass"));
  CHECK(contains(footlight({"rig", "check", samples + "/wall.toml"}).out, ", 4 displays"));
}

constexpr const char* kVideoWall =
    "[rig]\nname = \"w\"\n[[display]]\nname = \"Wall\"\nposition = [0, 4, 2.5]\nwidth_m = 4\nheight_m = 2\nnits = 600\n"
    "video = \"clip.mp4\"\n";

TEST_CASE("rig check names meshes, their images and videos that are missing or damaged") {
  TempFolder folder;
  const std::string pose = ", pose = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] }";
  folder.write("files/broken.3ds", "no mesh");
  folder.write("files/cut.glb", std::string("glTF\2\0\0\0\xff\0\0\0", 12));
  folder.write("files/sign.3ds", quad_3ds(texture_3ds("sign.png")));
  std::string parts;
  for (const char* file : {"away.3ds", "broken.3ds", "cut.glb", "sign.3ds", "broken.3ds"}) {
    parts += std::string(parts.empty() ? "" : ", ") + "{ file = \"" + file + "\"" + pose;
  }
  const std::string meshes =
      folder.write("meshes.toml",
                   "[rig]\nname = \"r\"\nfiles = \"files\"\n[[object]]\nname = \"Truss\"\nkind = \"truss\"\nparts = [" +
                       parts + "]\n");
  const Outcome checked = footlight({"rig", "check", meshes});
  CHECK(checked.exit_code == 0);
  CHECK(contains(checked.out, "the folder that [rig] files names has no \"away.3ds\""));
  CHECK(contains(checked.out, "files/broken.3ds: warning: object 'Truss': "));
  CHECK(contains(checked.out, "broken.3ds: neither 3DS nor glTF [object-unreadable]"));
  CHECK(contains(checked.out, "cut.glb: not glTF 2.0"));
  CHECK(contains(checked.out, "files/sign.3ds: warning: texture 'sign.png': not beside the mesh"));
  CHECK(contains(checked.out, "meshes.toml: warnings"));

  const std::string wall = folder.write("wall.toml", kVideoWall);
  const std::string clip = folder.write("clip.mp4", "no video");
  const Outcome broken = footlight({"rig", "check", wall});
  CHECK(contains(broken.out, clip + ": error: display 'Wall': "));
  CHECK(contains(broken.out, "[video]"));
  CHECK(contains(broken.out, "wall.toml: warnings"));
}

TEST_CASE("rig check reads rigs whose displays show a media server, and names the server's videos that are damaged") {
  TempFolder folder;
  const std::string clip = folder.write("clip.mp4", "no video");
  const std::string server = folder.write(
      "server.toml",
      "[rig]\nname = \"s\"\n[[fixture]]\nname = \"Server\"\ntype = \"generic/media-server\"\nuniverse = 4\naddress = "
      "1\n"
      "position = [0, -8, 1]\nmedia = [{ number = 1, color = [1, 0, 0] }, { number = 2, video = \"clip.mp4\" }]\n"
      "[[display]]\nname = \"Wall\"\nposition = [0, 4, 3]\nwidth_m = 6\nheight_m = 3.4\nsource = \"Server\"\n"
      "columns = 16\nrows = 9\n");
  const Outcome checked = footlight({"rig", "check", server});
  CHECK(checked.exit_code == 0);
  CHECK(contains(checked.out, clip + ": error: media server 'Server': "));
  CHECK(contains(checked.out, "server.toml: warnings"));
}

TEST_CASE("tubes are shown as what they are, not as the beams of their types") {
  const std::string strobe = FOOTLIGHT_SOURCE_DIR "/fixtures/builtin/strobe.toml";
  const Outcome shown = footlight({"fixtures", "show", strobe});
  INFO(shown.err);
  CHECK(contains(shown.out, "(tube)"));
  CHECK(contains(shown.out, "60000 lm, "));
  CHECK(contains(shown.out, "0.4 m long and 0.06 m wide, 7.958e+05 cd/m2 to all directions before it"));
  CHECK(!contains(shown.out, "field"));
  const Outcome optics = footlight({"fixtures", "show", strobe, "--optics"});
  CHECK(contains(optics.out, "60000 lm, a tube 0.4 m long and 0.06 m wide: drawn as a face of 7.958e+05 cd/m2, "
                             "1.91e+04 cd straight before it, 9549 cd at 60 degrees"));
}

TEST_CASE("a video that is a folder, a pipe, a link to itself or not there is named as that") {
  namespace fs = std::filesystem;
  TempFolder folder;
  const std::string wall = folder.write("wall.toml", kVideoWall);
  const std::string clip = folder.file("clip.mp4");
  const auto said = [&](const std::string& what) {
    return contains(footlight({"rig", "check", wall}).out, "video: " + clip + ": " + what);
  };
  CHECK(said("there is no such file; correct the name"));
  fs::create_directory(clip);
  CHECK(said("a folder; expected a file with a video"));
  CHECK(contains(footlight({"clip", clip}).err, clip + ": a folder; expected a file with a video"));
  fs::remove(clip);
  REQUIRE(::mkfifo(clip.c_str(), 0600) == 0);
  CHECK(said("a pipe or a device; expected a file with a video"));
  fs::remove(clip);
  fs::create_symlink("clip.mp4", clip);
  CHECK(said("cannot be looked up: "));
}

TEST_CASE("rig check warns of a projector whose dimmer is one of its own pixels") {
  TempFolder folder;
  const auto checked = [&](int address) {
    return footlight(
               {"rig", "check",
                folder.write("p.toml",
                             "[rig]\nname = \"p\"\n[[projector]]\nname = \"Beamer\"\nposition = [0, -6, 4]\n"
                             "aim = [0, 4, 2]\nuniverse = 5\naddress = " +
                                 std::to_string(address) + "\ncontent = { universe = 5, columns = 16, rows = 9 }\n")})
        .out;
  };
  const std::string inside = checked(432);
  CHECK(contains(inside, "Beamer and the pixels of Beamer share universe 5, address 432"));
  CHECK(contains(inside, "[pixel-overlap]"));
  CHECK_FALSE(contains(checked(433), "pixel-overlap"));
}

TEST_CASE("a file that is not a rig is reported as the format of its name and its first bytes") {
  TempFolder folder;
  const std::string archive = make_zip({{"a.txt", "x"}});
  const auto reported = [&](const char* name, const std::string& bytes) {
    const Outcome outcome = footlight({"rig", "check", folder.write(name, bytes)});
    CHECK(outcome.exit_code == 1);
    return outcome.out;
  };
  const std::string gdtf = reported("head.gdtf", archive);
  CHECK(contains(gdtf, "description.xml"));
  CHECK_FALSE(contains(gdtf, "GeneralSceneDescription"));
  CHECK(contains(reported("show.mvr", archive), "expected GeneralSceneDescription.xml in the archive"));
  const std::string pcapng("\x0a\x0d\x0d\x0a\x1c\x00\x00\x00\x4d\x3c\x2b\x1a\x01\x00\x00\x00", 16);
  for (const auto& [name, bytes] : {std::pair<const char*, std::string>("a.pcapng", pcapng),
                                    {"a.show", "OLA Show\n1 0,0\n0\n"},
                                    {"a.bin", std::string(100, '\xfe')}}) {
    CAPTURE(name);
    const std::string out = reported(name, bytes);
    CHECK_FALSE(contains(out, "TOML"));
    CHECK(contains(out, "neither a rig (.mvr, .qxw, .toml) nor a definition of a fixture"));
    CHECK(contains(out, "--log"));
  }
  CHECK(contains(reported("rig.toml", "\xfe\xff\xfe = 1"), "not TOML"));
}

TEST_CASE("the report has the colours of a definition as drawn and as defined, and the energy of a measured lamp") {
  TempFolder folder;
  const std::string head = folder.write(
      "rgb.gdtf",
      make_zip({{"description.xml",
                 "<GDTF DataVersion='1.2'><FixtureType Name='Rgb' Manufacturer='Us'><PhysicalDescriptions>"
                 "<Emitters><Emitter Name='R' Color='0.64,0.33,50'/><Emitter Name='B' Color='0.15,0.02,50'/>"
                 "</Emitters></PhysicalDescriptions><Geometries><Beam Name='L'/></Geometries><DMXModes>"
                 "<DMXMode Name='M' Geometry='L'><DMXChannels/></DMXMode></DMXModes></FixtureType></GDTF>"}}));
  const Outcome json = footlight({"report", "--optics", head, "--json"});
  if (contains(json.err, "there is no command")) {
    MESSAGE("SKIPPED: built without the judge");
    return;
  }
  const auto lines = lines_of(json.out);
  REQUIRE(lines.size() == 4);  // three colours and a beam
  CHECK(lines[0]["type"] == "Us Rgb");
  CHECK(lines[0]["what"] == "emitter R");
  CHECK(lines[0]["delta_e"].get<double>() < 0.5);  // inside the screen's gamut
  CHECK(lines[1]["delta_e"].get<double>() > 5);    // outside it
  CHECK(lines[1]["delta_e_mixing"].get<double>() < 0.01);
  CHECK(lines[3]["beam"] == 1);
  CHECK(lines[3]["drawn_beam_angle_deg"].get<double>() == doctest::Approx(25));
  const std::string lamp = folder.write("a.ies", "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 5\n0 180\n0\n100 100\n");
  // A lamp without emitters has a row for its beam, with its energy.
  const auto measured = lines_of(footlight({"report", "--optics", lamp, "--json"}).out);
  REQUIRE(measured.size() == 2);  // forwards and upwards
  CHECK(measured[0]["photometry"] == "a.ies");
  CHECK(measured[0]["integrated_lm"].get<double>() == doctest::Approx(1256.64));
  CHECK(measured[0]["stated_lm"] == 1000);
  const Outcome text = footlight({"report", "--optics", lamp});
  CHECK(text.exit_code == 0);
  CHECK(contains(text.out, "a.ies: the candela integrate to 1256.64 lm, +25.66 % from the 1000.00 lm"));
}

TEST_CASE("the optics of a type that has none are said to be none") {
  const std::string server = FOOTLIGHT_SOURCE_DIR "/fixtures/builtin/media_server.toml";
  CHECK(footlight({"fixtures", "show", server, "--optics"}).out == "no beams and no colours\n");
}

TEST_CASE("the optics of a type with a given profile are those of that profile, as text and as JSON") {
  const std::string wash = FOOTLIGHT_SOURCE_DIR "/fixtures/builtin/wash.toml";
  const Outcome shown = footlight({"fixtures", "show", wash, "--optics"});
  CAPTURE(shown.out);
  CHECK(contains(shown.out, "12000 lm, m = 1 and 25 deg at the edge: drawn 17.82 and 23.75 deg, 159233 cd"));
  const Outcome json = footlight({"report", "--optics", wash, "--json"});
  if (contains(json.err, "there is no command")) {
    MESSAGE("SKIPPED: built without the judge");
    return;
  }
  const auto lines = lines_of(json.out);
  REQUIRE(!lines.empty());
  CHECK(lines.back()["profile_power"] == 1);
  CHECK(lines.back()["drawn_beam_angle_deg"].get<double>() == doctest::Approx(17.82).epsilon(5e-4));
  CHECK(lines.back()["drawn_field_angle_deg"].get<double>() == doctest::Approx(23.75).epsilon(5e-4));
  CHECK(lines.back()["peak_cd"].get<double>() == doctest::Approx(159'233).epsilon(1e-5));
}

TEST_CASE("show prints modes, geometries, channels, functions, sets, wheels and beams, or only one mode") {
  TempFolder folder;
  const std::string head = folder.write("head.gdtf", make_zip({{"description.xml", kHead}}));
  const Outcome all = footlight({"fixtures", "show", head});
  CHECK(all.exit_code == 0);
  for (const char* part : {"Us Head", "gdtf 1.2", "Small: 1 slot, 1 channels", "Large: 4 slots, 3 channels",
                           "Read, but not simulated: RoboSpot", "Wheel Gobos", "1  Open: open", "Yoke (axis)",
                           "Lens (beam), wash, 9000 lm, 6000 K, beam 25 deg", "1,2  Yoke_Pan: 16 bits",
                           "0-65535  Pan \"P\": -270 to 270 deg, 3.5 s from end to end", "while Yoke_Pan is 0 to 99",
                           "10-255  red (slot 2)"}) {
    CAPTURE(part);
    CHECK(contains(all.out, part));
  }
  CHECK(contains(all.err, "1 errors and warnings"));
  const Outcome small = footlight({"fixtures", "show", head, "--mode", "small"});
  CHECK(contains(small.out, "Lens_Dimmer"));
  CHECK_FALSE(contains(small.out, "Yoke_Pan:"));
  CHECK(footlight({"fixtures", "show", head, "--mode", "1"}).out == small.out);
  const Outcome none = footlight({"fixtures", "show", head, "--mode", "huge"});
  CHECK(none.exit_code == 3);
  CHECK(contains(none.err, "\"Small\", \"Large\""));
}

TEST_CASE("list prints definitions that have all words with their modes, and files that cannot be read") {
  const TempFolder folder;
  folder.write("own/one.qxf", qxf_head("Usmaker", "Spot One", {{"short", 3}, {"long", 4}}));
  folder.write("own/cut.qxf", "<?xml version=\"1.0\"?><FixtureDefinition><Manufacturer>Usmaker");
  folder.write("show/beside.qxf", qxf_head("Usmaker", "Beside", {{"only", 4}}));
  const std::vector<std::string> own{"--library", folder.file("own"), "--rig", folder.file("show/show.toml")};
  const auto list = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"fixtures", "list"});
    words.insert(words.end(), own.begin(), own.end());
    return footlight(words);
  };
  const Outcome found = list({"SPOT", "usmaker"});
  CHECK(found.exit_code == 0);
  CHECK(contains(found.out, "short (3), long (4)  " + folder.file("own/one.qxf") + "\n"));
  CHECK(contains(found.out, "moving head"));
  CHECK(!contains(found.out, "Beside"));
  CHECK(contains(found.err, "footlight: 1 of "));
  CHECK(contains(found.err, "1 cannot be read"));
  const std::vector<Json> lines = lines_of(list({"usmaker", "--json"}).out);
  REQUIRE(lines.size() == 2);  // in the order of their names
  CHECK(lines[0]["model"] == "Beside");
  CHECK(lines[1]["gobos"] == 2);
  CHECK(lines[1]["modes"] == Json::parse(R"([{"name": "short", "slots": 3, "channels": 3},
                                             {"name": "long", "slots": 4, "channels": 4}])"));
  const std::vector<Json> broken = lines_of(list({"cut", "--json"}).out);
  REQUIRE(!broken.empty());
  CHECK(contains(broken[0]["error"].get<std::string>(), "cut.qxf:1"));
  const Outcome builtin = list({"generic", "profile"});
  CHECK(contains(builtin.out, "  generic/profile\n"));
  const auto kind_of = [&](const char* word, const char* file) {
    for (const Json& one : lines_of(list({"generic", word, "--json"}).out)) {
      if (one["file"] == file) return one["kind"].get<std::string>();
    }
    return std::string("not listed");
  };
  CHECK(kind_of("strobe", "generic/strobe") == "strobe");
  CHECK(kind_of("media", "generic/media-server") == "media server");
  const Outcome none = list({"qqqzzzxxx"});
  CHECK(none.exit_code == 3);
  CHECK(contains(none.err, "no definition has all words of 'qqqzzzxxx'"));
  CHECK(contains(none.err, folder.file("own")));
}

}  // namespace
}  // namespace footlight::testing
