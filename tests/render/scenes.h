// Scenes for the tests of the renderer: rigs with levels that are made from a seed, and two functions that draw them.
#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/model/rig.h"
#include "render/frame.h"
#include "render/reference/judge.h"
#include "tests/support/must.h"

namespace footlight::render::testing {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr std::int64_t kMs = 1'000'000;

// A floor of 40 x 40 m, in the words of a rig file.
inline const std::string kFloor =
    "[[box]]\nname = \"Floor\"\nmin = [-20, -20, -1]\nmax = [20, 20, 0]\nalbedo = [0.5, 0.4, 0.3]\n";

// SplitMix64 (Steele, Lea, Flood 2014): the same scenes with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::size_t below(std::size_t bound) { return static_cast<std::size_t>(next() % bound); }
  double between(double from, double to) { return from + (to - from) * static_cast<double>(next() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t state_;
};

struct Scene {
  fixtures::Rig rig;
  fixtures::CompiledRig compiled;
  std::vector<std::uint8_t> levels;  // universes x 512, in the order of compiled.universes
  fixtures::Camera camera;

  // The 512 slots of a fixture's universe.
  std::span<std::uint8_t> slots(std::size_t fixture);
  // Sets a value in the units of fixtures/model/fixture_type.h.
  void set(std::size_t fixture, std::string_view attribute, double value);
  // Compiles the rig and sets every channel to its default.
  void compile();
};

// The demo rig on a stage of boxes: heads at random targets, in colour. with_gobos: the profiles have gobos 1 to 8.
[[nodiscard]] Scene demo_scene(std::uint64_t seed, bool with_gobos);
// One fixture of each mode of each built-in type.
[[nodiscard]] Scene all_modes_scene();
// One fixture of each kind of lamp and supply and of each dimmer law, with 16-bit dimmers and lamp control, and heads
// with smoothing, with a belt and with a speed channel.
[[nodiscard]] Scene time_scene();
// `count` fixed lamps over a stage without boxes, all lit in colour. Their channels are dimmer, red, green, blue and
// zoom. Some are narrow beams of 0.1 degrees, some cylinders, some washes of 60 degrees.
[[nodiscard]] Scene lamps_scene(std::uint64_t seed, int count);
// 200 of these, above a floor with eight boxes; not compiled.
[[nodiscard]] Scene lamps_above_boxes(Random& random);
inline constexpr int kLampDimmerSlot = 0;  // offset of the dimmer's slot from a lamp's address; 0 is dark
// One lamp 3 m up that shines along +Y at a wall, 8 m away, with everything that shapes a beam: Gobo1WheelIndex (open,
// dots, bars, star), Gobo1Pos, Iris, Frost1, Prism1 (open, three facets), Blade1A to Blade4Rot, Focus1 if with_focus,
// AnimationWheel1 (0 or 1) and its Pos. Every channel has 16 bits. stacked: the facets of its prism have three colours
// and are turned by 0, 72 and 144 degrees, and there are Prism1Pos, Prism2 (open, two facets: one mirrored, one turned
// and larger), Prism2Pos and Frost2.
[[nodiscard]] Scene optics_scene(bool with_focus, bool stacked = false);
// `count` lamps of optics_scene(false), 1 m apart, with a second gobo wheel: Gobo2WheelIndex (open, dots, bars, star)
// and Gobo2Pos.
[[nodiscard]] Scene gates_scene(int count);
// A generated IES file: a lamp of 0 to 90 degrees in steps of 5, and of 12 planes. It is brightest in a spot of about
// `width_deg`, `away_deg` from its axis towards its top, with a twentieth of that everywhere else.
[[nodiscard]] std::string flood_ies(double away_deg, double width_deg);
// Two lamps with that file in front of a wall, 4 m away, and a floor. The second is turned about its axis and has a
// zoom, 0 to 60 degrees.
[[nodiscard]] Scene measured_scene(double away_deg, double width_deg, double zoom_deg);
// A lamp with rectangular beams 3 m up in front of a wall, 8 m away: `beam_deg` wide, `aspect` times as wide as high.
// It has everything that the lamp of optics_scene() has, except focus.
[[nodiscard]] Scene rectangle_scene(double aspect, double beam_deg, int profile_power);
// Sets the dimmer of every lamp.
void dim_lamps(Scene& scene, const std::vector<bool>& lit);

// The built-in images of a scene, in the order of its layers.
[[nodiscard]] GoboTransmission gobos_of_judge(const Scene& scene);

// 64 x 36, every beam pixel by pixel, without bodies, widening of thin beams, smooth edges and the threshold for dark
// beams: what the judge computes.
[[nodiscard]] FrameSettings judged_settings(int width = 64, int height = 36);

using footlight::testing::must;

[[nodiscard]] std::unique_ptr<Frame> make_frame(vk::Device& device, const Scene& scene, const FrameSettings& settings);
// Draws the scene's levels after a step of 0 s.
[[nodiscard]] RadianceImage draw(Frame& frame, const Scene& scene);
[[nodiscard]] RadianceImage draw_new(vk::Device& device, const Scene& scene, const FrameSettings& settings);

}  // namespace footlight::render::testing
