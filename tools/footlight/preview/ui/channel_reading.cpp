#include "tools/footlight/preview/ui/channel_reading.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fixtures/compile/stretches.h"
#include "fixtures/model/attributes.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

using fixtures::ChannelFunction;
using fixtures::ChannelSet;
using fixtures::PhysicalUnit;

// About three digits, as people say them.
std::string with_unit(double value, PhysicalUnit unit) {
  if (!std::isfinite(value)) return "?";
  switch (unit) {
    case PhysicalUnit::kShare: return fmt::format("{:.1f} %", 100 * value);
    case PhysicalUnit::kAngle: return fmt::format("{:.1f}\u00b0", value);
    case PhysicalUnit::kAngularSpeed: return fmt::format("{:.1f}\u00b0/s", value);
    case PhysicalUnit::kFrequency: return fmt::format("{:.2f} Hz", value);
    case PhysicalUnit::kTemperature: return fmt::format("{:.0f} K", value);
    case PhysicalUnit::kTime: return fmt::format("{:.2f} s", value);
    case PhysicalUnit::kLength: return fmt::format("{:.2f} m", value);
    case PhysicalUnit::kNone: break;
  }
  return fmt::format("{:.4g}", value);
}

}  // namespace

ChannelReading reading_of(const fixtures::FixtureType& type, const fixtures::Channel& channel, std::uint32_t raw,
                          const std::function<std::uint32_t(int)>& raw_of) {
  ChannelReading reading;
  for (const ChannelFunction& function : channel.functions) {
    if (raw < function.dmx_from || raw > function.dmx_to) continue;
    const bool active = std::all_of(function.masters.begin(), function.masters.end(), [&](const auto& master) {
      const std::uint32_t other = raw_of(master.channel);
      return other >= master.dmx_from && other <= master.dmx_to;
    });
    if (!active) continue;
    reading.function = &function;
    for (const fixtures::FunctionWay& part : fixtures::ways_of(type, function)) {
      if (raw >= part.first && raw <= part.last) reading.value = part.way.at(raw);
    }
    for (const ChannelSet& set : function.sets) {
      if (raw < set.dmx_from || raw > set.dmx_to) continue;
      reading.set = &set;
      if (set.wheel_slot > 0) reading.value = set.wheel_slot;
    }
    break;
  }
  return reading;
}

std::string text_of(const ChannelReading& reading) {
  if (reading.function == nullptr) return tr("no function");
  const fixtures::AttributeInfo info = fixtures::attribute_info(reading.function->attribute);
  const std::string& set = reading.set != nullptr ? reading.set->name : reading.function->name;
  if (reading.set != nullptr && reading.set->wheel_slot > 0) {
    return set.empty() ? trf("slot {}", reading.set->wheel_slot) : fmt::format("{}: {}", reading.set->wheel_slot, set);
  }
  // "NoFeature" and attributes without a unit: their names say more than a number.
  if (info.unit == PhysicalUnit::kNone) {
    if (!set.empty()) return set;
    if (info.name == "NoFeature") return tr("nothing");
  }
  std::string text = with_unit(reading.value, info.unit);
  if (reading.set != nullptr && !reading.set->name.empty()) text += "  " + reading.set->name;
  return text;
}

std::string name_of(const fixtures::Channel& channel) {
  if (!channel.name.empty()) return channel.name;
  return channel.functions.empty() ? tr("no function") : channel.functions.front().attribute;
}

}  // namespace footlight::tools
