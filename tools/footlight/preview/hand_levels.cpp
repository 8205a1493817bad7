#include "tools/footlight/preview/hand_levels.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "fixtures/compile/compile_type.h"
#include "fixtures/displays/pixel_slots.h"
#include "fixtures/model/color.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "fixtures/simulate/machines.h"
#include "fixtures/simulate/walker.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

enum class Start {
  kTop,
  kMakesWhite,  // at the top
  kTint,        // at the top if nothing else in the mode makes white, else at 0
  kRest,        // in the middle, or at 0 if the range includes it, or at the wheel slot that passes most light
};

struct Kind {
  const char* attribute;
  const char* name;
  const char* unit;
  Start start;
};

constexpr Kind kKinds[] = {
    {"Dimmer", "dimmer", "%", Start::kTop},
    {"HSB_Brightness", "brightness", "%", Start::kTop},
    {"HSB_Hue", "hue", "°", Start::kRest},
    {"HSB_Saturation", "saturation", "%", Start::kRest},
    {"ColorAdd_R", "red", "%", Start::kMakesWhite},
    {"ColorAdd_G", "green", "%", Start::kMakesWhite},
    {"ColorAdd_B", "blue", "%", Start::kMakesWhite},
    {"ColorRGB_Red", "red", "%", Start::kMakesWhite},
    {"ColorRGB_Green", "green", "%", Start::kMakesWhite},
    {"ColorRGB_Blue", "blue", "%", Start::kMakesWhite},
    {"ColorAdd_W", "white", "%", Start::kMakesWhite},
    {"ColorAdd_WW", "warm white", "%", Start::kMakesWhite},
    {"ColorAdd_CW", "cold white", "%", Start::kMakesWhite},
    {"ColorAdd_RY", "amber", "%", Start::kTint},
    {"ColorAdd_Y", "yellow", "%", Start::kTint},
    {"ColorAdd_GY", "lime", "%", Start::kTint},
    {"ColorAdd_GC", "blue green", "%", Start::kTint},
    {"ColorAdd_C", "cyan", "%", Start::kTint},
    {"ColorAdd_BC", "light blue", "%", Start::kTint},
    {"ColorAdd_BM", "purple", "%", Start::kTint},
    {"ColorAdd_M", "magenta", "%", Start::kTint},
    {"ColorAdd_RM", "pink", "%", Start::kTint},
    {"ColorAdd_UV", "ultraviolet", "%", Start::kTint},
    {"ColorSub_C", "cyan", "%", Start::kRest},
    {"ColorSub_M", "magenta", "%", Start::kRest},
    {"ColorSub_Y", "yellow", "%", Start::kRest},
    {"Color1", "colour", "", Start::kRest},
    {"Color2", "colour 2", "", Start::kRest},
    {"Color3", "colour 3", "", Start::kRest},
    {"Pan", "pan", "°", Start::kRest},
    {"Tilt", "tilt", "°", Start::kRest},
    {"Zoom", "zoom", "°", Start::kRest},
    {"Focus1", "focus", "%", Start::kRest},
    {"Iris", "iris", "%", Start::kTop},
    {"Gobo1", "gobo", "", Start::kRest},
    {"Gobo1Pos", "gobo turn", "°", Start::kRest},
    {"Gobo2", "gobo 2", "", Start::kRest},
    {"AnimationWheel1", "animation", "", Start::kRest},
    {"Prism1", "prism", "", Start::kRest},
    {"Frost1", "frost", "%", Start::kRest},
    {"Blade1A", "blade below", "%", Start::kRest},
    {"Blade2A", "blade left", "%", Start::kRest},
    {"Blade3A", "blade above", "%", Start::kRest},
    {"Blade4A", "blade right", "%", Start::kRest},
    {"Haze1", "haze", "%", Start::kRest},
    {"Fog1", "fog", "%", Start::kRest},
    {"Fan1", "fan", "%", Start::kTop},
    {"Blower1", "blower", "%", Start::kTop},
};

// Rough transmission of a slot, for choosing the clearest one.
double clearness(const fixtures::FixtureType& type, const fixtures::WheelSlot& slot) {
  if (slot.open) return 200;
  const bool filters = slot.filter != fixtures::kNoIndex;
  const double luminance = filters ? type.filters[static_cast<std::size_t>(slot.filter)].color.Y : slot.color.Y;
  return slot.image.empty() && slot.facets.empty() ? luminance : -1;
}

