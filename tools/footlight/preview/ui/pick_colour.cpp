#include "tools/footlight/preview/ui/pick_colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "fixtures/compile/compile_type.h"
#include "fixtures/model/attributes.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "tools/footlight/preview/ui/channel_reading.h"

namespace footlight::tools {
namespace {

using Attributes = std::array<std::string_view, 3>;
constexpr Attributes kEmitters{"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"};
constexpr Attributes kScreen{"ColorRGB_Red", "ColorRGB_Green", "ColorRGB_Blue"};
constexpr Attributes kFilters{"ColorSub_C", "ColorSub_M", "ColorSub_Y"};
constexpr Attributes kScreenFilters{"ColorRGB_Cyan", "ColorRGB_Magenta", "ColorRGB_Yellow"};

struct Found {
  int channel = -1;
  const fixtures::ChannelFunction* function = nullptr;
};

Found first_of(const fixtures::Mode& mode, std::string_view attribute) {
  for (std::size_t c = 0; c < mode.channels.size(); ++c) {
    if (mode.channels[c].slot_offsets.empty()) continue;  // virtual
    for (const auto& function : mode.channels[c].functions) {
      if (fixtures::same_attribute(function.attribute, attribute)) return {static_cast<int>(c), &function};
    }
  }
  return {};
}

// How a mode mixes colours.
struct Mixing {
  Attributes attributes{};
  std::array<Found, 3> found;
  bool filters = false;
  glm::dmat3 emitted{1};  // of emitters: their colours, scaled so that white has one of them at full
};

std::optional<Mixing> mixing_of(const fixtures::FixtureType& type, const fixtures::Mode& mode) {
  for (const Attributes& attributes : {kEmitters, kScreen, kFilters, kScreenFilters}) {
    Mixing mixing;
    mixing.attributes = attributes;
    mixing.filters = attributes == kFilters || attributes == kScreenFilters;
    bool stated = true;
    for (std::size_t i = 0; i < 3; ++i) {
      mixing.found.at(i) = first_of(mode, attributes.at(i));
      const auto* function = mixing.found.at(i).function;
      stated = stated && function != nullptr && function->emitter != fixtures::kNoIndex;
    }
    if (std::any_of(mixing.found.begin(), mixing.found.end(), [](const Found& one) { return one.channel < 0; }))
      continue;
    if (mixing.filters || !stated) return mixing;
    glm::dmat3 emitted(1);
    for (int i = 0; i < 3; ++i) {
      emitted[i] = fixtures::emitter_color(type, *mixing.found.at(static_cast<std::size_t>(i)).function);
    }
    const double volume = glm::length(emitted[0]) * glm::length(emitted[1]) * glm::length(emitted[2]);
    if (!(std::abs(glm::determinant(emitted)) > 1e-6 * volume)) return mixing;
    const glm::dvec3 white = glm::inverse(emitted) * glm::dvec3(1);
    const double most = std::max({white.x, white.y, white.z});
    if (std::isfinite(most) && most > 0) mixing.emitted = emitted * most;
    return mixing;
  }
  return std::nullopt;
}

double share_of(const fixtures::ChannelFunction& function, double value) {
  const double range = function.physical_to - function.physical_from;
  const double low = std::min(function.physical_from, function.physical_to);
  return range != 0 ? std::clamp((value - low) / std::abs(range), 0.0, 1.0) : 0;
}

// In all channels with the attribute, so that all heads of a fixture have the colour.
void add(const fixtures::FixtureType& type, const fixtures::Mode& mode, std::string_view attribute, double share,
         std::vector<ChannelRaw>& values) {
  for (std::size_t c = 0; c < mode.channels.size(); ++c) {
    const fixtures::Channel& channel = mode.channels[c];
    if (channel.slot_offsets.empty()) continue;
    const auto function = std::find_if(channel.functions.begin(), channel.functions.end(), [&](const auto& one) {
      return fixtures::same_attribute(one.attribute, attribute);
    });
    if (function == channel.functions.end()) continue;
    const double low = std::min(function->physical_from, function->physical_to);
    const double value = low + share * std::abs(function->physical_to - function->physical_from);
    if (const auto nearest = fixtures::nearest_raw(type, channel, attribute, value)) {
      values.push_back({static_cast<int>(c), nearest->raw});
    }
  }
}

}  // namespace

std::vector<ChannelRaw> channels_of_colour(const fixtures::FixtureType& type, const fixtures::Mode& mode,
                                           const glm::dvec3& rgb) {
  std::vector<ChannelRaw> values;
  const auto mixing = mixing_of(type, mode);
  if (!mixing) return values;
  const glm::dvec3 shares =
      glm::clamp(mixing->filters ? 1.0 - rgb : glm::inverse(mixing->emitted) * rgb, glm::dvec3(0), glm::dvec3(1));
  for (int i = 0; i < 3; ++i) add(type, mode, mixing->attributes.at(static_cast<std::size_t>(i)), shares[i], values);
  if (!mixing->filters) {
    for (const fixtures::Channel& channel : mode.channels) {
      if (channel.functions.empty()) continue;
      const std::string_view attribute = channel.functions.front().attribute;
      const bool other = attribute.starts_with("ColorAdd_") &&
                         std::none_of(mixing->attributes.begin(), mixing->attributes.end(),
                                      [&](std::string_view one) { return fixtures::same_attribute(attribute, one); });
      if (other) add(type, mode, attribute, 0, values);
    }
  }
  std::stable_sort(values.begin(), values.end(),
                   [](const ChannelRaw& a, const ChannelRaw& b) { return a.channel < b.channel; });
  values.erase(std::unique(values.begin(), values.end(),
                           [](const ChannelRaw& a, const ChannelRaw& b) { return a.channel == b.channel; }),
               values.end());
  return values;
}

std::optional<glm::dvec3> colour_of_channels(const fixtures::FixtureType& type, const fixtures::Mode& mode,
                                             const std::function<std::uint32_t(int)>& raw_of) {
  const auto mixing = mixing_of(type, mode);
  if (!mixing) return std::nullopt;
  glm::dvec3 shares(0);
  for (int i = 0; i < 3; ++i) {
    const Found& one = mixing->found.at(static_cast<std::size_t>(i));
    const fixtures::Channel& channel = mode.channels[static_cast<std::size_t>(one.channel)];
    const ChannelReading reading = reading_of(type, channel, raw_of(one.channel), raw_of);
    const bool its =
        reading.function != nullptr && fixtures::same_attribute(reading.function->attribute, one.function->attribute);
    shares[i] = its ? share_of(*reading.function, reading.value) : 0;
  }
  return glm::clamp(mixing->filters ? 1.0 - shares : mixing->emitted * shares, glm::dvec3(0), glm::dvec3(1));
}

double linear_of_screen(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
double screen_of_linear(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

}  // namespace footlight::tools
