#include "tools/footlight/preview/ui/level_source.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/footlight/monitor/slot_changes.h"

namespace footlight::tools {

LevelSource source_of_universe(const UiDesk& desk, const UiInput& input, std::size_t universe) {
  if (universe >= input.stamps.size()) {
    if (input.transport != nullptr) return {SourceKind::kLog, "log", "the log"};
    if (input.status != nullptr) return {SourceKind::kLive, "input", "levels as the fixtures get them"};
    return {SourceKind::kFaders, "faders", "faders of the window"};
  }
  const FrameStamp& stamp = input.stamps[universe];
  if (stamp.revision == 0) return {SourceKind::kNobody, "no frames", "no frames yet"};
  LevelSource source{SourceKind::kLive};
  source.age_ns = std::max<DurationNs>(input.now_ns - stamp.stamp_ns, 0);
  source.silent = source.age_ns >= kSilentNs;
  if (input.status == nullptr) return source;
  for (const UniverseStatus& one : input.status->universes) {
    if (one.universe != desk.compiled().universes[universe]) continue;
    std::size_t losers = 0;
    for (const SenderStatus& sender : one.senders) {
      if (!sender.wins) {
        ++losers;
        continue;
      }
      source.brief += (source.brief.empty() ? "" : " + ") + sender.name;
      source.words +=
          fmt::format("{}{} (priority {})", source.words.empty() ? "" : " + ", sender.name, sender.priority);
    }
    if (losers > 0) source.words += fmt::format(", {} outranked", losers);
    source.words += fmt::format("  {:.0f} /s", one.rate_hz);
  }
  return source;
}

LevelSource source_of_channel(UiDesk& desk, const UiInput& input, ChannelKey key) {
  const auto place = desk.index().place(key);
  if (!place) return {SourceKind::kMadeUp, "default", "it has no address: the default of its file"};
  switch (desk.writes(key)) {
    case UiDesk::Writes::kTaken: return {SourceKind::kTaken, "you", "taken over in this window"};
    case UiDesk::Writes::kHighlight: return {SourceKind::kHighlight, "highlight", "Highlight of this window"};
    case UiDesk::Writes::kLocate: return {SourceKind::kHighlight, "locate", "Locate of this window"};
    case UiDesk::Writes::kNothing: break;
  }
  const auto& universes = desk.compiled().universes;
  const auto at = std::lower_bound(universes.begin(), universes.end(), place->universe);
  return source_of_universe(desk, input, static_cast<std::size_t>(at - universes.begin()));
}

}  // namespace footlight::tools
