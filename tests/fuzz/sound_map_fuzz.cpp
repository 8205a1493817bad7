// Arbitrary text as sound maps. A map that is read gives levels for any step, or an error that names the map.
#include "fixtures/files/toml/sound_toml.h"
#include "fixtures/model/rig.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add("channels",
            "sound = \"a.flac\"\ngain = 1.5\ncrossover = [0, 0.2, 0.5, 0.7]\ntheme = [1,0,0,0,1,0,0,0,1,1,1,1]\n"
            "[[channel]]\nsignal = \"bass\"\nuniverse = 2\naddress = 3\nattack_s = 0.1\nrelease_s = 0.2\n"
            "threshold = 0.3\nlow = 10\nhigh = 200\ndelay = 5\n[[channel]]\nsignal = \"tempo\"\naddress = 4\n");
  seeds.add("lights",
            "sound = \"alsa:default\"\n[[light]]\nfixture = \"Spot *\"\nband = \"treble\"\ndelay_step = 3\n"
            "multiplier = 15\ncolor = \"theme 2\"\nsmooth = false\nset = \"Tilt=20\"\n");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto map = fixtures::parse_sound_map(text, "fuzz.toml");
  if (!map) {
    require(map.error().message.starts_with("fuzz.toml"));
    return 0;
  }
  auto levels = fixtures::SoundLevels::create(*map, fixtures::demo_rig());
  if (!levels) {
    require(!levels.error().message.empty());
    return 0;
  }
  AudioLinkState state;
  for (int step = 1; step < 4; ++step) {
    state.step = static_cast<std::uint64_t>(step);
    for (auto& band : state.bands) band.fill(static_cast<float>(step) / 4);
    levels->step(state);
  }
  for (const auto& [universe, slots] : levels->universes()) require(is_universe(universe));
  return 0;
}
