// Arbitrary bytes as GDTF: archives (first byte even) and bare descriptions (odd). The result satisfies the model's
// invariants.
#include "fixtures/files/import/gdtf.h"
#include "fixtures/files/import/import.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/zip_bytes.h"

using namespace footlight;
using footlight::testing::require;

namespace {

constexpr const char* kDescription =
    "<GDTF DataVersion='1.2'><FixtureType Name='Head' Manufacturer='Us'>"
    "<Wheels><Wheel Name='G'><Slot Name='Open'/><Slot Name='S' MediaFileName='s' Color='0.3,0.3,50'/>"
    "<Slot><Facet Rotation='{1,0,0}{0,1,0}{0,0,1}'/></Slot></Wheel></Wheels>"
    "<PhysicalDescriptions><Emitters><Emitter Name='R' Color='0.7,0.29,20'><Measurement Physical='100'>"
    "<MeasurementPoint WaveLength='630' Energy='1'/></Measurement></Emitter></Emitters></PhysicalDescriptions>"
    "<Models><Model Name='B' Length='0.3' Width='0.2' Height='0.1' PrimitiveType='Base' File='b'/></Models>"
    "<Geometries><Geometry Name='P'><Beam Name='L' BeamAngle='9' EmitterSpectrum='R'/></Geometry>"
    "<Geometry Name='Base' Model='B'><Axis Name='Y' Position='{1,0,0,0}{0,1,0,0}{0,0,1,-0.3}{0,0,0,1}'>"
    "<GeometryReference Name='p1' Geometry='P'><Break DMXBreak='1' DMXOffset='1'/></GeometryReference>"
    "<GeometryReference Name='p2' Geometry='P'><Break DMXBreak='1' DMXOffset='1.4'/></GeometryReference>"
    "</Axis></Geometry></Geometries><DMXModes><DMXMode Name='M' Geometry='Base'><DMXChannels>"
    "<DMXChannel Geometry='Y' Offset='1,2' Default='128/1' Highlight='none' InitialFunction='Y_Pan.Pan.Pan 1'>"
    "<LogicalChannel Attribute='Pan' Snap='No'><ChannelFunction PhysicalFrom='-270' PhysicalTo='270' RealFade='3'>"
    "<ChannelSet Name='a' DMXFrom='0/1'/><ChannelSet DMXFrom='9/1s' PhysicalFrom='1'/></ChannelFunction>"
    "</LogicalChannel></DMXChannel>"
    "<DMXChannel Geometry='P' DMXBreak='Overwrite' Offset='3'><LogicalChannel Attribute='Gobo1'>"
    "<ChannelFunction Name='f' Wheel='G' ModeMaster='P_Gobo1.Gobo1.f' ModeFrom='0/1' ModeTo='9/1'>"
    "<ChannelSet DMXFrom='7/1' WheelSlotIndex='2'/></ChannelFunction></LogicalChannel></DMXChannel>"
    "</DMXChannels><Relations><Relation Master='Y_Pan' Follower='P_Gobo1.Gobo1.f' Type='Multiply'/></Relations>"
    "</DMXMode></DMXModes></FixtureType></GDTF>";

}  // namespace

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("description", "\x01" + std::string(kDescription));
  for (const unsigned method : {0u, 8u}) {
    seeds.add(
        "archive" + std::to_string(method),
        std::string(1, '\0') +
            make_zip({{"description.xml", kDescription, method}, {"wheels/s.png", "png"}, {"models/3ds/b.3ds", "m"}}));
  }
  seeds.add("odd_names", std::string(1, '\0') + make_zip({{"../a", "x"}, {"A", "x"}, {"a", "x"}, {"b\\c", "x", 12}}));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto* first = reinterpret_cast<const std::byte*>(data + 1);
  const char* name = data[0] % 2 == 0 ? "fuzz.gdtf" : "description.xml";
  fixtures::Diagnostics diagnostics;
  const auto type = fixtures::read_gdtf({name, "", {first, first + size - 1}, nullptr}, diagnostics);
  diagnostics.finish();
  if (!type) {
    require(!type.error().message.empty());
    require(diagnostics.count(fixtures::Severity::kError) > 0);
    return 0;
  }
  require(fixtures::problems(*type).empty());
  require(!type->modes.empty());
  if (type->files == nullptr) return 0;
  for (const std::string& file : type->files->names()) {
    require(!file.empty() && file.front() != '/' && !file.starts_with("../") && file.find("/../") == file.npos);
    const auto bytes = type->files->read(file, 1 << 20);
    require(!bytes || bytes->size() <= 1 << 20);
  }
  return 0;
}
