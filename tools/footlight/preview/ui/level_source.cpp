#include "tools/footlight/preview/ui/level_source.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/footlight/monitor/slot_changes.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

namespace {

// The senders that win a universe, or have set one slot of it, and their rate.
void add_senders(const UiInput& input, Universe universe, std::optional<std::size_t> slot, LevelSource& source) {
  if (input.status == nullptr) return;
  std::string brief;
  std::string words;
  for (const UniverseStatus& one : input.status->universes) {
    if (one.universe != universe || one.senders.empty()) continue;
    std::size_t losers = 0;
    std::size_t others = 0;  // that set other slots
    const bool by_slot = slot && *slot < one.slot_senders.size();
    for (std::size_t k = 0; k < one.senders.size(); ++k) {
      const SenderStatus& sender = one.senders[k];
      if (!sender.wins) {
        ++losers;
        continue;
      }
      if (by_slot && (one.slot_senders[*slot] >> k & 1u) == 0) {
        ++others;
        continue;
      }
      brief += (brief.empty() ? "" : " + ") + sender.name;
      words += (words.empty() ? "" : " + ") + trf("{} (priority {})", sender.name, sender.priority);
    }
    if (words.empty()) brief = words = tr("no sender");
    if (losers > 0) words += trf(", {} outranked", losers);
    if (others > 0) words += trf_n(", {} sets other slots", ", {} set other slots", others, others);
    words += fmt::format("  {:.0f} /s", one.rate_hz);
  }
  if (words.empty()) return;
  source.brief = brief;
  source.words = words;
}

}  // namespace

LevelSource source_of_universe(const UiDesk& desk, const UiInput& input, std::size_t universe,
                               std::optional<std::size_t> slot) {
  const auto& universes = desk.compiled().universes;
  if (universe >= input.stamps.size()) {
    LevelSource source{SourceKind::kFaders, tr("faders"), tr("faders of the window")};
    if (input.transport != nullptr) {
      source = {SourceKind::kLog, tr("log"), tr("the log")};
    } else if (input.status != nullptr) {
      source = {SourceKind::kLive, tr("input"), tr("levels as the fixtures get them")};
    }
    if (universe < universes.size()) add_senders(input, universes[universe], slot, source);  // with what is set by hand
    return source;
  }
  const FrameStamp& stamp = input.stamps[universe];
  if (stamp.revision == 0) return {SourceKind::kNobody, tr("no frames"), tr("no frames yet")};
  LevelSource source{SourceKind::kLive};
  source.age_ns = std::max<DurationNs>(input.now_ns - stamp.stamp_ns, 0);
  add_senders(input, universes[universe], slot, source);
  source.rarely = source.words.starts_with("by hand (") || source.words.starts_with("blackout (");
  if (source.words.empty() && input.status != nullptr) source.brief = source.words = tr("no sender");
  source.silent = source.age_ns >= kSilentNs && !source.rarely;
  return source;
}

bool is_silent(const PortStatus& port, const PumpStatus& status) {
  // What is set by hand is sent when it changes.
  if (port.is_sink || port.state != PortState::kWorking || port.name.starts_with("by hand")) return false;
  TimeNs newest_ns = 0;
  for (const PortUniverseStatus& one : port.universes) {
    if (one.rate_hz > 0) return false;
    for (const UniverseStatus& universe : status.universes) {
      if (one.frames > 0 && universe.universe == one.universe)
        newest_ns = std::max(newest_ns, universe.newest.stamp_ns);
    }
  }
  return newest_ns > 0 && status.stamp_ns - newest_ns >= kSilentNs;
}

LevelSource source_of_channel(UiDesk& desk, const UiInput& input, ChannelKey key) {
  const auto place = desk.index().place(key);
  if (!place) return {SourceKind::kMadeUp, tr("default"), tr("it has no address: the default of its file")};
  switch (desk.writes(key)) {
    case UiDesk::Writes::kTaken: return {SourceKind::kTaken, tr("you"), tr("taken over in this window")};
    case UiDesk::Writes::kHighlight: return {SourceKind::kHighlight, tr("highlight"), tr("Highlight of this window")};
    case UiDesk::Writes::kLocate: return {SourceKind::kHighlight, tr("locate"), tr("Locate of this window")};
    case UiDesk::Writes::kNothing: break;
  }
  const auto& universes = desk.compiled().universes;
  const auto at = std::lower_bound(universes.begin(), universes.end(), place->universe);
  return source_of_universe(desk, input, static_cast<std::size_t>(at - universes.begin()),
                            static_cast<std::size_t>(place->address - 1));
}

}  // namespace footlight::tools
