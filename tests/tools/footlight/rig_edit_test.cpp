// Edits of rigs from the command line.
#include <filesystem>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/support/definition_files.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

constexpr const char* kEditedRig = R"([rig]
name = "Club"
[[fixture]]
name = "Spot {}"
type = "generic/profile"
universe = 1
address = 1
position = [0, 0, 5]
count = 3
position_step = [1, 0, 0]
[[fixture]]
name = "Par"
type = "generic/par"
universe = 1
address = 100
position = [0, 2, 5]
)";

Outcome edit(std::vector<std::string> words) {
  words.insert(words.begin(), {"rig", "edit"});
  return footlight(words);
}

Json fixtures_of(const std::string& path) {
  const Outcome shown = footlight({"rig", "show", path, "--json"});
  REQUIRE(shown.exit_code == 0);
  Json by_name;
  const Json whole = Json::parse(shown.out);
  for (const Json& each : whole["fixtures"]) by_name[each["name"].get<std::string>()] = each;
  return by_name;
}

TEST_CASE("rig edit patches, moves and names fixtures, and writes a rig file") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const Outcome done = edit({rig, "--select", "Spot *", "--patch", "2.490", "--move", "0,-1,0.5", "--number", "101",
                             "--rename", "LX {}", "--mode", "8 bit", "-o", folder.file("out.toml")});
  CHECK(done.exit_code == 0);
  CHECK(contains(done.out, "patch 3 fixtures from 2.490\n"));
  CHECK(contains(done.out,
                 "Spot 3: name Spot 3 -> LX 3, mode 16 bit -> 8 bit, address 1.29 -> 3.1, id - -> 103, "
                 "position 2.00 0.00 5.00 -> 2.00 -1.00 5.50\n"));
  const Json after = fixtures_of(folder.file("out.toml"));
  CHECK(after["LX 2"]["addresses"] == "2.499");
  CHECK(after["LX 2"]["fixture_id"] == "102");
  CHECK(after["LX 2"]["position_m"] == Json({1.0, -1.0, 5.5}));
  CHECK(after["Par"]["addresses"] == "1.100");
}

TEST_CASE("what follows a clone acts on the copies, and rotations are about a point") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const Outcome done = edit({rig, "-s", "Par", "--clone", "2", "--offset", "1,0,0", "--rotate", "0,0,90", "--about",
                             "0,0,0", "-o", folder.file("out.toml")});
  CHECK(done.exit_code == 0);
  CHECK(contains(done.out, "Par 2: new, address 1.105\n"));
  const Json after = fixtures_of(folder.file("out.toml"));
  CHECK(after.size() == 6);
  CHECK(after["Par"]["position_m"] == Json({0.0, 2.0, 5.0}));
  CHECK(after["Par 3"]["position_m"][1].get<double>() == doctest::Approx(2));
  CHECK(after["Par 3"]["position_m"][0].get<double>() == doctest::Approx(-2));
}

TEST_CASE("without -o nothing is written, and a file that exists is replaced only if asked for and kept") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const Outcome shown = edit({rig, "--select", "Par", "--unpatch"});
  CHECK(shown.exit_code == 0);
  CHECK(contains(shown.out, "Par: address 1.100 -> -\n"));
  CHECK(contains(shown.out, "nothing is written; -o FILE.toml writes the edited rig\n"));
  const Outcome refused = edit({rig, "--select", "Par", "--unpatch", "-o", rig});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "rig.toml: exists; choose another name or allow overwriting"));
  CHECK(fixtures_of(rig)["Par"]["addresses"] == "1.100");
  const Outcome done = edit({rig, "--select", "Par", "--delete", "-o", rig, "--overwrite"});
  CHECK(done.exit_code == 0);
  CHECK(contains(done.out, "Par: deleted\n"));
  CHECK(contains(done.out, "rig.toml~: the file from before\n"));
  CHECK(!fixtures_of(rig).contains("Par"));
  std::ifstream old(rig + "~");
  CHECK(std::string(std::istreambuf_iterator<char>(old), {}) == kEditedRig);
}

