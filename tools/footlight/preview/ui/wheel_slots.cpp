#include "tools/footlight/preview/ui/wheel_slots.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "fixtures/gobos/gobo_images.h"
#include "fixtures/model/color.h"
#include "fixtures/model/srgb.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr double kDaylightK = 6000;    // of the light that measured filters are shown in
constexpr double kWhiteShare = 0.02;   // colours nearer to white than this have no chip
constexpr double kPictureEdge = 0.05;  // of built-in gobos: a texel and a half

WheelChoice::Slot looks_of(const fixtures::FixtureType& type, const fixtures::WheelSlot& slot) {
  WheelChoice::Slot look;
  glm::dvec3 rgb(1);
  const auto filter = static_cast<std::size_t>(slot.filter);
  if (!slot.open && slot.filter != fixtures::kNoIndex && filter < type.filters.size()) {
    rgb = fixtures::filter_rgb(type.filters[filter], kDaylightK);
  } else if (!slot.open) {
    rgb = fixtures::filter_rgb(slot.color);
  }
  const double most = std::max({rgb.x, rgb.y, rgb.z});
  const double least = std::min({rgb.x, rgb.y, rgb.z});
  look.coloured = most - least > kWhiteShare;
  for (int i = 0; i < 3; ++i) {  // as bright as it can be: a dark blue is still to be told apart
    look.screen_rgb[i] = fixtures::srgb_of_linear(std::clamp(most > 0 ? rgb[i] / most : 0.0, 0.0, 1.0));
  }
  look.facets = slot.facets.size();
  if (!slot.image.empty()) look.image = fixtures::ImageSource{type.files, slot.image, slot.image_clear};
  look.open = slot.open || (!look.coloured && look.facets == 0 && !look.image && !slot.is_animation);
  return look;
}

// The slots that a function selects by its ranges, or as a whole.
std::vector<WheelChoice::Slot> slots_of_function(const fixtures::FixtureType& type,
                                                 const fixtures::ChannelFunction& function) {
  std::vector<WheelChoice::Slot> slots;
  const auto& wheel = type.wheels[static_cast<std::size_t>(function.wheel)];
  std::set<int> there;
  const auto add = [&](int number, const std::string& name, std::uint32_t from, std::uint32_t to) {
    if (number < 1 || static_cast<std::size_t>(number) > wheel.slots.size() || !there.insert(number).second) return;
    const fixtures::WheelSlot& slot = wheel.slots[static_cast<std::size_t>(number - 1)];
    WheelChoice::Slot one = looks_of(type, slot);
    one.number = number;
    one.name = !name.empty() ? name : !slot.name.empty() ? slot.name : trf("slot {}", number);
    one.raw = from + (to - from) / 2;
    one.raw_from = from;
    one.raw_to = to;
    slots.push_back(std::move(one));
  };
  for (const fixtures::ChannelSet& set : function.sets) {
    if (set.dmx_to >= set.dmx_from) add(set.wheel_slot, set.name, set.dmx_from, set.dmx_to);
  }
  return slots;
}

}  // namespace

std::vector<WheelChoice> wheel_choices(const fixtures::FixtureType& type, const fixtures::Mode& mode) {
  std::vector<WheelChoice> choices;
  for (std::size_t c = 0; c < mode.channels.size(); ++c) {
    const fixtures::Channel& channel = mode.channels[c];
    const std::size_t first = choices.size();
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (function.wheel < 0 || static_cast<std::size_t>(function.wheel) >= type.wheels.size()) continue;
      std::vector<WheelChoice::Slot> slots = slots_of_function(type, function);
      if (slots.empty()) continue;
      // Functions of one slot each are one choice.
      const bool joins = choices.size() > first && slots.size() == 1 &&
                         std::none_of(choices.back().slots.begin(), choices.back().slots.end(),
                                      [&](const auto& slot) { return slot.number == slots[0].number; });
      if (joins) {
        choices.back().slots.push_back(std::move(slots[0]));
        continue;
      }
      const std::string name = choices.size() > first && !function.name.empty()
                                   ? fmt::format("{}: {}", name_of(channel), function.name)
                                   : name_of(channel);
      choices.push_back({static_cast<int>(c), name, std::move(slots)});
    }
  }
  return choices;
}

Result<ShelfPicture> gobo_picture(const fixtures::ImageSource& image) {
  FL_ASSIGN(const std::vector<float> texels, fixtures::gobo_texels(image, kShelfPicturePx, kPictureEdge));
  ShelfPicture picture;
  picture.rgba.reserve(std::size_t{4} * kShelfPicturePx * kShelfPicturePx);
  for (int row = 0; row < kShelfPicturePx; ++row) {
    for (int column = 0; column < kShelfPicturePx; ++column) {
      const double x = 2 * (column + 0.5) / kShelfPicturePx - 1;
      const double y = 2 * (row + 0.5) / kShelfPicturePx - 1;
      const bool inside = x * x + y * y <= 1;
      const auto at = static_cast<std::size_t>(3 * (row * kShelfPicturePx + column));
      for (std::size_t c = 0; c < 3; ++c) {
        const float light = std::clamp(texels[at + c], 0.0f, 1.0f);
        picture.rgba.push_back(inside ? static_cast<std::uint8_t>(std::lround(255 * fixtures::srgb_of_linear(light)))
                                      : std::uint8_t{0});
      }
      picture.rgba.push_back(inside ? std::uint8_t{255} : std::uint8_t{0});
    }
  }
  return picture;
}

}  // namespace footlight::tools
