#version 460
// Every header of sim/shared as GLSL, and every model called: what compiles as C++ must compile here, too.
#extension GL_GOOGLE_include_directive : require
#include "sim/shared/real.h"
#include "sim/shared/turns.h"
#include "sim/shared/motion.h"
#include "sim/shared/shutter.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) buffer Models {
  Motor motor;
  Flex flex;
  Spin spin;
  Shutter shutter;
  ShutterWish wish;
  MotorLimits limits;
  FlexLimits soft;
  Turns dt_ns;
  Real value;
};

void main() {
  Motor before = motor;
  motor = motor_step(motor, motor_vector(motor_limits(limits.speed_max, 2.0, 0.5), value), value, dt_ns);
  flex = flex_step(flex, soft, before, motor, limits);
  spin = spin_step(spin, limits.acceleration_max, value, dt_ns);
  Shutter moved = shutter;
  value = shutter_step(moved, wish, dt_ns) + shutter_triggered(value, 0.01, time_s(dt_ns));
  shutter = moved;
  value += shake_offset(spin.phase, turns_way(spin.phase, time_ns(value)));
}
