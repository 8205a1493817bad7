#include "tools/demo_show/demo_show.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "fixtures/simulate/encode.h"
#include "sim/core/check.h"

namespace footlight::demo {
namespace {

using fixtures::PatchedFixture;
using fixtures::Rig;
using glm::dvec3;

constexpr double kPi = std::numbers::pi;
constexpr double kBeatS = 0.5;  // 120 beats a minute; a bar is four beats

const dvec3 kDeepBlue(0.02, 0.08, 1.0);
const dvec3 kIce(0.45, 0.80, 1.0);
const dvec3 kCyan(0.0, 0.75, 0.95);
const dvec3 kTeal(0.0, 0.80, 0.50);
const dvec3 kMagenta(1.0, 0.04, 0.55);
const dvec3 kLavender(0.55, 0.38, 1.0);
const dvec3 kRed(1.0, 0.03, 0.02);
const dvec3 kAmber(1.0, 0.42, 0.06);
const dvec3 kGold(1.0, 0.62, 0.20);
const dvec3 kWhite(1.0, 0.95, 0.88);

double fraction(double x) { return x - std::floor(x); }
double ramp(double x, double from, double to) {
  const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}
double wave(double turns) { return 0.5 - 0.5 * std::cos(2 * kPi * turns); }  // 0 at whole turns, 1 half way
// 1 on the beat, then falling; `sharp` is the decay per beat, in nepers.
double hit(double beats, double sharp) { return std::exp(-sharp * fraction(beats)); }
dvec3 hue(double turns) {
  const auto channel = [&](double offset) { return std::pow(0.5 + 0.5 * std::cos(2 * kPi * (turns - offset)), 1.5); };
  return {channel(0), channel(1.0 / 3), channel(2.0 / 3)};
}
bool even(double whole) { return std::fmod(std::floor(whole), 2.0) == 0.0; }

// ---- The nine parts of the show. Each returns a cue for a player at t_s seconds into the show. ----------------------

// From dark: blue from the floor, then ice-cold columns from the middle outwards.
Cue intro(const Player& p, double t) {
  Cue c;
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = 0.8 * ramp(t, 1.6 + 1.3 * p.pair, 3.6 + 1.3 * p.pair);
      c.color = glm::mix(kIce, kDeepBlue, 0.15 * p.pair);
      c.zoom_deg = 6;
      c.target_m = {p.position_m.x * (1 + 0.25 * ramp(t, 4, 8)), 1.9 - 1.2 * ramp(t, 3, 8), 0};
      break;
    case Group::kFloorWash:
      c.dimmer = 0.85 * ramp(t, 0.2, 4.5);
      c.color = kDeepBlue;
      c.zoom_deg = 13;
      c.target_m = {p.position_m.x * (1.25 - 0.35 * ramp(t, 0, 8)), 2.4, 7};
      break;
    case Group::kTrussWash:
      c.dimmer = 0.35 * ramp(t, 5, 8);
      c.color = kDeepBlue;
      c.zoom_deg = 45;
      c.target_m = {p.position_m.x, -0.6, 0};
      break;
    default: c.color = kDeepBlue; break;
  }
  return c;
}

// The fan opens and closes over four bars while light runs outwards on every beat.
Cue build(const Player& p, double t) {
  Cue c;
  const double open = wave((t - 8) / 8);
  const double beats = t / kBeatS;
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = 0.45 + 0.5 * hit(beats / 2 - 0.125 * p.pair, 2.0);
      c.color = glm::mix(kCyan, kMagenta, 0.25 * p.pair + 0.25 * open);
      c.zoom_deg = 7;
      c.target_m = {p.position_m.x * (1.1 + 1.0 * open), -0.4 - 2.4 * open, 0};
      break;
    case Group::kTrussWash:
      c.dimmer = 0.35 + 0.2 * wave(t / 4 + 0.5 * p.pair);
      c.color = glm::mix(kDeepBlue, kMagenta, wave((t - 8) / 16 + 0.25 * p.pair));
      c.zoom_deg = 40;
      c.target_m = {p.position_m.x * 0.8, -0.8, 0};
      break;
    case Group::kFloorWash:
      c.dimmer = 0.7;
      c.color = kDeepBlue;
      c.zoom_deg = 12;
      c.target_m = {p.position_m.x * (0.9 - 0.7 * open), 1.5 - 2.5 * open, 7};
      break;
    case Group::kFrontPar:
      c.dimmer = 0.3 * ramp(t, 10, 13);
      c.color = kLavender;
      break;
    case Group::kSidePar:
      c.dimmer = 0.35 * ramp(t, 12, 15);
      c.color = kMagenta;
      break;
  }
  return c;
}