// The joint range of the mode's functions with the attribute (from > to: there is none), and its start value.
Fader reach(const fixtures::FixtureType& type, const fixtures::Mode& mode, const Kind& kind) {
  Fader fader{kind.attribute, kind.name, kind.unit, 1e30, -1e30, 0};
  double clearest = -1e30;
  const auto take = [&](double value) {
    fader.from = std::min(fader.from, value);
    fader.to = std::max(fader.to, value);
  };
  for (const fixtures::Channel& channel : mode.channels) {
    if (channel.slot_offsets.empty()) continue;  // virtual
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (!fixtures::same_attribute(function.attribute, kind.attribute)) continue;
      bool selects = false;
      for (const fixtures::ChannelSet& set : function.sets) {
        if (set.wheel_slot < 1) continue;
        take(set.wheel_slot);
        selects = true;
        const fixtures::Wheel* wheel =
            function.wheel == fixtures::kNoIndex ? nullptr : &type.wheels[static_cast<std::size_t>(function.wheel)];
        const auto index = static_cast<std::size_t>(set.wheel_slot - 1);
        const double its = wheel != nullptr && index < wheel->slots.size() ? clearness(type, wheel->slots[index]) : 0;
        if (its <= clearest) continue;
        clearest = its;
        fader.value = set.wheel_slot;
      }
      if (selects) continue;
      take(function.physical_from);
      take(function.physical_to);
    }
  }
  const bool has_zero = fader.from <= 0 && fader.to >= 0;
  if (kind.start == Start::kTop || kind.start == Start::kMakesWhite) {
    fader.value = fader.to;
  } else if (fader.unit[0] == '\0') {
    fader.value = std::max(fader.value, fader.from);
  } else {
    fader.value = has_zero ? 0 : (fader.from + fader.to) / 2;
  }
  return fader;
}

// Strikes the lamp, if a channel can; some can only douse.
void strike(const fixtures::Rig& rig, const fixtures::PatchedFixture& fixture, std::span<std::uint8_t> slots) {
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (!fixtures::same_attribute(function.attribute, "LampControl") || function.physical_from != 1) continue;
      fixtures::encode_raw(fixture, channel, function.dmx_from + (function.dmx_to - function.dmx_from) / 2, slots);
    }
  }
}

// Opens the shutter, or sets the slowest strobe if no function opens it.
void open_shutter(const fixtures::Rig& rig, const fixtures::PatchedFixture& fixture, std::span<std::uint8_t> slots) {
  bool opens = false;
  double slowest_hz = 1e30;
  const auto examine = [&](const std::string& attribute, double from, double to) {
    if (fixtures::same_attribute(attribute, "Shutter1")) opens = opens || std::max(from, to) >= 1;
    if (fixtures::same_attribute(attribute, "Shutter1Strobe")) slowest_hz = std::min({slowest_hz, from, to});
  };
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    for (const fixtures::ChannelFunction& function : channel.functions)
      examine(function.attribute, function.physical_from, function.physical_to);
  }
  if (opens || slowest_hz > 1e3) {
    fixtures::encode_attribute(rig, fixture, "Shutter1", 1, slots);
  } else {
    fixtures::encode_attribute(rig, fixture, "Shutter1Strobe", slowest_hz, slots);
  }
}

constexpr std::array<std::string_view, 3> kEmitters = {"ColorAdd_R", "ColorAdd_G", "ColorAdd_B"};
constexpr double kTooDense = 5;  // times the target

// Red, green and blue of a mode at full, and the sum of its other emitters.
struct Mix {
  std::array<glm::dvec3, 3> emitters{};
  glm::dvec3 others{0};
  bool stated = false;  // the file states the colours of the three
};

// nullopt if the mode does not mix all three.
std::optional<Mix> mix_of(const fixtures::FixtureType& type, const fixtures::Mode& mode,
                          const std::vector<Fader>& faders) {
  Mix mix;
  mix.stated = true;
  // The first function of an attribute is used for all heads.
  const auto function_of = [&](std::string_view attribute) -> const fixtures::ChannelFunction* {
    for (const fixtures::Channel& channel : mode.channels) {
      for (const fixtures::ChannelFunction& function : channel.functions) {
        if (fixtures::same_attribute(function.attribute, attribute)) return &function;
      }
    }
    return nullptr;
  };
  std::size_t found = 0;
  for (const Fader& fader : faders) {
    if (!fader.attribute.starts_with("ColorAdd_")) continue;
    const fixtures::ChannelFunction* function = function_of(fader.attribute);
    if (function == nullptr) continue;
    const glm::dvec3 light = fixtures::emitter_color(type, *function);
    const auto at = std::find(kEmitters.begin(), kEmitters.end(), fader.attribute);
    if (at == kEmitters.end()) {
      mix.others += light * std::clamp((fader.value - fader.from) / (fader.to - fader.from), 0.0, 1.0);
      continue;
    }
    mix.emitters[static_cast<std::size_t>(at - kEmitters.begin())] = light;
    mix.stated = mix.stated && function->emitter != fixtures::kNoIndex;
    ++found;
  }
  return found == kEmitters.size() ? std::optional(mix) : std::nullopt;
}

