// Rigs for tests of saving: an MVR file with a definition and a mesh of its own, and a rig file.
#pragma once

#include <string>

#include <doctest/doctest.h>

#include "fixtures/edit/rig_edits.h"
#include "tests/support/temp_folder.h"
#include "tests/support/zip_bytes.h"
#include "tools/footlight/edit/rig_file.h"

namespace footlight::testing {

inline std::string write_show(const TempFolder& folder, const std::string& name = "show.mvr") {
  const std::string gdtf = make_zip(
      {{"description.xml",
        "<GDTF DataVersion='1.2'><FixtureType Name='Bar' Manufacturer='Us'><Geometries><Beam Name='B'/></Geometries>"
        "<DMXModes><DMXMode Name='M' Geometry='B'><DMXChannels><DMXChannel Geometry='B' Offset='1'><LogicalChannel "
        "Attribute='Dimmer'><ChannelFunction/></LogicalChannel></DMXChannel><DMXChannel Geometry='B' Offset='2'>"
        "<LogicalChannel Attribute='Iris'><ChannelFunction/></LogicalChannel></DMXChannel></DMXChannels></DMXMode>"
        "</DMXModes></FixtureType></GDTF>"}});
  std::string fixtures;
  for (int i = 1; i <= 4; ++i) {
    fixtures += "<Fixture name=\"Bar " + std::to_string(i) + "\"><Matrix>{1,0,0}{0,1,0}{0,0,1}{" +
                std::to_string(1000 * i) + ",0,5000}</Matrix><GDTFSpec>B.gdtf</GDTFSpec><GDTFMode>M</GDTFMode>" +
                "<Addresses><Address>" + std::to_string(2 * i - 1) + "</Address></Addresses></Fixture>";
  }
  const std::string scene =
      "<GeneralSceneDescription verMajor=\"1\" verMinor=\"6\"><Scene><Layers><Layer name=\"L\">"
      "<ChildList>" +
      fixtures +
      "<Truss name=\"T\"><Matrix>{1,0,0}{0,1,0}{0,0,1}{0,0,5000}"
      "</Matrix><Geometries><Geometry3D fileName=\"leg.3ds\"/></Geometries></Truss>"
      "</ChildList></Layer></Layers></Scene></GeneralSceneDescription>";
  return folder.write(name, make_zip({{"GeneralSceneDescription.xml", scene}, {"B.gdtf", gdtf}, {"leg.3ds", "mesh"}}));
}

inline constexpr const char* kCommentedRig = R"(# The club, hung by hand
[rig]
name = "Club"
[[fixture]]
name = "Par {}"  # eight of them
type = "generic/par"
universe = 1
address = 1
position = [0, 0, 5]
count = 8
position_step = [1, 0, 0]
)";

inline tools::RigFile opened_file(const std::string& path) {
  static const fixtures::Library no_library = fixtures::Library::open({});
  fixtures::Diagnostics diagnostics;
  auto file = tools::RigFile::open(path, &no_library, diagnostics);
  REQUIRE_MESSAGE(file, file.error().message);
  return std::move(*file);
}

// Moves the fixtures whose indices are given up by half a metre.
inline void lift(tools::RigFile& file, const std::vector<int>& which) {
  auto edit = fixtures::move_fixtures(file.rig(), which, {0, 0, 0.5});
  REQUIRE(edit);
  edit->apply(file.rig());
}

inline tools::SaveReport saved(tools::RigFile& file) {
  auto report = file.save();
  REQUIRE_MESSAGE(report, report.error().message);
  return std::move(*report);
}

}  // namespace footlight::testing
