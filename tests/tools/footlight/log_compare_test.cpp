// `footlight log compare`, and the comparison of two moments behind it.
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/monitor/level_moment.h"

namespace footlight::testing {
namespace {

using tools::compare_moments;
using tools::LevelMoment;
using tools::SlotDifference;

LevelMoment moment_with(std::vector<std::pair<Universe, std::vector<std::uint8_t>>> universes) {
  LevelMoment moment;
  for (auto& [universe, levels] : universes) {
    levels.resize(kSlotCountMax);
    moment.universes.push_back(universe);
    moment.levels.insert(moment.levels.end(), levels.begin(), levels.end());
  }
  return moment;
}

TEST_CASE("two moments differ in the slots of which levels are further apart than allowed") {
  const LevelMoment a = moment_with({{1, {0, 10, 20}}, {4, {7}}});
  const LevelMoment b = moment_with({{1, {0, 12, 255}}, {4, {7}}});
  const auto both = compare_moments(a, b);
  CHECK(!both.equal());
  CHECK(both.slots == std::vector<SlotDifference>{{1, 2, 10, 12}, {1, 3, 20, 255}});
  CHECK(both.slots_of(1) == 2);
  CHECK(both.slots_of(4) == 0);
  CHECK(both.slots_of(2) == 0);
  CHECK(compare_moments(a, b, 2).slots == std::vector<SlotDifference>{{1, 3, 20, 255}});
  CHECK(compare_moments(a, b, 235).equal());
  CHECK(compare_moments(a, a).equal());
}

TEST_CASE("a universe that only one moment has is dark in the other, and equal if it is dark there too") {
  const LevelMoment a = moment_with({{1, {5}}, {3, {}}});
  const LevelMoment b = moment_with({{1, {5}}, {2, {9}}});
  const auto both = compare_moments(a, b);
  REQUIRE(both.universes.size() == 3);
  CHECK(both.slots == std::vector<SlotDifference>{{2, 1, 0, 9}});
  CHECK(!both.universes[1].in_a);
  CHECK(both.universes[1].in_b);
  CHECK(both.universes[2].in_a);
  CHECK(both.universes[2].slots == 0);
  CHECK(!both.equal());
  CHECK(compare_moments(a, moment_with({{1, {5}}})).equal());  // universe 3 is dark
  CHECK(compare_moments(LevelMoment{}, LevelMoment{}).equal());
  // Fewer levels than universes: those are not there.
  LevelMoment cut = a;
  cut.levels.resize(700);
  CHECK(!compare_moments(a, cut).universes[1].in_b);
}

// Universe 1 has frames at 0, 1 and 2 s, universe 2 one at 1.5 s; 3 s long.
std::string write_log(const TempFolder& folder, const std::string& name, std::uint8_t last) {
  const std::string path = folder.file(name);
  LogWriter writer = LogWriter::create(path, {.universes = {1, 2}}).value();
  const auto frame = [&](TimeNs at_ns, Universe universe, std::vector<std::uint8_t> slots) {
    FrameView view;
    view.universe = universe;
    view.stamp_ns = at_ns;
    view.slots = slots;
    REQUIRE(writer.append(view));
  };
  frame(0, 1, {10, 20, 30});
  frame(kNsPerS, 1, {10, 21, 30});
  frame(kNsPerS * 3 / 2, 2, {1});
  frame(2 * kNsPerS, 1, {10, 21, last});
  REQUIRE(writer.close(3 * kNsPerS));
  return path;
}

TEST_CASE("log compare lists the slots between two times of a log, with the fixtures of a rig") {
  const TempFolder folder;
  const std::string log = write_log(folder, "a.dmxlog", 99);
  const std::string rig = folder.write("rig.toml",
                                       "[rig]\nname = \"r\"\n[[fixture]]\nname = \"Head\"\ntype = \"generic/profile\"\n"
                                       "universe = 1\naddress = 1\nposition = [0, 0, 5]\n");
  const Outcome text = footlight({"log", "compare", log, "--at", "0.5s", "--with", "2s", "--rig", rig});
  CHECK(text.exit_code == 1);
  CHECK(text.out.find("universe 1: 2 slots differ\n") != std::string::npos);
  CHECK(text.out.find("universe 2: 1 slot differs, no frame in A\n") != std::string::npos);
  CHECK(text.out.find("1.2   20 ->  21  Head: Pan, byte 2 of 2\n") != std::string::npos);
  CHECK(text.out.find("1.3   30 ->  99  Head: Tilt, byte 1 of 2\n") != std::string::npos);
  CHECK(text.out.find("different\n") != std::string::npos);

  const Outcome json = footlight({"log", "compare", log, "--at", "1s", "--with", "2s", "--json", "--rig", rig});
  CHECK(json.exit_code == 1);
  const auto line = nlohmann::json::parse(json.out);
  CHECK(line["equal"] == false);
  CHECK(line["with_ns"] == 2 * kNsPerS);
  REQUIRE(line["slots"].size() == 2);
  CHECK(line["slots"][0]["address"] == 3);
  CHECK(line["slots"][0]["b"] == 99);
  CHECK(line["slots"][0]["uses"][0]["fixture"] == "Head");
  CHECK(!line["slots"][1].contains("uses"));  // of universe 2, which the rig does not use

  const Outcome same = footlight({"log", "compare", log, "--at", "1.6s", "--with", "1.9s"});
  CHECK(same.exit_code == 0);
  CHECK(same.out.find("universe 1: no slot differs\n") != std::string::npos);
  CHECK(same.out.find("equal\n") != std::string::npos);
}

TEST_CASE("log compare names a universe without a frame, and exits with 0 if no slot differs") {
  const TempFolder folder;
  const std::string path = folder.file("dark.dmxlog");
  LogWriter writer = LogWriter::create(path, {.universes = {1}}).value();
  FrameView view;
  view.universe = 1;
  view.stamp_ns = kNsPerS;
  const std::vector<std::uint8_t> dark(4);
  view.slots = dark;
  REQUIRE(writer.append(view));
  REQUIRE(writer.close(2 * kNsPerS));
  const Outcome text = footlight({"log", "compare", path, "--at", "0.5s", "--with", "1.5s"});
  CHECK(text.exit_code == 0);
  CHECK_MESSAGE(text.out.find("universe 1: no slot differs, no frame in A\nequal\n") != std::string::npos, text.out);
}

TEST_CASE("log compare compares two logs at one time, and at two") {
  const TempFolder folder;
  const std::string a = write_log(folder, "a.dmxlog", 99);
  const std::string b = write_log(folder, "b.dmxlog", 97);
  CHECK(footlight({"log", "compare", a, b, "--at", "1.9s"}).exit_code == 0);
  const Outcome differ = footlight({"log", "compare", a, b, "--at", "2.5s"});
  CHECK(differ.exit_code == 1);
  CHECK(differ.out.find("1.3   99 ->  97\n") != std::string::npos);
  CHECK(footlight({"log", "compare", a, b, "--at", "2.5s", "--values", "2"}).exit_code == 0);
  CHECK(footlight({"log", "compare", a, b, "--at", "2s", "--with", "1s"}).exit_code == 1);
}

TEST_CASE("log compare says which time or file is missing") {
  const TempFolder folder;
  const std::string log = write_log(folder, "a.dmxlog", 99);
  const auto refused = [](std::vector<std::string> words, const char* part) {
    const Outcome outcome = footlight(words);
    CHECK(outcome.exit_code == 2);
    CHECK_MESSAGE(outcome.err.find(part) != std::string::npos, outcome.err);
  };
  refused({"log", "compare"}, "--at 10s");
  refused({"log", "compare", log}, "--at 10s");
  refused({"log", "compare", log, "--at", "1s"}, "--with TIME");
  refused({"log", "compare", log, "--at", "1s", "--with", "3.1s"}, "expected a time up to 3.00 s");
}

}  // namespace
}  // namespace footlight::testing
