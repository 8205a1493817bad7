// How VRSL's shaders behave in time, faults included, to replay shows that were built with them. Separate from the
// models in sim/shared, which are exact and share no code with this file.
//
// VRSL keeps one grid of values 0 to 1, one per channel. Each picture it passes the grid through smoothing, strobe and
// spin. The classes here do the same for one universe of a 3-universe grid. `dt_s` is the time of one picture; as in
// VRSL, results depend on it. Values are float, as in VRSL.
//
// Figures: VR Stage Lighting, commit 12dedbe, materials of its horizontal grid (DMXRTShader-...).
#pragma once

#include <array>
#include <cstdint>

namespace footlight {

inline constexpr int kVrslChannels = 512;
inline constexpr int kVrslRow = 13;  // channels of a row of the grid; the last one is the row's speed

using VrslValues = std::array<float, kVrslChannels>;  // 0 to 1, channel 1 first

struct VrslSettings {
  float slowest = 0.32258067f;     // share of a movement's gap left after a second at speed 0
  float fastest = 0.16129033f;     // and at speed 1
  float color_smoothing = 0.7f;    // share of a colour's gap closed in each picture
  float strobe_threshold = 0.2f;   // a strobe channel at or below this is open
  bool static_strobe = true;       // three tiers, as shipped; else a rate that grows with the channel
  float strobe_low_rad_s = 25;     // of channel <= 0.2: never seen, because the threshold opens it
  float strobe_medium_rad_s = 45;  // <= 0.5
  float strobe_high_rad_s = 65;
  float strobe_dynamic_rad_s = 185;  // at channel 1, not static; 100 on the vertical grid
};

// The pass that smooths pan and tilt. The speed is that of column 13 of the same row, whatever is patched there. It
// closes a tenth of the speed, as a share of the gap, in each picture on top of the exponential. So fast moves are
// faster at higher picture rates.
class VrslMovement {
 public:
  explicit VrslMovement(const VrslSettings& settings) : settings_(settings) {}
  // Values pass through unchanged during the first 3 s. Ignored if dt_s is negative or NaN.
  const VrslValues& step(const VrslValues& raw, float dt_s);

 private:
  VrslSettings settings_;
  VrslValues out_{};
  double clock_s_ = 0;
};

// The pass that smooths colour and intensity: per picture, not per second.
class VrslColor {
 public:
  explicit VrslColor(const VrslSettings& settings) : settings_(settings) {}
  const VrslValues& step(const VrslValues& raw, float dt_s);

 private:
  VrslSettings settings_;
  VrslValues out_{};
  double clock_s_ = 0;
};

// Strobe phases and gates. Dynamic: the phase leaks above 2 pi if a picture is longer than a turn at the channel's
// rate. It ends at a clamp of 1e6, where the sine is negative: dark for ever. Static: the phase is float seconds since
// the start times the tier's rate. So it loses digits by the hour and jumps when the tier changes.
class VrslStrobe {
 public:
  explicit VrslStrobe(const VrslSettings& settings) : settings_(settings) {}
  // Gates, 0 or 1. color_smoothed: the values of the colour pass, which the threshold is compared with.
  const VrslValues& step(const VrslValues& raw, const VrslValues& color_smoothed, float dt_s);
  // Since the program started. The shaders use it rounded to float.
  void set_uptime(double uptime_s) { clock_s_ = uptime_s; }

 private:
  VrslSettings settings_;
  VrslValues phase_{};
  VrslValues gate_{};
  double clock_s_ = 0;
};

// Spin phases. They grow without wrapping, so float precision stops them after days, and a change of direction jumps.
class VrslSpin {
 public:
  // A channel below code 3 holds its phase on a 9-universe grid and restarts it on the others.
  explicit VrslSpin(bool nine_universes = false) : holds_(nine_universes) {}
  // The angle of each channel in radians: 4 phases, negative if the channel is above one half.
  const VrslValues& step(const VrslValues& raw, float dt_s);

 private:
  VrslValues phase_{};
  VrslValues angle_{};
  double clock_s_ = 0;
  bool holds_ = false;
};

// In 9-universe mode the gate of universes 4 to 9 is that of the universe in the same place among 1 to 3, because the
// shader reads red only. universe: 1 to 9; returns 0 for others.
[[nodiscard]] constexpr int vrsl_strobe_universe(int universe) {
  return universe >= 1 && universe <= 9 ? (universe - 1) % 3 + 1 : 0;
}

// The gobo that a channel selects, 1 to 8. legacy: older fixtures have six.
[[nodiscard]] int vrsl_gobo(std::uint8_t level);
[[nodiscard]] int vrsl_gobo_of(float value, bool legacy);

// The angle of pan or tilt within its range, degrees from the middle. Both have 8 bits; fine channels are not read.
[[nodiscard]] float vrsl_angle_deg(std::uint8_t level, float range_deg);

}  // namespace footlight