// Ballyhoo: every head on its own circle, left and right mirrored, two colours that swap with every bar.
Cue ballyhoo(const Player& p, double t) {
  Cue c;
  const double beats = t / kBeatS;
  const double swap = ramp(fraction(beats / 8), 0.0, 0.06) - ramp(fraction(beats / 8), 0.5, 0.56);
  const double mirror = p.side < 0 ? -1 : 1;
  switch (p.group) {
    case Group::kProfile: {
      const double turn = 2 * kPi * (t / 2.8 + p.pair / 4.0);
      c.dimmer = 0.9;
      c.color = glm::mix(kCyan, kMagenta, p.index % 2 == 0 ? swap : 1 - swap);
      c.zoom_deg = 6;
      c.target_m = {p.position_m.x * 1.1 + mirror * 2.3 * std::cos(turn), -2.0 + 2.1 * std::sin(turn), 0};
      break;
    }
    case Group::kTrussWash:
      c.dimmer = 0.35 + 0.35 * hit(beats, 2.5);
      c.color = kDeepBlue;
      c.zoom_deg = 14 + 30 * (1 - hit(beats / 2, 3.0));
      c.target_m = {p.position_m.x * 0.9, -1.0, 0};
      break;
    case Group::kFloorWash: {
      const double turn = 2 * kPi * (t / 4 + 0.25 * p.pair);
      c.dimmer = 0.85;
      c.color = glm::mix(kMagenta, kCyan, swap);
      c.zoom_deg = 10;
      c.target_m = {p.position_m.x * 0.6 + mirror * 1.8 * std::cos(turn), 0.4 + 1.2 * std::sin(turn), 7};
      break;
    }
    case Group::kFrontPar:
      c.dimmer = static_cast<int>(std::floor(beats)) % 4 == p.index ? 0.65 * hit(beats, 1.5) : 0.1;
      c.color = kLavender;
      break;
    case Group::kSidePar:
      c.dimmer = even(beats / 2) == (p.side < 0) ? 0.6 : 0.15;
      c.color = kCyan;
      break;
  }
  return c;
}

// Breakdown: slow gobos on the floor, amber against teal.
Cue gobos(const Player& p, double t) {
  Cue c;
  const int choice = std::clamp(static_cast<int>((t - 24) / 2), 0, 2);
  constexpr std::array<int, 3> kChoice = {4, 6, 1};  // foliage, spiral, dots
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = p.index % 2 == 0 ? 0.95 : 0.75;
      c.color = p.index % 2 == 0 ? kAmber : kTeal;
      c.zoom_deg = 24 + 4 * wave((t - 24) / 6);
      c.gobo = kChoice[static_cast<std::size_t>(choice)];
      c.gobo_spin_hz = p.side < 0 ? 0.12 : -0.12;
      c.target_m = {p.position_m.x * 0.85, -0.9 - 0.8 * wave((t - 24) / 6), 0};
      break;
    case Group::kTrussWash:
      c.dimmer = 0;
      c.target_m = {0, -0.6, 0};
      c.color = kTeal;
      break;
    case Group::kFloorWash:
      c.dimmer = 0.45;
      c.color = kTeal;
      c.zoom_deg = 20;
      c.target_m = {p.position_m.x * 1.1, 4.2, 5};  // along the back wall
      break;
    case Group::kFrontPar:
      c.dimmer = 0.12;
      c.color = kAmber;
      break;
    case Group::kSidePar:
      c.dimmer = 0.5;
      c.color = kAmber;
      break;
  }
  return c;
}

