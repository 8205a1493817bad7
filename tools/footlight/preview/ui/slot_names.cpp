#include "tools/footlight/preview/ui/slot_names.h"

#include <fmt/format.h>

#include "fixtures/displays/pixel_slots.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

std::vector<SlotName> names_of_slot(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled,
                                    const RigIndex& index, std::size_t universe, std::size_t slot) {
  std::vector<SlotName> names;
  for (const SlotUse& use : index.uses(universe, slot)) {
    const fixtures::Channel& channel = index.channel(use.key);
    SlotName name{rig.fixtures[static_cast<std::size_t>(use.key.fixture)].name, name_of(channel), use.key.fixture};
    if (channel.slot_offsets.size() > 1) {
      name.parameter += trf(", byte {} of {}", use.byte + 1, channel.slot_offsets.size());
    }
    names.push_back(std::move(name));
  }
  for (const fixtures::PixelUse& pixel :
       fixtures::pixel_uses(rig, compiled.universes[universe], static_cast<int>(slot))) {
    names.push_back({"", fixtures::text_of(pixel, rig), -1});
  }
  return names;
}

std::string text_of(const std::vector<SlotName>& names) {
  std::string words;
  for (const SlotName& name : names) {
    words += fmt::format("{}{}{}{}", words.empty() ? "" : " | ", name.fixture, name.fixture.empty() ? "" : ": ",
                         name.parameter);
  }
  return words;
}

}  // namespace footlight::tools
