#version 460
// Follows the light of each beam to the patches that it reaches first: a workgroup a beam, a thread one of its
// FL_BOUNCE_RAYS rays, which have equal shares of its cross section. The flux of a ray is that of surfaces
// (light_on_surface) across the beam where the ray ends. Sums are integers, so their order does not matter.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
#include "render/shaders/lib/surface_light.glsl"
#include "render/shaders/lib/bounce_rays.glsl"

layout(local_size_x = FL_BOUNCE_RAYS) in;
layout(set = 0, binding = FL_BINDING_BOUNCE_FLUX, std430) buffer FluxBuffer { uint flux[]; };

layout(set = 0, binding = FL_BINDING_BOUNCE_PATCHES, std430) readonly buffer PatchesBuffer {
  BouncePatchRow patches[];
};

const float kLensAwayM = 2e-3;  // a face in the plane of a lens does not hold the lens

void add_flux(uint at, float lm) {
  float units = lm * FL_BOUNCE_FLUX;
  if (!(units >= 1.0)) return;  // nor what is no number
  units = min(units, 1e18);
  float high = floor(units / 4294967296.0);
  uint low = uint(units - high * 4294967296.0);
  uint before = atomicAdd(flux[at], low);
  uint carry = before + low < before ? 1u : 0u;
  uint added = uint(high) + carry;
  if (added != 0u) atomicAdd(flux[at + 1u], added);
}

// Ray i in the unit disc: 8 x 8 equal areas of a square, taken to the disc (Shirley and Chiu 1997).
vec2 in_square(uint i) { return (vec2(i & 7u, i >> 3) + 0.5) * 0.25 - 1.0; }
vec2 in_disc(vec2 square) {
  bool wide = abs(square.x) > abs(square.y);
  float r = wide ? square.x : square.y;
  float angle = 0.7853981633974483 * (wide ? square.y / square.x : 2.0 - square.x / square.y);
  return r * vec2(cos(angle), sin(angle));
}

void main() {
  uint index = gl_WorkGroupID.y * uint(FL_SHADOWS_X) + gl_WorkGroupID.x;
  if (index >= counts.live_count) return;
  uint ray = gl_LocalInvocationIndex;
  BeamRow row = beams[index];
  bool is_square = kRectangle && row.squeeze > 0.0;
  vec2 rho = is_square ? 0.7071067811865476 * in_square(ray) : in_disc(in_square(ray));
  float disc = is_square ? 2.0 : kPi;
  // From the lens plane, a unit of t is a metre along the axis. Lengths along y of a rectangle's light space are
  // stretched.
  vec3 y_axis = row.y_axis.xyz / dot(row.y_axis.xyz, row.y_axis.xyz);
  vec3 at_lens = row.x_axis.xyz * (rho.x * row.x_axis.w - row.eye.x) + y_axis * (rho.y * row.x_axis.w - row.eye.y) -
                 row.axis.xyz * row.eye.z;
  vec3 way = row.x_axis.xyz * (rho.x * row.y_axis.w) + y_axis * (rho.y * row.y_axis.w) + row.axis.xyz;
  float t;
  uint face;
  uint solid = bounce_hit(params.position.xyz + at_lens, way, kLensAwayM, row.axis.w, false, t, face);
  // A solid around the lens keeps all of the light.
  if (solid == FL_NONE || !(t > kLensAwayM)) return;
  uint first = solids[solid].first[face];
  if (first == FL_NONE) return;

  gobo_begin(index);
  SurfaceBeam beam = surface_beam(row);
  beam.thin = false;
  Surface across = Surface(kBox, 0u, -row.axis.xyz, 0.0, 0u);
  Medium medium = Medium(params.anisotropy, params.position.w);
  float w = row.x_axis.w + row.y_axis.w * t;
  float area = disc * w * w / float(FL_BOUNCE_RAYS);
  if (is_square) area *= sqrt(row.squeeze);
  vec3 lm = area * light_on_surface(beam, row, index, medium, across, at_lens + way * t);

  uint axis = face >> 1;
  vec3 place = params.position.xyz + at_lens + way * t;
  vec4 dual_u = solids[solid].dual[(axis + 1u) % 3u];
  vec4 dual_v = solids[solid].dual[(axis + 2u) % 3u];
  uvec2 count = uvec2(solids[solid].count[face] & 0xffffu, solids[solid].count[face] >> 16);
  vec2 at = 0.5 + 0.5 * vec2(dot(dual_u.xyz, place) + dual_u.w, dot(dual_v.xyz, place) + dual_v.w);
  // The rays are spread over a patch's size by a sequence that fills it evenly (M. Roberts 2018). Without that the
  // light of a narrow beam would jump from patch to patch as the beam moves.
  vec2 spread = fract(vec2(0.5) + float(ray) * vec2(0.7548776662466927, 0.5698402909980532)) - 0.5;
  uvec2 own = uvec2(clamp(at * vec2(count) + spread, vec2(0.0), vec2(count) - 0.5));
  uint patch_index = first + own.y * count.x + own.x;
  // A patch that is covered emits nothing: the ray stays where it ends.
  uvec2 ends = uvec2(clamp(at * vec2(count), vec2(0.0), vec2(count) - 0.5));
  if (!(patches[patch_index].center.w > 0.0)) patch_index = first + ends.y * count.x + ends.x;
  add_flux(6u * patch_index, lm.r);
  add_flux(6u * patch_index + 2u, lm.g);
  add_flux(6u * patch_index + 4u, lm.b);
}