// Rise: all beams meet over the console, the chase doubles its speed every second and a half, and its end strobes.
Cue rise(const Player& p, double t) {
  Cue c;
  const double since = t - 30;
  const double doubling = 1.5;
  // Steps run so far, with a rate of 2^(since / doubling) times one step a beat.
  const double steps = (std::exp2(since / doubling) - 1) * doubling / std::numbers::ln2 / kBeatS;
  const double full = ramp(since, 3.0, 4.5);
  const double strobe = since > 4.7 ? 6 + 6 * ramp(since, 4.7, 6.0) : 0;
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = std::max(full, static_cast<int>(std::floor(steps)) % 4 == p.pair ? 1.0 : 0.08);
      c.color = glm::mix(kDeepBlue, kWhite, ramp(since, 0.5, 5.0));
      c.zoom_deg = 5;
      c.target_m = {0, 0.4 - 0.6 * ramp(since, 0, 6), 2.0 + 1.0 * ramp(since, 0, 6)};
      break;
    case Group::kTrussWash:
      c.dimmer = 0.2 + 0.6 * ramp(since, 0, 6);
      c.color = kRed;
      c.zoom_deg = 50 - 35 * ramp(since, 0, 6);
      c.target_m = {p.position_m.x * 0.6, -0.8, 0};
      break;
    case Group::kFloorWash:
      c.dimmer = 0.15 + 0.75 * ramp(since, 2, 6);
      c.color = glm::mix(kRed, kWhite, ramp(since, 3, 6));
      c.zoom_deg = 11;
      c.target_m = {p.position_m.x * (1.0 - 0.9 * ramp(since, 0, 6)), 0.5, 7};
      c.strobe_hz = strobe;
      break;
    default:
      c.dimmer = 0.1 + 0.5 * ramp(since, 3, 6);
      c.color = kRed;
      c.strobe_hz = strobe;
      break;
  }
  return c;
}

// Drop: alternates between two positions, hard light on the beat, red against blue. `lit` is 0 in the blackout before
// it, in which the heads already move to their first position.
Cue drop(const Player& p, double t, bool lit) {
  Cue c;
  const double beats = (t - 37) / kBeatS;
  const bool cross = !lit || even(beats / 4);
  const bool first = !lit || even(beats / 2);
  const bool left = p.side < 0;
  const bool hits = lit && ((t >= 40.5 && t < 41.0) || (t >= 44.5 && t < 45.0));
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = 0.35 + 0.65 * hit(beats, 1.6);
      c.color = left == first ? kRed : kDeepBlue;
      c.zoom_deg = 5.5;
      c.target_m = cross ? dvec3(-p.position_m.x * 1.2, -2.2, 0.6) : dvec3(p.position_m.x * 2.2, -3.2, 1.6);
      break;
    case Group::kTrussWash:
      c.dimmer = hits ? 1.0 : 0.7 * hit(beats / 2 + 0.5 * (p.pair % 2), 1.8);
      c.color = hits ? kWhite : (left == first ? kDeepBlue : kRed);
      c.zoom_deg = 16;
      c.target_m = {p.position_m.x * (cross ? 0.3 : 1.2), -1.6, 0};
      c.strobe_hz = hits ? 12 : 0;
      break;
    case Group::kFloorWash:
      c.dimmer = hits ? 1.0 : 0.9 * hit(beats + 0.5, 2.5);
      c.color = hits ? kWhite : kIce;
      c.zoom_deg = 9;
      c.target_m = {p.position_m.x * (cross ? 1.6 : 0.2), 0.0, 7};
      c.strobe_hz = hits ? 12 : 0;
      break;
    case Group::kFrontPar:
      c.dimmer = 0.35 * hit(beats / 2, 1.5);
      c.color = kLavender;
      break;
    case Group::kSidePar:
      c.dimmer = left == first ? 0.75 * hit(beats, 1.0) : 0.1;
      c.color = left ? kRed : kDeepBlue;
      break;
  }
  if (!lit) {
    c.dimmer = 0;
    c.strobe_hz = 0;
  }
  return c;
}

// A rainbow runs across while the fan moves out over the audience.
Cue sweep(const Player& p, double t) {
  Cue c;
  const double since = t - 47;
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = 0.9;
      c.color = hue(since * 0.14 + 0.22 * p.side);
      c.zoom_deg = 7;
      c.target_m = {p.position_m.x * 2.0, -9.0, 6.6 + 2.0 * std::sin(2 * kPi * (since / 3.5 + 0.35 * p.side))};
      break;
    case Group::kTrussWash:
      c.dimmer = 0.5;
      c.color = hue(since * 0.14 + 0.5 + 0.22 * p.side);
      c.zoom_deg = 32;
      c.target_m = {p.position_m.x * 0.9, -1.2, 0};
      break;
    case Group::kFloorWash:
      c.dimmer = 0.8;
      c.color = hue(since * 0.14 + 0.33 + 0.22 * p.side);
      c.zoom_deg = 11;
      c.target_m = {p.position_m.x + 2.2 * std::sin(2 * kPi * (since / 3.5 + 0.25 * p.index)), 1.2, 7};
      break;
    default:
      c.dimmer = 0.35;
      c.color = hue(since * 0.14 + 0.66 + 0.22 * p.side);
      break;
  }
  return c;
}

