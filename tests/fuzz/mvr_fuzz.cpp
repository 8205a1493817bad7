// Arbitrary GeneralSceneDescription.xml files and workspaces of QLC+. The archive is made around the bytes, so that the
// fuzzer need not find the zip format. The result must be a rig that compiles, and that can be exported and imported
// again.
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/files/export/mvr.h"
#include "fixtures/files/import/mvr.h"
#include "fixtures/files/import/qxw.h"
#include "fixtures/paperwork/patch_sheet.h"
#include "fixtures/paperwork/plan.h"
#include "tests/fuzz/fuzz.h"

namespace footlight {
namespace {

using namespace fixtures;

// One scene and one mesh.
class OneScene : public Files {
 public:
  explicit OneScene(std::string_view scene) : scene_(scene) {}
  [[nodiscard]] const std::vector<std::string>& names() const override { return names_; }
  [[nodiscard]] Result<Bytes> read(std::string_view name, std::uint64_t) const override {
    if (name != kSceneDescription) return Bytes(4);
    const auto* first = reinterpret_cast<const std::byte*>(scene_.data());
    return Bytes(first, first + scene_.size());
  }
  [[nodiscard]] std::string shown_name(std::string_view name) const override { return std::string(name); }

 private:
  std::string scene_;
  std::vector<std::string> names_{std::string(kSceneDescription), "leg.3ds"};
};

const Library& no_library() {
  static const Library library = Library::open({});
  return library;
}

Result<ImportedRig> read(std::string_view text, bool workspace) {
  Diagnostics diagnostics;
  auto rig = workspace ? read_qxw(text, "fuzz.qxw", &no_library(), diagnostics)
                       : read_mvr(std::make_shared<OneScene>(text), "fuzz.mvr", &no_library(), diagnostics);
  diagnostics.finish();
  testing::require(rig || diagnostics.count(Severity::kError) > 0);
  return rig;
}

void check(const ImportedRig& imported) {
  const Rig& rig = imported.rig;
  testing::require(imported.definitions.size() == rig.types.size());
  testing::require(!rig.cameras.empty());
  for (const FixtureType& type : rig.types) testing::require(!type.modes.empty());
  for (const PatchedFixture& fixture : rig.fixtures) {
    const glm::dmat4 pose = pose_of(fixture);
    for (int column = 0; column < 4; ++column) testing::require(std::isfinite(glm::length(pose[column])));
  }
  testing::require(compile(rig).has_value());
  testing::require(!patch_html(rig, {}).empty() && !patch_csv(rig).empty());
  const auto drawing = plan_svg(rig, {});
  testing::require(drawing && drawing->ends_with("</svg>\n"));
}

}  // namespace
}  // namespace footlight

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace footlight;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const bool workspace = text.find("<Workspace") != std::string_view::npos;
  const auto rig = read(text, workspace);
  if (!rig) return 0;
  check(*rig);
  if (rig->rig.fixtures.size() > 50) return 0;
  const auto again = read(fixtures::scene_description(*rig), false);
  testing::require(again.has_value());
  testing::require(again->rig.fixtures.size() == rig->rig.fixtures.size());
  check(*again);
  return 0;
}

void footlight::testing::add_seeds(Seeds& seeds) {
  const auto scene = [](const std::string& inside, const std::string& aux) {
    return "<GeneralSceneDescription verMajor=\"1\" verMinor=\"6\"><Scene><Layers><Layer name=\"L\"><ChildList>" +
           inside + "</ChildList></Layer></Layers><AUXData>" + aux + "</AUXData></Scene></GeneralSceneDescription>";
  };
  const std::string matrix = "<Matrix>{1,0,0}{0,1,0}{0,0,1}{1000,-2.5e3,6000}</Matrix>";
  seeds.add("fixture",
            scene("<Fixture name=\"A\" uuid=\"1\">" + matrix +
                      "<GDTFSpec>Generic@Profile.gdtf</GDTFSpec><GDTFMode>16 bit</GDTFMode><Focus>F</Focus>"
                      "<Addresses><Address break=\"0\">2.100</Address><Address break=\"1\">1030</Address></Addresses>"
                      "<DMXInvertPan>true</DMXInvertPan><Position>P</Position><FixtureID>1</FixtureID></Fixture>"
                      "<FocusPoint name=\"F\" uuid=\"F\"/>",
                  "<Position uuid=\"P\" name=\"LX1\"/><Class uuid=\"C\" name=\"c\"/>"));
  seeds.add("objects",
            scene("<GroupObject>" + matrix +
                      "<ChildList><Truss name=\"T\"><Geometries><Geometry3D fileName=\"leg\"/>"
                      "<Symbol symdef=\"S\">" +
                      matrix + "</Symbol></Geometries></Truss></ChildList></GroupObject>",
                  "<Symdef uuid=\"S\"><ChildList><Geometry3D fileName=\"leg.3ds\"/><Symbol symdef=\"S\"/></ChildList>"
                  "</Symdef>"));
  seeds.add("workspace",
            "<Workspace><Engine><Fixture><Manufacturer>Generic</Manufacturer><Model>Generic</Model><ID>1</ID>"
            "<Name>A</Name><Universe>0</Universe><Address>5</Address><Channels>6</Channels></Fixture>"
            "<Monitor><Grid Width=\"5\" Height=\"3\" Depth=\"5\" Units=\"0\"/><FxItem ID=\"1\" XPos=\"1\" YPos=\"2\" "
            "ZPos=\"3\" XRot=\"90\"/></Monitor></Engine></Workspace>");
}