TEST_CASE("edits that would share slots, or are not possible, name the fixture and the next step") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const std::string out = folder.file("out.toml");
  const Outcome shared = edit({rig, "--select", "Par", "--patch", "3", "-o", out});
  CHECK(shared.exit_code == 2);
  CHECK(contains(shared.err,
                 "Spot 1 and Par share universe 1, addresses 3 to 7; choose another address, --free, or "
                 "--share to let them"));
  CHECK(!fs::exists(out));
  CHECK(edit({rig, "--select", "Par", "--patch", "3", "--free", "-o", out}).exit_code == 0);
  CHECK(fixtures_of(out)["Par"]["addresses"] == "1.43");
  const Outcome let = edit({rig, "--select", "Par", "--patch", "3", "--share", "-o", folder.file("both.toml")});
  CHECK(let.exit_code == 0);
  CHECK(contains(let.out, "2 fixtures share slots\n"));
  CHECK(fixtures_of(folder.file("both.toml"))["Par"]["addresses"] == "1.3");

  const auto refused = [&](std::vector<std::string> words, const std::string& message) {
    words.insert(words.begin(), rig);
    const Outcome outcome = edit(words);
    CHECK(outcome.exit_code != 0);
    CHECK_MESSAGE(contains(outcome.err, message), outcome.err);
  };
  refused({"--patch", "1.1"}, "expected --select with the name of fixtures");
  refused({"--select", "Nobody"}, "--select 'Nobody': no fixture has such a name; 'footlight rig show' lists them");
  refused({"--select", "Par", "--patch", "1.600"}, "address '1.600': expected universe.address such as 2.101");
  refused({"--select", "Par", "--patch", "1.510"},
          "Par: 5 slots from address 510 end at 514; choose an address of at most 508");
  refused({"--select", "Par", "--move", "1,2"}, "--move '1,2': expected three numbers such as 1,-2.5,0");
  refused({"--select", "Par", "--place", "1,-,x"}, "with - for an axis that stays");
  refused({"--select", "Par", "--unpatch", "-o", "x.mvr"}, "-o 'x.mvr': expected a file name that ends in .toml");
}

TEST_CASE("fixtures of a definition are added, and the rig file is read again with a copy of it") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const std::string head = folder.write("heads/one.qxf", qxf_head("Robe", "Spot One", {{"short", 3}, {"long", 4}}));
  const std::string out = folder.file("out/more.toml");
  fs::create_directory(folder.file("out"));
  const Outcome done = edit({rig, "--add", head, "--mode", "long", "--count", "3", "--offset", "0,2,0", "--place",
                             "1,-,6", "--number", "50", "-o", out});
  CHECK_MESSAGE(done.exit_code == 0, done.err);
  CHECK(contains(done.out, "add 3 Spot One from 1.43\n"));
  CHECK(contains(done.out, "Spot One 3: new, address 1.51\n"));
  fs::remove_all(folder.file("heads"));
  const Json after = fixtures_of(out);
  CHECK(after.size() == 7);
  CHECK(after["Spot One 2"]["addresses"] == "1.47");
  CHECK(after["Spot One 2"]["mode"] == "long");
  CHECK(after["Spot One 2"]["fixture_id"] == "51");
  CHECK(after["Spot One 3"]["position_m"] == Json({1.0, 4.0, 6.0}));
  const Outcome more = edit({out, "--add", "generic/par", "--patch", "1.1", "--share", "-o", folder.file("b.toml")});
  CHECK(more.exit_code == 0);
  CHECK(fixtures_of(folder.file("b.toml")).size() == 8);
  CHECK(edit({out, "--add", "generic/par", "--patch", "1.1", "-o", folder.file("c.toml")}).exit_code == 2);
}

TEST_CASE("what cannot be added is refused with the next step") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const Outcome unknown = edit({rig, "--add", "robe pointe"});
  CHECK(unknown.exit_code == 3);
  CHECK(contains(unknown.err, "'footlight fixtures list robe pointe' searches them"));
  const Outcome mode = edit({rig, "--add", "generic/par", "--mode", "nonsense"});
  CHECK(mode.exit_code == 3);
  CHECK(contains(mode.err, "has no mode 'nonsense'; it has '"));
  const Outcome both = edit({rig, "--add", "generic/par", "--select", "Par"});
  CHECK(both.exit_code == 2);
  CHECK(contains(both.err, "leave out --select, --clone and --delete"));
  CHECK(edit({rig, "--add", folder.write("a.qxf", "hello")}).exit_code == 2);
}

TEST_CASE("numbers may begin with a minus") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const std::string out = folder.file("out.toml");
  CHECK(edit({rig, "-s", "Par", "--move", "-1,-2,-0.5", "-o", out}).exit_code == 0);
  CHECK(fixtures_of(out)["Par"]["position_m"] == Json({-1.0, 0.0, 4.5}));
}

TEST_CASE("places are set axis by axis, and - keeps an axis") {
  const TempFolder folder;
  const std::string rig = folder.write("rig.toml", kEditedRig);
  const std::string out = folder.file("out.toml");
  CHECK(edit({rig, "-s", "Spot 3", "-s", "Spot *", "--place", "-,-2,6", "--place-step", "9,0.5,0", "--turn", "180,-,-",
              "-o", out})
            .exit_code == 0);
  const Json after = fixtures_of(out);
  CHECK(after["Spot 3"]["position_m"] == Json({2.0, -2.0, 6.0}));
  CHECK(after["Spot 1"]["position_m"] == Json({0.0, -1.5, 6.0}));
  CHECK(after["Spot 2"]["position_m"] == Json({1.0, -1.0, 6.0}));
}

}  // namespace
}  // namespace footlight::testing
