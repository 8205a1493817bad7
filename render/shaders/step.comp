#version 460
// One thread a head: raw levels -> what is asked -> motors, shutter, phases after dt. Counts the lit ones of its group.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#define FL_USE_HEADS
#define FL_STATES_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "sim/shared/dimmer.h"
#include "sim/shared/lamp.h"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(constant_id = FL_SPEC_MOTION) const bool kMotion = true;
layout(constant_id = FL_SPEC_SPIN) const bool kSpin = true;
layout(constant_id = FL_SPEC_STROBE) const bool kStrobe = true;
layout(constant_id = FL_SPEC_COLOR) const bool kColor = true;
layout(constant_id = FL_SPEC_OPTICS) const bool kOptics = true;
layout(constant_id = FL_SPEC_BLADES) const bool kBlades = true;
layout(constant_id = FL_SPEC_SHAKE) const bool kShake = true;
layout(constant_id = FL_SPEC_ANIMATION) const bool kAnimation = true;
layout(constant_id = FL_SPEC_STACKED) const bool kStacked = true;
layout(constant_id = FL_SPEC_PULSES) const bool kPulses = true;
layout(constant_id = FL_SPEC_MACRO) const bool kMacro = true;
layout(constant_id = FL_SPEC_LASER) const bool kLaser = true;
layout(constant_id = FL_SPEC_FLEX) const bool kFlex = true;
layout(constant_id = FL_SPEC_SMOOTH) const bool kSmooth = true;
layout(constant_id = FL_SPEC_DOWSER) const bool kDowser = true;
layout(constant_id = FL_SPEC_DECODED_COUNT) const uint kDecodedCount = kParamCount;
layout(push_constant) uniform Push { uint dt_ns_low; uint dt_ns_high; uint new_exposure; } push;

layout(set = 0, binding = FL_BINDING_LEVELS, std430) readonly buffer LevelsBuffer { uint levels[]; };
layout(set = 0, binding = FL_BINDING_CHANNELS, std430) readonly buffer ChannelsBuffer { ChannelRow channels[]; };
layout(set = 0, binding = FL_BINDING_FUNCTIONS, std430) readonly buffer FunctionsBuffer { FunctionRow functions[]; };
layout(set = 0, binding = FL_BINDING_MASTERS, std430) readonly buffer MastersBuffer { MasterRow masters[]; };
layout(set = 0, binding = FL_BINDING_MOTORS, std430) readonly buffer MotorsBuffer { MotorRow motors[]; };
layout(set = 0, binding = FL_BINDING_SPINS, std430) readonly buffer SpinsBuffer { SpinRow spins[]; };
layout(set = 0, binding = FL_BINDING_WHEELS, std430) readonly buffer WheelsBuffer { WheelRow wheels[]; };
layout(set = 0, binding = FL_BINDING_WHEEL_SLOTS, std430) readonly buffer SlotsBuffer { WheelSlotRow wheel_slots[]; };
layout(set = 0, binding = FL_BINDING_DEFAULTS, std430) readonly buffer DefaultsBuffer { float defaults[]; };
layout(set = 0, binding = FL_BINDING_COLORS, std430) readonly buffer ColorsBuffer { vec4 colors[]; };
layout(set = 0, binding = FL_BINDING_MOTOR_STATES, std430) buffer MotorStatesBuffer { Motor motor_states[]; };
layout(set = 0, binding = FL_BINDING_SPIN_STATES, std430) buffer SpinStatesBuffer { Spin spin_states[]; };
layout(set = 0, binding = FL_BINDING_SHUTTER_STATES, std430) buffer ShutterStatesBuffer { Shutter shutter_states[]; };
layout(set = 0, binding = FL_BINDING_OPTICS_STATES, std430) writeonly buffer OpticsStatesBuffer {
  OpticsState optics_states[];
};
layout(set = 0, binding = FL_BINDING_LASER_STATES, std430) buffer LaserStatesBuffer { LaserState laser_states[]; };
layout(set = 0, binding = FL_BINDING_SMOOTH_STATES, std430) buffer SmoothStatesBuffer { Smooth smooth_states[]; };
layout(set = 0, binding = FL_BINDING_LIGHTS, std430) readonly buffer LightsBuffer { LightRow lights[]; };
// Of each kind of lamp: whether the rig has one, the states of its lamps, and access to them.
#define FL_LAMP(number, Kind, need, State, per_head) \
  layout(constant_id = FL_SPEC_LAMP(number)) const bool kNeed##Kind = true; \
  layout(set = 0, binding = FL_BINDING_LAMP(number), std430) buffer Kind##StatesBuffer { State need##_states[]; }; \
  State fl_##need##_state(uint index) { return need##_states[index]; } \
  void fl_set_##need##_state(uint index, State state) { need##_states[index] = state; }
FL_LAMPS(FL_LAMP)
#undef FL_LAMP
layout(set = 0, binding = FL_BINDING_DOWSER_STATES, std430) buffer DowserStatesBuffer { Slew dowsers[]; };