// The white of a fixture: its beam's colour temperature if the file has it and the emitters' colours; the white of the
// screen if the beam has no colour temperature; else red, green and blue at full.
glm::dvec3 own_white(const fixtures::FixtureType& type, const fixtures::Mode& mode, const Mix& mix) {
  double temperature_k = 0;
  for (const fixtures::Geometry& geometry : mode.geometries) {
    if (geometry.beam == fixtures::kNoIndex || geometry.kind != fixtures::GeometryKind::kBeam) continue;
    temperature_k = type.beams[static_cast<std::size_t>(geometry.beam)].color_temperature_k;
    break;
  }
  if (!(temperature_k > 0)) return glm::dvec3(1);
  return mix.stated ? fixtures::black_body_rgb(temperature_k) : mix.emitters[0] + mix.emitters[1] + mix.emitters[2];
}

// CIE 1976 u'v', and the weight of a light when it is mixed.
struct Chromaticity {
  glm::dvec2 at{0};
  double weight = 0;
};
Chromaticity chromaticity(const glm::dvec3& rgb) {
  const glm::dvec3 xyz = fixtures::rgb_to_xyz(rgb);
  const double weight = xyz.x + 15 * xyz.y + 3 * xyz.z;
  return {glm::dvec2(4 * xyz.x, 9 * xyz.y) / std::max(weight, 1e-12), weight};
}

// For a white outside the triangle of the three: the nearest point on its edges in u'v'.
glm::dvec3 nearest_on_edges(const Mix& mix, const glm::dvec3& white) {
  const glm::dvec2 wanted = chromaticity(white).at;
  glm::dvec3 best(1);
  double best_distance = 1e300;
  for (int edge = 0; edge < 3; ++edge) {
    const int to = (edge + 1) % 3;
    const Chromaticity a = chromaticity(mix.emitters[static_cast<std::size_t>(edge)]);
    const Chromaticity b = chromaticity(mix.emitters[static_cast<std::size_t>(to)]);
    if (!(a.weight > 0 && b.weight > 0)) continue;
    const glm::dvec2 along = b.at - a.at;
    const double t = std::clamp(glm::dot(wanted - a.at, along) / std::max(glm::dot(along, along), 1e-12), 0.0, 1.0);
    const double distance = glm::length(a.at + t * along - wanted);
    if (distance >= best_distance) continue;
    best_distance = distance;
    glm::dvec3 amounts(0);
    amounts[edge] = (1 - t) / a.weight;
    amounts[to] = t / b.weight;
    best = amounts / std::max(amounts[edge], amounts[to]);
  }
  return best;
}

// Shares of red, green and blue that give this white together with the other emitters; one of them is at full.
glm::dvec3 shares_of(const Mix& mix, const glm::dvec3& white) {
  const glm::dmat3 emitted(mix.emitters[0], mix.emitters[1], mix.emitters[2]);
  const double volume = glm::length(emitted[0]) * glm::length(emitted[1]) * glm::length(emitted[2]);
  if (!(std::abs(glm::determinant(emitted)) > 1e-6 * volume)) return glm::dvec3(1);  // not three colours
  const glm::dmat3 wanted = glm::inverse(emitted);
  const glm::dvec3 rising = wanted * white;
  const glm::dvec3 offset = wanted * mix.others;
  if (!glm::all(glm::greaterThan(rising, glm::dvec3(0)))) {
    return mix.others == glm::dvec3(0) ? nearest_on_edges(mix, white) : glm::dvec3(1);
  }
  const glm::dvec3 reach_t = (glm::dvec3(1) + offset) / rising;
  return glm::clamp(std::min({reach_t.x, reach_t.y, reach_t.z}) * rising - offset, 0.0, 1.0);
}

}  // namespace

