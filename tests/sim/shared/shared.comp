#version 460
// Every header of sim/shared as GLSL, and every model called: code that compiles as C++ must compile here, too.
#extension GL_GOOGLE_include_directive : require
#include "sim/shared/real.h"
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/filter.h"
#include "sim/shared/haze.h"
#include "sim/shared/dimmer.h"
#include "sim/shared/lamp.h"
#include "sim/shared/shutter.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) buffer Models {
  Motor motor;
  Flex flex;
  Spin spin;
  Shutter shutter;
  Smooth smoothed;
  Slew slew;
  RoomAir air;
  LawTable table;
  Filament filament;
  FilamentType filament_type;
  Led led;
  LedType led_type;
  Discharge discharge;
  DischargeType discharge_type;
  ShutterParams params;
  MotorLimits limits;
  FlexLimits soft;
  Turns dt_ns;
  Real value;
};

layout(set = 0, binding = 1, std430) readonly buffer Curves { float curves[]; };
float fl_filament(uint index) { return curves[index]; }

void main() {
  Motor before = motor;
  motor = motor_step(motor, motor_vector(motor_limits(limits.speed_max, 2.0, 0.5), value), value, dt_ns);
  flex = flex_step(flex, soft, before, motor, limits);
  Spin turning = spin;
  spin_move(turning, limits.acceleration_max, value, dt_ns);
  spin = turning;
  Shutter moved = shutter;
  value = shutter_step(moved, params, dt_ns);
  shutter = moved;
  value += turns_way(spin.phase, time_ns(value));
  smoothed = smooth_step(smoothed, 0.02, value, dt_ns);
  Slew slewed = slew;
  value = slew_step(slewed, 0.5, smoothed.now.position, dt_ns);
  slew = slewed;
  air = room_step(air, 120.0, value, 0.1, dt_ns);
  value += room_scattering(air);
  value = law_light(kLawS, value) + law_table(table, value);
  Filament hot = filament;
  filament_move(hot, filament_type, phase_cut_rms(value), dt_ns);
  filament = hot;
  value += filament_light(filament.kelvin, filament_type);
  value += mains_mean(spin.phase, turns_advance(100.0, dt_ns), value) + filament_volt(2000.0, filament_type);
  Led glowing = led;
  value += led_step(glowing, led_type, value, dt_ns);
  led = glowing;
  Discharge burning = discharge;
  value += discharge_step(burning, discharge_type, 1u, dt_ns) + discharge_kelvin(burning, 4000.0, 6000.0);
  discharge = burning;
}
