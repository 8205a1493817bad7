#include "tools/footlight/preview/ui/ui_desk.h"

#include <algorithm>
#include <numeric>

#include "fixtures/model/names.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "tools/footlight/preview/ui/channel_reading.h"

namespace footlight::tools {
namespace {

// Highlight shows where a fixture points, so it leaves that alone.
bool points(const fixtures::Channel& channel) {
  return std::any_of(channel.functions.begin(), channel.functions.end(), [](const fixtures::ChannelFunction& function) {
    return fixtures::same_attribute(function.attribute, "Pan") || fixtures::same_attribute(function.attribute, "Tilt");
  });
}

// Machines that fill the room are not lit.
bool blows(const fixtures::Channel& channel) {
  return std::any_of(channel.functions.begin(), channel.functions.end(), [](const fixtures::ChannelFunction& function) {
    return function.attribute.starts_with("Fog") || function.attribute.starts_with("Haze") ||
           function.attribute.starts_with("Fan") || function.attribute.starts_with("Blower");
  });
}

}  // namespace

const RigIndex& UiDesk::index() {
  if (!index_) index_ = std::make_unique<RigIndex>(rig_, compiled_);
  return *index_;
}

std::string UiDesk::undo() {
  const UiCommand* command = history_.undo(state_);
  return command != nullptr ? text_of(*command, rig_) : "";
}

std::string UiDesk::redo() {
  const UiCommand* command = history_.redo(state_);
  return command != nullptr ? text_of(*command, rig_) : "";
}

void UiDesk::select(int fixture, bool add) {
  Selection next = add ? state_.selection : Selection{};
  if (fixture >= 0) {
    const auto at = std::lower_bound(next.fixtures.begin(), next.fixtures.end(), fixture);
    if (at != next.fixtures.end() && *at == fixture) {
      next.fixtures.erase(at);
      if (next.lead == fixture) next.lead = next.fixtures.empty() ? -1 : next.fixtures.back();
    } else {
      next.fixtures.insert(at, fixture);
      next.lead = fixture;
    }
  }
  select(std::move(next));
}

void UiDesk::select_all() {
  Selection all;
  all.fixtures.resize(rig_.fixtures.size());
  std::iota(all.fixtures.begin(), all.fixtures.end(), 0);
  all.lead = state_.selection.lead >= 0 ? state_.selection.lead : all.fixtures.empty() ? -1 : 0;
  select(std::move(all));
}

void UiDesk::select_named(std::string_view pattern) {
  Selection next;
  for (std::size_t i = 0; i < rig_.fixtures.size(); ++i) {
    if (fixtures::name_matches(pattern, rig_.fixtures[i].name)) next.fixtures.push_back(static_cast<int>(i));
  }
  next.lead = next.fixtures.empty() ? -1 : next.fixtures.front();
  select(std::move(next));
}

std::vector<TakeChannels::Edit> UiDesk::edits_of(ChannelKey key, std::optional<std::uint32_t> raw) {
  std::vector<TakeChannels::Edit> edits;
  const auto& all = rig_.fixtures;
  const fixtures::PatchedFixture& own = all[static_cast<std::size_t>(key.fixture)];
  const auto add = [&](ChannelKey one, std::optional<std::uint32_t> value) {
    if (index().place(one)) edits.push_back({one, value, std::nullopt});
  };
  if (!state_.selection.has(key.fixture)) {
    add(key, raw);
    return edits;
  }
  const fixtures::FixtureType& type = fixtures::type_of(rig_, own);
  const fixtures::Mode& mode = fixtures::mode_of(rig_, own);
  const fixtures::Channel& channel = mode.channels[static_cast<std::size_t>(key.channel)];
  const ChannelReading reading = reading_of(type, channel, raw.value_or(channel.default_value), [&](int other) {
    return mode.channels[static_cast<std::size_t>(other)].default_value;
  });
  // Released: all that is left of an attribute.
  const std::string attribute = reading.function != nullptr ? reading.function->attribute
                                : channel.functions.empty() ? std::string()
                                                            : channel.functions.front().attribute;
  for (const int fixture : state_.selection.fixtures) {
    const fixtures::PatchedFixture& one = all[static_cast<std::size_t>(fixture)];
    if (one.type == own.type && one.mode == own.mode) {
      add({fixture, key.channel}, raw);
      continue;
    }
    if (attribute.empty() || fixtures::same_attribute(attribute, "NoFeature")) continue;
    const fixtures::Mode& its = fixtures::mode_of(rig_, one);
    for (std::size_t c = 0; c < its.channels.size(); ++c) {
      const auto nearest =
          fixtures::nearest_raw(fixtures::type_of(rig_, one), its.channels[c], attribute, reading.value);
      if (nearest) add({fixture, static_cast<int>(c)}, raw ? std::optional(nearest->raw) : std::nullopt);
    }
  }
  return edits;
}

void UiDesk::take(ChannelKey key, std::uint32_t raw) { run(TakeChannels{edits_of(key, raw)}); }

void UiDesk::release(ChannelKey key) { run(TakeChannels{edits_of(key, std::nullopt)}); }

void UiDesk::release_all() {
  TakeChannels command;
  for (const auto& [key, raw] : state_.taken) command.edits.push_back({key, std::nullopt, std::nullopt});
  run(std::move(command));
}

void UiDesk::overlay(std::span<std::uint8_t> levels) {
  const RigIndex& slots = index();
  for (const auto& [key, raw] : state_.taken) slots.write(key, raw, levels);
  if (!highlight_ || state_.selection.fixtures.empty()) return;
  if (!lit_) lit_ = std::make_unique<HandLevels>(rig_, compiled_);
  for (const int fixture : state_.selection.fixtures) {
    for (std::size_t c = 0; c < slots.channel_count(fixture); ++c) {
      const ChannelKey key{fixture, static_cast<int>(c)};
      const fixtures::Channel& channel = slots.channel(key);
      if (points(channel) || blows(channel)) continue;
      slots.write(key, channel.has_highlight ? channel.highlight_value : slots.read(key, lit_->levels()), levels);
    }
  }
}

}  // namespace footlight::tools