void give_hand_addresses(fixtures::Rig& rig) {
  Universe universe = kUniverseMin;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.patched) continue;
    universe = std::max(universe, fixture.universe + 1);
    for (const auto& further : fixture.further_addresses) universe = std::max(universe, further.universe + 1);
  }
  for (const fixtures::PixelSlots& pixels : fixtures::pixel_slots(rig)) {
    universe = std::max(universe, pixels.universe + 1);
  }
  Address next = 1;
  for (fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (fixture.patched) continue;
    const fixtures::Mode& mode = fixtures::mode_of(rig, fixture);
    const int first = fixtures::slot_count_of(mode, 1);
    int all = first;
    for (const auto& [dmx_break, count] : mode.break_slot_counts) all += dmx_break > 1 ? count : 0;
    const int wanted = std::min(std::max(all <= kSlotCountMax ? all : first, 1), kSlotCountMax);
    if (next + wanted - 1 > kSlotCountMax) {
      ++universe;
      next = 1;
    }
    if (universe > kUniverseMax) return;  // more than 32 million slots: the rest gets no address
    fixture.patched = true;
    fixture.universe = universe;
    fixture.address = next;
    fixture.further_addresses.clear();
    if (all <= kSlotCountMax) {
      Address at = next + first;
      for (const auto& [dmx_break, count] : mode.break_slot_counts) {
        if (dmx_break < 2 || count < 1) continue;
        fixture.further_addresses.push_back({dmx_break, universe, at});
        at += count;
      }
    }
    next += wanted;
  }
}

HandLevels::HandLevels(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig), compiled_(compiled), levels_(compiled.universes.size() * kSlotCountMax), faders_(rig.fixtures.size()) {
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const fixtures::PatchedFixture& fixture = rig.fixtures[i];
    if (!fixture.patched) continue;  // no address: it stays at its channels' defaults
    const fixtures::Mode& mode = fixtures::mode_of(rig, fixture);
    const auto slots = slots_of(fixture);
    fixtures::encode_defaults(rig, fixture, slots);
    strike(rig, fixture, slots);  // first, because some share a channel with the shutter
    open_shutter(rig, fixture, slots);
    bool makes_white = false;
    for (const Kind& kind : kKinds) {
      Fader fader = reach(rig.types[static_cast<std::size_t>(fixture.type)], mode, kind);
      if (!(fader.from < fader.to)) continue;
      if (fixtures::concerns_device_only(kind.attribute) && !fixtures::is_of_machine(mode, kind.attribute)) continue;
      makes_white = makes_white || kind.start == Start::kMakesWhite;
      if (kind.start == Start::kTint && !makes_white) fader.value = fader.to;
      faders_[i].push_back(fader);
      set(i, kind.attribute, fader.value);
    }
  }
  balance();
  fill_room();
}

// Red, green and blue at full often add up to violet in manufacturers' files. The mix is solved with the emitters' own
// light, before the conversion to the screen's gamut, which is not linear in the levels.
void HandLevels::balance() {
  for (std::size_t i = 0; i < faders_.size(); ++i) {
    const fixtures::PatchedFixture& fixture = rig_.fixtures[i];
    const fixtures::FixtureType& type = rig_.types[static_cast<std::size_t>(fixture.type)];
    const fixtures::Mode& mode = fixtures::mode_of(rig_, fixture);
    const std::optional<Mix> mix = mix_of(type, mode, faders_[i]);
    if (!mix) continue;
    const glm::dvec3 shares = shares_of(*mix, own_white(type, mode, *mix));
    for (std::size_t e = 0; e < kEmitters.size(); ++e) {
      set_share(i, kEmitters[e], shares[static_cast<glm::length_t>(e)]);
    }
  }
}

// Haze and fog are linear in their machines' levels, so one run at full gives the share.
void HandLevels::fill_room() {
  const auto air = fixtures::MachineAir::make(rig_, compiled_);
  if (!air) return;
  const auto set_all = [&](std::string_view attribute, double share) {
    for (std::size_t i = 0; i < faders_.size(); ++i) set_share(i, attribute, share);
  };
  set_all("Haze1", 1);
  set_all("Fog1", 1);
  air->settle(levels_);
  const double haze = air->haze_per_m();
  const double fog = air->fog_per_m();
  const double target = kHandHazePerM / (haze > 0 && fog > 0 ? 2 : 1);
  set_all("Haze1", haze > 0 ? std::min(target / haze, 1.0) : 0);
  set_all("Fog1", fog > 0 ? std::min(target / fog, 1.0) : 0);
  // Machines that are only on or off would make the haze too dense.
  air->settle(levels_);
  if (air->haze_per_m() > kTooDense * target) set_all("Haze1", 0);
  if (air->fog_per_m() > kTooDense * target) set_all("Fog1", 0);
}

