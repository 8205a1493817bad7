// Arbitrary text as rigs (first byte even) and fixture types (odd); valid ones are compiled.
#include "fixtures/builtin/builtin.h"
#include "fixtures/files/toml/fixture_toml.h"
#include "fixtures/model/rig.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  for (const auto& [name, text] : fixtures::builtin_files()) {
    seeds.add(name, (std::string_view(name) == "demo_rig.toml" ? "\x02" : "\x01") + std::string(text));
  }
  seeds.add("panes",
            "\x02[rig]\nname = \"x\"\n[sun]\ndirection = [0, -1, -1]\nsky_lx = 5\n[[pane]]\nposition = [0, 1, 2]\n"
            "rotation = [0, 0, 30]\nwidth_m = 2\nheight_m = 3\ncolor = [1, 0.5, 0]\n");
  seeds.add("displays",
            "\x02[rig]\nname = \"x\"\n[[display]]\nposition = [0, 1, 2]\nwidth_m = 2\nheight_m = 3\ncolumns = 30\n"
            "rows = 9\nnits = 900\nuniverse = 3\naddress = 7\norder = \"grbw\"\nserpentine = true\n"
            "start = \"bottom-left\"\ncolumns_first = true\npixels_per_universe = 100\ngamma = 2.2\n");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  if (data[0] % 2 == 1) {
    const auto type = fixtures::parse_fixture_type(text, "fuzz.toml");
    if (!type) require(type.error().message.starts_with("fuzz.toml"));
    return 0;
  }
  const auto rig = fixtures::parse_rig(text, "fuzz.toml");
  if (!rig) {
    require(!rig.error().message.empty());
    return 0;
  }
  require(!rig->cameras.empty());
  (void)fixtures::compile(*rig);
  return 0;
}
