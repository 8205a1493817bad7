#include "tools/footlight/preview/ui/slot_tip.h"

#include <fmt/format.h>

#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/slot_names.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

// ": -32.5°", with the attribute in front where the name of the channel is another one.
std::string value_of(UiDesk& desk, const UiInput& input, ChannelKey key) {
  const fixtures::PatchedFixture& one = desk.rig().fixtures[static_cast<std::size_t>(key.fixture)];
  const fixtures::Channel& channel = desk.index().channel(key);
  const ChannelReading reading =
      reading_of(fixtures::type_of(desk.rig(), one), channel, desk.index().read(key, input.levels), [&](int other) {
        return desk.index().read({key.fixture, other}, input.levels);
      });
  const bool other_name = reading.function != nullptr && reading.function->attribute != name_of(channel);
  return fmt::format("{}: {}", other_name ? fmt::format(" ({})", reading.function->attribute) : "", text_of(reading));
}

}  // namespace

SlotTip tip_of_slot(UiDesk& desk, const UiInput& input, std::size_t universe, std::size_t slot,
                    const SlotChanges& changes, TimeNs now_ns) {
  SlotTip tip;
  const std::uint8_t level = changes.levels[slot];
  tip.level = trf("{}.{}  level {} ({:.0f} %)", desk.compiled().universes[universe], slot + 1, level, level / 2.55);
  const auto uses = desk.index().uses(universe, slot);
  const std::size_t at = universe * kSlotCountMax + slot;
  const bool is_now = at < input.levels.size() && input.levels[at] == level;
  const std::vector<SlotName> names = names_of_slot(desk.rig(), desk.compiled(), desk.index(), universe, slot);
  for (std::size_t i = 0; i < names.size(); ++i) {  // fixtures come first, in the order of the uses
    std::string words = text_of({names[i]});
    if (is_now && i < uses.size()) words += value_of(desk, input, uses[i].key);
    tip.means.push_back(std::move(words));
  }
  const LevelSource of_universe = source_of_universe(desk, input, universe, slot);
  tip.from = uses.empty() ? of_universe.words : source_of_channel(desk, input, uses.front().key).words;
  if (of_universe.kind == SourceKind::kLive && universe < input.stamps.size()) {
    tip.ages = trf_marked(of_universe.rarely ? tr_mark("last change {:.1f} s ago") : tr_mark("last frame {:.1f} s ago"),
                          static_cast<double>(of_universe.age_ns) * 1e-9);
  }
  if (changes.changed_ns[slot] != 0) {
    tip.ages += tip.ages.empty() ? "" : ", ";
    tip.ages += trf("changed {:.1f} s ago", static_cast<double>(now_ns - changes.changed_ns[slot]) * 1e-9);
  }
  return tip;
}

}  // namespace footlight::tools
