// footlight laser: ILDA files, and lasers against the exposure that eyes may get.
#include <fstream>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include "tests/support/ilda_bytes.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

constexpr const char* kClub = R"([rig]
name = "Club"
[[fixture]]
name = "Left"
type = "generic/laser"
universe = 1
address = 1
position = [0, 5, 4]
aim = [0, -5, 4]
)";

TEST_CASE("laser check counts the frames and points of ILDA files, and refuses one without a frame by its name") {
  const TempFolder folder;
  const std::string frame = ilda_section(5, {{-32768, 0, 0, 0x40, 0, 9, 9, 9}, {0, 0, 0, 0, 0, 255, 0, 0}});
  std::ofstream(folder.file("logo.ild"), std::ios::binary) << frame << frame << ilda_end();
  const Outcome good = footlight({"laser", "check", folder.file("logo.ild")});
  CHECK(good.exit_code == 0);
  CHECK(contains(good.out, "logo.ild: 2 frames, 4 points (2 of them lit), at most 2 in a frame, 0 palettes"));
  std::ofstream(folder.file("empty.ild"), std::ios::binary) << ilda_end();
  const Outcome both = footlight({"laser", "check", folder.file("empty.ild"), folder.file("logo.ild")});
  CHECK(both.exit_code == 1);
  CHECK(contains(both.err, "empty.ild"));
  CHECK(contains(both.err, "no frame"));
  CHECK(contains(both.out, "logo.ild: 2 frames"));
  const Outcome none = footlight({"laser", "check"});
  CHECK(none.exit_code == 2);
  CHECK(contains(none.err, "logo.ild"));
}

TEST_CASE("laser safety warns of eyes in the field of a laser, and of none beside it") {
  const TempFolder folder;
  std::ofstream(folder.file("club.toml")) << kClub;
  // On the axis of the laser, whose lens is 0.2 m before its place, and behind it.
  const Outcome inside = footlight({"laser", "safety", folder.file("club.toml"), "--at", "0,0,4"});
  CHECK(inside.exit_code == 1);
  CHECK(contains(inside.out, "Left at 0,0,4: 4.8 m, in the field of its scanner"));
  CHECK(contains(inside.out, "times the MPE"));
  CHECK(contains(inside.out, "no statement that anything is safe"));
  const Outcome behind = footlight({"laser", "safety", folder.file("club.toml"), "--at", "0,10,4"});
  CHECK(behind.exit_code == 0);
  CHECK(contains(behind.out, "beside the field of its scanner"));
  const Outcome both = footlight({"laser", "safety", folder.file("club.toml"), "--at", "0,10,4", "--at", "0,0,4"});
  CHECK(both.exit_code == 1);
}

TEST_CASE("laser safety refuses a place that is none, a rig without a laser and one without a place of eyes") {
  const TempFolder folder;
  std::ofstream(folder.file("club.toml")) << kClub;
  for (const char* place : {"0,-6", "0,-6,x", "0,-6,1.6m", "inf,0,0", ""}) {
    CAPTURE(place);
    const Outcome outcome = footlight({"laser", "safety", folder.file("club.toml"), "--at", place});
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.err, "--at"));
    CHECK(contains(outcome.err, "0,-6,1.6"));
  }
  const Outcome nowhere = footlight({"laser", "safety", folder.file("club.toml")});
  CHECK(nowhere.exit_code == 2);
  CHECK(contains(nowhere.err, "no camera"));
  std::ofstream(folder.file("pars.toml")) << "[rig]\nname = \"Pars\"\n[[fixture]]\nname = \"Par\"\n"
                                             "type = \"generic/par\"\nuniverse = 1\naddress = 1\n"
                                             "position = [0, 0, 4]\n";
  const Outcome pars = footlight({"laser", "safety", folder.file("pars.toml"), "--at", "0,0,1"});
  CHECK(pars.exit_code == 3);
  CHECK(contains(pars.err, "generic/laser"));
}

}  // namespace
}  // namespace footlight::testing