// Finale: gold, a spinning cone in the air, then everything opens upwards; eight tenths of a second of strobe.
Cue finale(const Player& p, double t) {
  Cue c;
  const double since = t - 54;
  const double open = ramp(since, 0.6, 3.2);
  const double strobe = since >= 3.0 && since < 3.8 ? 10 : 0;
  switch (p.group) {
    case Group::kProfile:
      c.dimmer = 1;
      c.color = glm::mix(kGold, kWhite, ramp(since, 1, 3));
      c.zoom_deg = 14 - 8 * open;
      c.gobo = since < 1.8 ? 8 : 0;
      c.gobo_spin_hz = p.side < 0 ? 0.5 : -0.5;
      c.target_m = glm::mix(dvec3(p.position_m.x * 0.3, -1.5, 1.0), dvec3(p.position_m.x * 2.4, -8.0, 8.5), open);
      break;
    case Group::kTrussWash:
      c.dimmer = 0.75;
      c.color = kAmber;
      c.zoom_deg = 30;
      c.target_m = {p.position_m.x * 0.9, -1.0, 0};
      break;
    case Group::kFloorWash:
      c.dimmer = 1;
      c.color = kGold;
      c.zoom_deg = 9 + 5 * open;
      c.target_m = {p.position_m.x * (0.3 + 1.3 * open), 0.5, 7};
      c.strobe_hz = strobe;
      break;
    default:
      c.dimmer = 0.5;
      c.color = kGold;
      c.strobe_hz = strobe;
      break;
  }
  return c;
}

// Afterglow: the innermost columns in blue, fading out.
Cue afterglow(const Player& p, double t) {
  Cue c;
  const double left = 1 - ramp(t, 58.0, 59.7);
  c.color = kDeepBlue;
  c.target_m = {p.position_m.x, 1.9, 0};
  c.zoom_deg = 6;
  if (p.group == Group::kProfile && p.pair == 0) {
    c.dimmer = 0.9 * left;
    c.color = kIce;
  }
  if (p.group == Group::kFloorWash) {
    c.dimmer = 0.8 * left;
    c.zoom_deg = 13;
    c.target_m = {p.position_m.x * 1.25, 2.4, 7};
  }
  return c;
}

struct Part {
  double from_s;
  double fade_s;  // crossfade from the part before it
  Cue (*cue)(const Player&, double);
};
const std::array<Part, 10> kParts = {{
    {0, 0, intro},
    {8, 0.6, build},
    {16, 0.3, ballyhoo},
    {24, 0.8, gobos},
    {30, 0.5, rise},
    {36, 0, [](const Player& p, double t) { return drop(p, t, false); }},
    {37, 0, [](const Player& p, double t) { return drop(p, t, true); }},
    {47, 0.5, sweep},
    {54, 0.3, finale},
    {58, 0, afterglow},
}};

Group group_of(const Rig& rig, const PatchedFixture& fixture) {
  switch (rig.types[static_cast<std::size_t>(fixture.type)].body) {
    case fixtures::BodyModel::kMovingHead: return Group::kProfile;
    case fixtures::BodyModel::kWash: return fixture.position_m.z < 1 ? Group::kFloorWash : Group::kTrussWash;
    case fixtures::BodyModel::kNone: break;
    case fixtures::BodyModel::kPar: return std::abs(fixture.position_m.x) > 5.5 ? Group::kSidePar : Group::kFrontPar;
  }
  return Group::kProfile;
}

dvec3 turn_about(int axis, double angle, dvec3 v) {
  const int u = (axis + 1) % 3;
  const int w = (axis + 2) % 3;
  dvec3 out = v;
  out[u] = std::cos(angle) * v[u] - std::sin(angle) * v[w];
  out[w] = std::sin(angle) * v[u] + std::cos(angle) * v[w];
  return out;
}

}  // namespace

