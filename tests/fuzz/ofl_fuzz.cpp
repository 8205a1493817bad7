// Arbitrary text as Open Fixture Library definitions: a loaded type satisfies the model's invariants, an error names
// its place.
#include <cstring>

#include "fixtures/files/import/import.h"
#include "fixtures/files/import/ofl.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("matrix.json", R"({"name":"X","matrix":{"pixelCount":[2,2,1],"pixelGroups":{"A":"all","B":{"x":["=1"]}}},
"wheels":{"W":{"slots":[{"type":"Open"},{"type":"Gobo"},{"type":"Color","colors":["#ff0000"]},{"type":"Prism",
"facets":5}]}},
"availableChannels":{"W":{"fineChannelAliases":["W fine"],"dmxValueResolution":"8bit","defaultValue":"50%",
"capabilities":[
{"dmxRange":[0,9],"type":"WheelSlot","slotNumber":1.5,"switchChannels":{"S":"P"}},
{"dmxRange":[10,255],"type":"WheelShake","slotNumber":2,"shakeSpeedStart":"24bpm","shakeSpeedEnd":"fast"}]},
"P":{"capability":{"type":"Pan","angleStart":"0deg","angleEnd":"540deg"}}},
"templateChannels":{"R $pixelKey":{"capability":{"type":"ColorIntensity","color":"Red"}}},
"modes":[{"name":"M","channels":["W","W fine","S",null,{"insert":"matrixChannels","repeatFor":"eachPixelXYZ",
"channelOrder":"perPixel","templateChannels":["R $pixelKey"]}]}]})");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fixtures::Bytes bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  fixtures::Diagnostics diagnostics;
  const auto type = fixtures::read_ofl({"fuzz.json", "", std::move(bytes), nullptr}, diagnostics);
  if (type) {
    require(fixtures::problems(*type).empty());
  } else {
    require(diagnostics.count(fixtures::Severity::kError) > 0);
  }
  return 0;
}