void HandLevels::set_share(std::size_t index, std::string_view attribute, double share) {
  for (const Fader& fader : faders_[index]) {
    if (fader.attribute == attribute) set(index, attribute, fader.from + share * (fader.to - fader.from));
  }
}

std::span<std::uint8_t> HandLevels::slots_of(const fixtures::PatchedFixture& fixture) {
  const auto at = std::lower_bound(compiled_.universes.begin(), compiled_.universes.end(), fixture.universe);
  FL_CHECK(at != compiled_.universes.end() && *at == fixture.universe);
  const auto index = static_cast<std::size_t>(at - compiled_.universes.begin());
  return std::span(levels_).subspan(index * kSlotCountMax, kSlotCountMax);
}

void HandLevels::set(std::size_t index, std::string_view attribute, double value) {
  for (Fader& fader : faders_[index]) {
    if (fader.attribute != attribute) continue;
    fader.value = std::clamp(value, fader.from, fader.to);
    fixtures::encode_attribute(rig_, rig_.fixtures[index], attribute, fader.value, slots_of(rig_.fixtures[index]));
  }
}

bool HandLevels::encode(std::size_t index, std::string_view attribute, double value) {
  const fixtures::PatchedFixture& fixture = rig_.fixtures[index];
  return fixture.patched && fixtures::encode_attribute(rig_, fixture, attribute, value, slots_of(fixture));
}

namespace {

// Of all channels of some fixtures that have an attribute.
struct ValueRange {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};
void add_range(const fixtures::Rig& rig, const fixtures::PatchedFixture& fixture, std::string_view attribute,
               ValueRange& range) {
  for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
    const auto nearest = fixtures::nearest_raw(fixtures::type_of(rig, fixture), channel, attribute, 0);
    if (!nearest) continue;
    range.least = std::min(range.least, nearest->least);
    range.most = std::max(range.most, nearest->most);
  }
}

}  // namespace

Status set_by_hand(const std::string& text, const fixtures::Rig& rig, HandLevels& hand) {
  const std::size_t equals = text.rfind('=');
  const std::size_t colon = equals == std::string::npos ? std::string::npos : text.rfind(':', equals);
  const auto expected = [&](std::string_view what) {
    return fail(ErrorCode::kBadInput, "--set {}: expected {}, for example Iris=0.5 or Spot 1:Iris=0.5", text, what);
  };
  if (equals == std::string::npos) return expected("ATTRIBUTE=NUMBER or FIXTURE:ATTRIBUTE=NUMBER");
  const std::string number = text.substr(equals + 1);
  double value = 0;
  const auto [at, fault] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (number.empty()) return expected("a number behind =, got nothing");
  if (fault != std::errc() || at != number.data() + number.size() || !std::isfinite(value)) {
    return expected(fmt::format("a finite number behind =, got {}", number));
  }
  const std::string name = colon == std::string::npos ? "" : text.substr(0, colon);
  const std::size_t begin = colon == std::string::npos ? 0 : colon + 1;
  const std::string attribute = text.substr(begin, equals - begin);
  if (attribute.empty()) return expected("the name of an attribute before =, got nothing");
  if (colon == 0) return expected("the name of a fixture before the colon, got nothing");
  bool known = name.empty();
  bool any = false;
  ValueRange range;
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    if (!name.empty() && rig.fixtures[i].name != name) continue;
    known = true;
    if (!hand.encode(i, attribute, value)) continue;
    any = true;
    add_range(rig, rig.fixtures[i], attribute, range);
  }
  if (!known) return fail(ErrorCode::kNotFound, "--set {}: there is no fixture '{}'", text, name);
  if (!any) {
    return fail(ErrorCode::kNotFound, "--set {}: no {} has a channel for {}; 'footlight fixtures show' lists them",
                text, name.empty() ? "fixture" : "such fixture", attribute);
  }
  // Ends are shown with six digits, and DMX profiles in files end a little short of their function's.
  const double slack =
      1e-5 * std::max(std::abs(range.least), std::abs(range.most)) + 2e-4 * (range.most - range.least);
  if (value < range.least - slack || value > range.most + slack) {
    return fail(ErrorCode::kBadInput, "--set {}: expected {:.6g} to {:.6g} for {}, got {}", text, range.least,
                range.most, attribute, number);
  }
  return {};
}

}  // namespace footlight::tools
