// Arbitrary text as QLC+ definitions: a loaded type satisfies the model's invariants, an error names its place.
#include <cstring>

#include "fixtures/files/import/import.h"
#include "fixtures/files/import/qxf.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("small.qxf", R"(<FixtureDefinition><Manufacturer>M</Manufacturer><Model>X</Model><Type>Moving Head</Type>
<Channel Name="Pan" Preset="PositionPan"/><Channel Name="Pan fine" Preset="PositionPanFine"/>
<Channel Name="Wheel"><Group Byte="0">Colour</Group>
<Capability Min="0" Max="9" Preset="ColorMacro" Res1="#ff0000">R</Capability>
<Capability Min="10" Max="99" Preset="ColorDoubleMacro" Res1="#ff0000" Res2="#00ff00">RG</Capability>
<Capability Min="100" Max="255">Rotation cw, 1-20 rpm</Capability></Channel>
<Channel Name="Gobo"><Group Byte="0">Gobo</Group><Capability Min="0" Max="9">Gobo 1 shake</Capability></Channel>
<Channel Name="Shutter"><Group Byte="0">Shutter</Group>
<Capability Min="0" Max="99" Preset="StrobeFreqRange" Res1="1" Res2="9">S</Capability>
<Capability Min="100" Max="200" Preset="Alias">A<Alias Mode="M" Channel="Gobo" With="Pan"/></Capability></Channel>
<Mode Name="M"><Channel Number="0">Pan</Channel><Channel Number="1">Pan fine</Channel>
<Channel Number="2">Wheel</Channel>
<Channel Number="3">Gobo</Channel><Channel Number="4">Shutter</Channel><Head><Channel>2</Channel></Head><Head>
<Channel>3</Channel></Head></Mode>
<Physical><Bulb Type="LED" Lumens="100" ColourTemperature="0"/><Dimensions Weight="1" Width="2" Height="3" Depth="4"/>
<Lens Name="Other" DegreesMin="1" DegreesMax="2"/><Focus Type="Head" PanMax="1" TiltMax="2"/>
<Layout Width="2" Height="1"/></Physical>
</FixtureDefinition>)");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fixtures::Bytes bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  fixtures::Diagnostics diagnostics;
  const auto type = fixtures::read_qxf({"fuzz.qxf", "", std::move(bytes), nullptr}, diagnostics);
  if (type) {
    require(fixtures::problems(*type).empty());
  } else {
    require(diagnostics.count(fixtures::Severity::kError) > 0);
  }
  return 0;
}
