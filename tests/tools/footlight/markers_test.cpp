// Markers of a log: their order and names, the file beside the log, and undo.
#include "tools/footlight/preview/ui/markers.h"

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::tools {
namespace {

Markers three() {
  Markers markers;
  for (const TimeNs at_ns : {20 * kNsPerS, 5 * kNsPerS, 12 * kNsPerS}) markers = with_marker(markers, at_ns).value();
  return markers;
}

TEST_CASE("markers are in the order of their times, with the first free number, and never on top of each other") {
  Markers markers = three();
  REQUIRE(markers.size() == 3);
  CHECK(markers[0] == Marker{5 * kNsPerS, "Marker 2"});
  CHECK(markers[1] == Marker{12 * kNsPerS, "Marker 3"});
  CHECK(markers[2] == Marker{20 * kNsPerS, "Marker 1"});
  const auto near = with_marker(markers, 12 * kNsPerS + kMarkerNearNs - 1);
  REQUIRE(!near);
  CHECK(near.error().message.find("Marker 3") != std::string::npos);
  CHECK(with_marker(markers, 12 * kNsPerS + kMarkerNearNs));
  markers.erase(markers.begin());
  CHECK(with_marker(markers, 0).value()[0].name == "Marker 2");
  markers.assign(kMarkersMax, {kNsPerS, "x"});
  CHECK(!with_marker(markers, 0));
  // The file beside the log could not be read again.
  CHECK(with_marker({}, 10'000'000 * kNsPerS));
  CHECK(!with_marker({}, 10'000'001 * kNsPerS));
  CHECK(!with_marker({}, -1));
}

TEST_CASE("the next marker and the one before are strictly after and before a time") {
  const Markers markers = three();
  CHECK(marker_after(markers, 0)->at_ns == 5 * kNsPerS);
  CHECK(marker_after(markers, 5 * kNsPerS)->at_ns == 12 * kNsPerS);
  CHECK(marker_after(markers, 20 * kNsPerS) == nullptr);
  CHECK(marker_before(markers, 20 * kNsPerS)->at_ns == 12 * kNsPerS);
  CHECK(marker_before(markers, 5 * kNsPerS) == nullptr);
  CHECK(marker_before({}, 0) == nullptr);
}

TEST_CASE("the file beside the log gives back every time to the nanosecond, and every name") {
  const testing::TempFolder folder;
  const std::string path = markers_path(folder.file("show.dmxlog"));
  CHECK(path == folder.file("show.dmxlog.markers.toml"));
  CHECK(load_markers(path).value().empty());  // there is no file
  Markers markers = three();
  markers[0].at_ns = 4'999'999'999;
  markers[1].name = "Chor \"zwei\" \\ é";
  markers[2].at_ns = 8'000'000 * kNsPerS + 123'456'789;
  REQUIRE(save_markers(path, markers));
  const auto read = load_markers(path);
  REQUIRE(read);
  CHECK((*read)[0] == markers[0]);
  CHECK((*read)[1] == markers[1]);
  CHECK(std::abs((*read)[2].at_ns - markers[2].at_ns) <= 1);
  REQUIRE(save_markers(path, {}));
  CHECK(load_markers(path).value().empty());
  CHECK(!save_markers(folder.file("no folder/x.toml"), markers));
}

TEST_CASE("a file of markers that is wrong is refused with its line") {
  const auto message = [](const char* text) { return parse_markers(text, "m.toml").error().message; };
  CHECK(message("[[marker]]\nat_s = -1\nname = \"a\"\n").find("m.toml:2") != std::string::npos);
  CHECK(message("[[marker]]\nat_s = 1\nname = \"\"\n").find("m.toml:3") != std::string::npos);
  CHECK(message("[[marker]]\nat_s = 1\nname = \"a\"\ncolour = 3\n").find("colour") != std::string::npos);
  CHECK(!parse_markers("[[marker]]\nat_s = 1\n", "m.toml"));
  const auto unsorted = parse_markers("[[marker]]\nat_s = 2\nname = \"b\"\n[[marker]]\nat_s = 1\nname = \"a\"\n", "m");
  REQUIRE(unsorted);
  CHECK((*unsorted)[0].name == "a");
}

TEST_CASE("setting, naming and deleting a marker can be undone, each by itself") {
  const testing::UiRig rig = testing::compiled_rig(testing::parsed_rig(testing::kUiRig));
  UiDesk desk(rig.rig, rig.compiled);
  desk.start_markers({{kNsPerS, "Start"}});
  REQUIRE(desk.add_marker(3 * kNsPerS));
  REQUIRE(desk.rename_marker(1, "Chorus"));
  CHECK(!desk.rename_marker(1, ""));
  CHECK(!desk.rename_marker(1, std::string(kMarkerNameMax + 1, 'x')));
  CHECK(!desk.rename_marker(1, "a\nb"));
  desk.remove_marker(0);
  CHECK(desk.state().markers == Markers{{3 * kNsPerS, "Chorus"}});
  CHECK(desk.undo() == "delete the marker Start");
  CHECK(desk.undo() == "name the marker Chorus");
  CHECK(desk.state().markers == Markers{{kNsPerS, "Start"}, {3 * kNsPerS, "Marker 1"}});
  CHECK(desk.undo() == "add a marker");
  CHECK(desk.state().markers == Markers{{kNsPerS, "Start"}});
  CHECK(desk.redo() == "add a marker");
  CHECK(desk.state().markers.size() == 2);
}

}  // namespace
}  // namespace footlight::tools