PanTilt aim(const PatchedFixture& fixture, const dvec3& direction) {
  // To fixture space: the hanging rotation is about X, then Y, then Z.
  const dvec3 angle = fixture.rotation_deg * (kPi / 180);
  const dvec3 d = turn_about(0, -angle.x, turn_about(1, -angle.y, turn_about(2, -angle.z, glm::normalize(direction))));
  // The beam is (-sin pan sin tilt, cos pan sin tilt, -cos tilt).
  const double tilt = std::atan2(std::hypot(d.x, d.y), -d.z);
  return d.y >= 0 ? PanTilt{std::atan2(-d.x, d.y), tilt} : PanTilt{std::atan2(d.x, -d.y), -tilt};
}

DemoShow::DemoShow(const Rig& rig) : rig_(rig) {
  std::set<Universe> universes;
  std::map<Group, std::vector<Player>> groups;
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    universes.insert(rig.fixtures[i].universe);
    Player player;
    player.group = group_of(rig, rig.fixtures[i]);
    player.fixture = static_cast<int>(i);
    player.position_m = rig.fixtures[i].position_m;
    groups[player.group].push_back(player);
  }
  universes_.assign(universes.begin(), universes.end());
  for (auto& [group, players] : groups) {
    std::stable_sort(players.begin(), players.end(),
                     [](const Player& a, const Player& b) { return a.position_m.x < b.position_m.x; });
    const int count = static_cast<int>(players.size());
    for (int i = 0; i < count; ++i) {
      Player& player = players[static_cast<std::size_t>(i)];
      player.index = i;
      player.pair = i < count / 2 ? (count - 1) / 2 - i : i - count / 2;
      player.side = count > 1 ? 2.0 * i / (count - 1) - 1 : 0;
      players_.push_back(player);
    }
  }
}

Cue DemoShow::cue(const Player& player, double t_s) const {
  const double t = t_s - kShowLengthS * std::floor(t_s / kShowLengthS);
  std::size_t at = 0;
  while (at + 1 < kParts.size() && t >= kParts[at + 1].from_s) ++at;
  const Part& part = kParts[at];
  Cue now = part.cue(player, t);
  if (at == 0 || t >= part.from_s + part.fade_s) return now;
  const Cue before = kParts[at - 1].cue(player, t);
  const double share = ramp(t, part.from_s, part.from_s + part.fade_s);
  now.dimmer = glm::mix(before.dimmer, now.dimmer, share);
  now.color = glm::mix(before.color, now.color, share);
  now.target_m = glm::mix(before.target_m, now.target_m, share);
  now.zoom_deg = glm::mix(before.zoom_deg, now.zoom_deg, share);
  return now;
}

void DemoShow::levels_at(double t_s, std::span<Slots> levels) const {
  using namespace footlight::fixtures;
  FL_CHECK_EQ(levels.size(), universes_.size());
  for (Slots& slots : levels) slots.fill(0);
  for (const Player& player : players_) {
    const PatchedFixture& fixture = rig_.fixtures[static_cast<std::size_t>(player.fixture)];
    const auto universe = std::lower_bound(universes_.begin(), universes_.end(), fixture.universe) - universes_.begin();
    const std::span<std::uint8_t> slots = levels[static_cast<std::size_t>(universe)];
    const Cue c = cue(player, t_s);
    encode_defaults(rig_, fixture, slots);
    encode_attribute(rig_, fixture, "Dimmer", c.dimmer, slots);
    if (c.strobe_hz > 0) {
      encode_attribute(rig_, fixture, "Shutter1Strobe", c.strobe_hz, slots);
    } else {
      encode_attribute(rig_, fixture, "Shutter1", 1, slots);
    }
    encode_attribute(rig_, fixture, "ColorAdd_R", c.color.r, slots);
    encode_attribute(rig_, fixture, "ColorAdd_G", c.color.g, slots);
    encode_attribute(rig_, fixture, "ColorAdd_B", c.color.b, slots);
    encode_attribute(rig_, fixture, "Zoom", c.zoom_deg, slots);
    encode_attribute(rig_, fixture, "Gobo1", 1 + c.gobo, slots);  // slot 1 is open
    encode_attribute(rig_, fixture, "Gobo1PosRotate", 360 * c.gobo_spin_hz, slots);
    const dvec3 direction = c.target_m - fixture.position_m;
    if (glm::dot(direction, direction) > 1e-6) {
      const PanTilt angles = aim(fixture, direction);
      encode_attribute(rig_, fixture, "Pan", angles.pan * 180 / kPi, slots);
      encode_attribute(rig_, fixture, "Tilt", angles.tilt * 180 / kPi, slots);
    }
  }
}

}  // namespace footlight::demo
