#include "tools/footlight/monitor/slot_meanings.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/preview/ui/channel_reading.h"

namespace footlight::tools {

Result<SlotMeanings> SlotMeanings::of(const std::string& path) {
  SlotMeanings meanings;
  if (path.empty()) return meanings;
  SceneFiles files;
  files.rig = path;
  meanings.rig_ = std::make_unique<fixtures::Rig>();
  FL_ASSIGN(*meanings.rig_, load_scene_rig(files));
  FL_ASSIGN(fixtures::CompiledRig compiled, fixtures::compile(*meanings.rig_));
  meanings.compiled_ = std::make_unique<fixtures::CompiledRig>(std::move(compiled));
  meanings.index_ = std::make_unique<RigIndex>(*meanings.rig_, *meanings.compiled_);
  return meanings;
}

std::size_t SlotMeanings::at(Universe universe) const {
  if (!rig_) return 0;
  const auto& all = compiled_->universes;
  const auto found = std::lower_bound(all.begin(), all.end(), universe);
  return found == all.end() || *found != universe ? all.size() : static_cast<std::size_t>(found - all.begin());
}

std::vector<SlotName> SlotMeanings::of_slot(Universe universe, Address address) const {
  if (!rig_ || at(universe) == compiled_->universes.size()) return {};
  return names_of_slot(*rig_, *compiled_, *index_, at(universe), static_cast<std::size_t>(slot_of_address(address)));
}

std::string SlotMeanings::words(Universe universe, Address address, const LevelView& levels) const {
  const std::vector<SlotName> names = of_slot(universe, address);
  if (names.empty()) return "";
  std::vector<std::uint8_t> all(compiled_->universes.size() * kSlotCountMax);
  for (std::size_t i = 0; i < compiled_->universes.size(); ++i) {
    const auto from = levels.of(compiled_->universes[i]);
    std::copy(from.begin(), from.end(), all.begin() + static_cast<std::ptrdiff_t>(i * kSlotCountMax));
  }
  const auto uses = index_->uses(at(universe), static_cast<std::size_t>(slot_of_address(address)));
  std::string words;
  for (std::size_t i = 0; i < names.size(); ++i) {  // fixtures come first, in the order of the uses
    words += (words.empty() ? "" : " | ") + text_of({names[i]});
    if (i >= uses.size()) continue;
    const ChannelKey key = uses[i].key;
    const auto reading = reading_of(fixtures::type_of(*rig_, rig_->fixtures[static_cast<std::size_t>(key.fixture)]),
                                    index_->channel(key), index_->read(key, all), [&](int other) {
                                      return index_->read({key.fixture, other}, all);
                                    });
    words += ": " + text_of(reading);
  }
  return words;
}

}  // namespace footlight::tools
