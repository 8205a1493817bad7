// Edits of rigs from the command line.
#include <filesystem>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

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