uint fl_level(uint slot) { return (levels[slot >> 2] >> ((slot & 3u) * 8u)) & 255u; }
FunctionRow fl_function(uint index) { return functions[index]; }
MasterRow fl_master(uint index) { return masters[index]; }
ChannelRow fl_channel(uint index) { return channels[index]; }
MotorRow fl_motor(uint index) { return motors[index]; }
SpinRow fl_spin(uint index) { return spins[index]; }
WheelRow fl_wheel(uint index) { return wheels[index]; }
WheelSlotRow fl_wheel_slot(uint index) { return wheel_slots[index]; }
float fl_default(uint index) { return defaults[index]; }
vec4 fl_color(uint index) { return colors[index]; }
Motor fl_motor_state(uint index) { return motor_states[index]; }
void fl_set_motor_state(uint index, Motor motor) { motor_states[index] = motor; }
Spin fl_spin_state(uint index) { return spin_states[index]; }
void fl_set_spin_state(uint index, Spin spin) { spin_states[index] = spin; }
Smooth fl_smooth_state(uint index) { return smooth_states[index]; }
void fl_set_smooth_state(uint index, Smooth state) { smooth_states[index] = state; }
Flex fl_flex_state(uint index) { return Flex(smooth_states[index].now, smooth_states[index].from); }
void fl_set_flex_state(uint index, Flex flex) {
  smooth_states[index].now = flex.now;
  smooth_states[index].from = flex.from;
}
Shutter fl_shutter_state(uint index) { return shutter_states[index]; }
void fl_set_shutter_state(uint index, Shutter shutter) { shutter_states[index] = shutter; }
LightRow fl_light(uint index) { return lights[index]; }
float fl_filament(uint index) { return fl_default(index); }  // a rig with filaments has them first
Slew fl_dowser_state(uint index) { return dowsers[index]; }
void fl_set_dowser_state(uint index, Slew slew) { dowsers[index] = slew; }
LaserState fl_laser_state(uint index) { return laser_states[index]; }
void fl_set_laser_state(uint index, LaserState laser) { laser_states[index] = laser; }
// What no beam of the rig has stays 0, as it was made.
void fl_set_optics_state(uint index, OpticsState optics) {
  optics_states[index].image_1 = optics.image_1;
  optics_states[index].image_2 = optics.image_2;
  optics_states[index].angle_1 = optics.angle_1;
  optics_states[index].angle_2 = optics.angle_2;
  optics_states[index].iris = optics.iris;
  optics_states[index].frost = optics.frost;
  optics_states[index].prism = optics.prism;
  optics_states[index].prism_angle = optics.prism_angle;
  optics_states[index].next_1 = optics.next_1;
  optics_states[index].next_2 = optics.next_2;
  optics_states[index].offset_1 = optics.offset_1;
  optics_states[index].offset_2 = optics.offset_2;
  optics_states[index].focus = optics.focus;
  if (kBlades) {
    optics_states[index].blade_a = optics.blade_a;
    optics_states[index].blade_b = optics.blade_b;
    optics_states[index].blade_angle = optics.blade_angle;
  }
  if (kAnimation) {
    optics_states[index].animation = optics.animation;
    optics_states[index].animation_angle = optics.animation_angle;
  }
  if (kStacked) {
    optics_states[index].prism_2 = optics.prism_2;
    optics_states[index].prism_2_angle = optics.prism_2_angle;
  }
}

#define FL_DECODED_COUNT kDecodedCount
#define FL_NEED_MOTION kMotion
#define FL_NEED_SPIN kSpin
#define FL_NEED_STROBE kStrobe
#define FL_NEED_COLOR kColor
#define FL_NEED_OPTICS kOptics
#define FL_NEED_BLADES kBlades
#define FL_NEED_SHAKE kShake
#define FL_NEED_ANIMATION kAnimation
#define FL_NEED_STACKED kStacked
#define FL_NEED_PULSES kPulses
#define FL_NEED_MACRO kMacro
#define FL_NEED_LASER kLaser
#define FL_NEED_FLEX kFlex
#define FL_NEED_SMOOTH kSmooth
#define FL_NEED_DOWSER kDowser
#include "fixtures/shared/color.h"
#include "fixtures/shared/light.h"
#include "fixtures/shared/decode.h"
#include "render/shaders/lib/lit.glsl"

shared uint beams_here;
shared uint lit_here;

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (gl_LocalInvocationIndex == 0u) {
    beams_here = 0u;
    lit_here = 0u;
  }
  barrier();
  if (index < params.head_count) {
    HeadRow row = heads[index];
    TypeRow type = types[row.type];
    HeadState state = states[index];
    Decoded decoded;
    decode_head(decoded, type, row);
    head_step(state, decoded, type, row, Turns(push.dt_ns_low, push.dt_ns_high), push.new_exposure != 0u);
    states[index] = state;
    if (is_lit(state, type)) {
      atomicAdd(beams_here, state.beams);
      atomicAdd(lit_here, 1u);
    }
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    group_live[2u * gl_WorkGroupID.x] = beams_here;
    group_live[2u * gl_WorkGroupID.x + 1u] = lit_here;
  }
}
