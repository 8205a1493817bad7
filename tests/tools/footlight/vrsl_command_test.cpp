// Pictures from the command line: run, record and vrsl, as in docs/vrsl_pictures.md.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("pictures of the demo show are made, checked and recorded from the command line") {
  const TempFolder folder;
  const std::string pictures = "vrsl:1-9@" + folder.file("f_%03d.png");
  const Outcome made = footlight({"run", "--demo", "--out", pictures + "?fps=20&check=yes", "--for", "300ms"});
  CHECK_MESSAGE(made.exit_code == 0, made.err);

  const Outcome checked = footlight({"vrsl", "check", folder.file("f_002.png"), "--json", "--levels", "--format",
                                     "layout=horizontal-bottom&planes=rgb&check=yes"});
  CHECK_MESSAGE(checked.exit_code == 0, checked.err);
  const auto json = nlohmann::json::parse(checked.out);
  CHECK(json["layout"] == "horizontal-bottom");
  CHECK(json["confidence"] == 1.0);
  CHECK(json["sequence"] == 2);
  CHECK(json["damaged"] == false);
  CHECK(json["unreachable"] == 0);
  CHECK(json["vrsl_unread"] == 120);
  CHECK(json["vrsl_guard_tripped"] == false);
  REQUIRE(json["universes"].size() == 9);
  CHECK(json["universes"][0]["levels"].size() == 512);

  const Outcome recorded = footlight(
      {"record", "--in", pictures + "?fps=20&check=yes&layout=horizontal-bottom", "-o", folder.file("back.dmxlog")});
  CHECK_MESSAGE(recorded.exit_code == 0, recorded.err);
  const Outcome info = footlight({"log", "info", folder.file("back.dmxlog"), "--json"});
  const auto universes = nlohmann::json::parse(info.out)["universes"];
  CHECK(universes.size() == 9);
}

TEST_CASE("vrsl check reports what is wrong with a file, and with its arguments") {
  const TempFolder folder;
  const Outcome missing = footlight({"vrsl", "check", "no_such.png"});
  CHECK(missing.exit_code == 3);
  CHECK(contains(missing.err, "no_such.png: No such file"));
  const Outcome other = footlight({"vrsl", "check", FOOTLIGHT_SOURCE_DIR "/docs/demo.png"});
  CHECK(other.exit_code == 3);
  CHECK(contains(other.err, "no grid"));
  const Outcome text = footlight({"vrsl", "check", folder.write("text.png", "not a picture")});
  CHECK(text.exit_code == 2);
  CHECK(contains(text.err, "expected PNG or JPEG"));
  const Outcome format =
      footlight({"vrsl", "check", FOOTLIGHT_SOURCE_DIR "/docs/demo.png", "--format", "layout=sideways"});
  CHECK(format.exit_code == 2);
  CHECK(contains(format.err, "layout=sideways: expected horizontal-bottom"));
  const Outcome way = footlight({"vrsl", "round-trip", "--way", "pigeon"});
  CHECK(way.exit_code == 2);
  CHECK(contains(way.err, "--way pigeon: expected one of none"));
}

}  // namespace
}  // namespace footlight::testing
