// Models of sim/shared that change in place, as functions from a state to the next.
#pragma once

#include "sim/shared/shared.h"

namespace footlight {

namespace f32 {
inline Spin spin_step(Spin spin, float ramp_hz_s, float target_hz, Turns dt_ns) {
  spin_move(spin, ramp_hz_s, target_hz, dt_ns);
  return spin;
}
inline Filament filament_step(Filament filament, FilamentType type, float volt, Turns dt_ns) {
  filament_move(filament, type, volt, dt_ns);
  return filament;
}
}  // namespace f32

namespace f64 {
inline Spin spin_step(Spin spin, double ramp_hz_s, double target_hz, Turns dt_ns) {
  spin_move(spin, ramp_hz_s, target_hz, dt_ns);
  return spin;
}
inline Filament filament_step(Filament filament, FilamentType type, double volt, Turns dt_ns) {
  filament_move(filament, type, volt, dt_ns);
  return filament;
}
}  // namespace f64

}  // namespace footlight
