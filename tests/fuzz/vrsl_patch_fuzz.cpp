// Arbitrary JSON as patches of VRSL; what is read can be compiled, written and read again.
#include "fixtures/builtin/builtin.h"
#include "fixtures/files/export/vrsl_patch_json.h"
#include "fixtures/files/import/vrsl_patch.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  fixtures::Rig rig;
  rig.types = fixtures::vrsl_types();
  for (std::size_t i = 0; i < rig.types.size(); ++i) {
    fixtures::PatchedFixture fixture;
    fixture.name = rig.types[i].id;
    fixture.type = static_cast<int>(i);
    fixture.address = static_cast<Address>(1 + 39 * i);
    fixture.position_m = {static_cast<double>(i), 2, 3};
    rig.fixtures.push_back(fixture);
  }
  std::vector<std::string> notes;
  seeds.add("all", fixtures::vrsl_patch_json(rig, notes));
  rig.fixtures.resize(1);
  seeds.add("one", fixtures::vrsl_patch_json(rig, notes));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)fixtures::is_vrsl_patch(text);
  fixtures::Diagnostics diagnostics;
  const auto rig = fixtures::read_vrsl_patch(text, "fuzz.json", diagnostics);
  if (!rig) {
    require(rig.error().message.find("fuzz.json") != std::string::npos);
    return 0;
  }
  require(!rig->fixtures.empty());
  require(fixtures::compile(*rig).has_value());
  std::vector<std::string> notes;
  const std::string written = fixtures::vrsl_patch_json(*rig, notes);
  const auto again = fixtures::read_vrsl_patch(written, "again.json", diagnostics);
  require(again.has_value() && again->fixtures.size() == rig->fixtures.size());
  for (std::size_t i = 0; i < rig->fixtures.size(); ++i) {
    require(again->fixtures[i].patched == rig->fixtures[i].patched);
    require(again->fixtures[i].address == rig->fixtures[i].address);
    require(mode_of(*again, again->fixtures[i]).name == mode_of(*rig, rig->fixtures[i]).name);
  }
  return 0;
}
