#version 460
// World clusters, second pass: light on boxes, pixel by pixel, of the lights of its three slabs. The law of light is
// that of beam.h, or ClusteredBIRP's own: an inverse square with 1 added, windowed to the range, and a spot whose edge
// is the square of a line in the cosine from 70 % of the angle on. That law's record has half floats.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/rivals/shaders/lib/rival_light.glsl"
#include "render/shaders/lib/surface.glsl"

layout(local_size_x = FL_GROUP_SURFACE, local_size_y = FL_GROUP_SURFACE) in;
layout(constant_id = FL_SPEC_CLUSTER_LIGHTS) const uint kLights = 0;
layout(constant_id = FL_SPEC_CLUSTER_EDGES) const bool kEdges = false;
layout(constant_id = FL_SPEC_CLUSTER_LAW) const bool kOwnLaw = false;
layout(set = 0, binding = FL_BINDING_CLUSTERS, std430) readonly buffer ClustersBuffer { uint clusters[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform writeonly image2D radiance;

vec2 as_halves(vec2 v) { return unpackHalf2x16(packHalf2x16(v)); }

// lx. place_m: from the camera.
vec3 own_law(BeamRow row, vec3 place_m, vec3 normal) {
  vec3 lens_m = -vec3(row.eye.x * row.x_axis.xyz + row.eye.y * row.y_axis.xyz + row.eye.z * row.axis.xyz);
  vec3 to_lens_m = lens_m - place_m;
  float square = dot(to_lens_m, to_lens_m);
  float range_square = as_halves(vec2(0.5 * max(0.1, row.axis.w * row.axis.w), 0.0)).x * 2.0;
  vec3 way = to_lens_m * inversesqrt(max(square, 1e-12));
  vec3 axis = normalize(row.axis.xyz + 0.001);
  axis = vec3(as_halves(axis.xy), as_halves(axis.zz).x);
  float half_rad = atan(row.y_axis.w);
  float scale = 1.0 / max(cos(0.7 * half_rad) - cos(half_rad), 1e-4);
  vec2 spot = as_halves(vec2(scale, -cos(half_rad) * scale));
  float cone = clamp(dot(axis, -way) * spot.x + spot.y, 0.0, 1.0);
  float window = clamp(1.0 - square * square / (range_square * range_square), 0.0, 1.0);
  // The peak of the beam, in units of the exposure as its colour is; the largest half float is the most it may be.
  vec3 peak = min(row.j0.rgb * (params.exposure / max(row.y_axis.w * row.y_axis.w, 1e-9)), 65504.0);
  vec2 red_green = as_halves(peak.rg);
  vec3 color = vec3(red_green, as_halves(peak.bb).x) / params.exposure;
  return color * (cone * cone * window * window / (square + 1.0) * max(dot(normal, way), 0.0));
}

vec3 our_law(BeamRow row, uint index, vec3 place_m, vec3 normal) {
  BeamShape shape = begin_beam(row, index);
  vec3 p = row.eye.xyz + to_light(row, place_m);
  vec2 rho;
  float r_m;
  float share = beam_illuminance(shape, p, rho, r_m);
  if (!(share > 0.0)) return vec3(0.0);
  share *= max(-dot(to_light(row, normal), beam_direction(shape, rho)), 0.0);
  if (kExtinction) share *= exp(-params.position.w * r_m);
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(index, rho, p.z);
  vec3 through = vec3(share);
  if (has_gobo(row)) through *= gobo_on_surface(row.gobo, rho, p.z);
  return row.j0.rgb * through;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
  Surface hit = surface_at(pixel, d);
  vec3 color = vec3(0.0);
  if (hit.kind == kBox) {
    vec3 place_m = d * hit.t_m;
    vec3 cell = floor((place_m + FL_CLUSTER_REACH_M) * (0.5 * float(FL_CLUSTER_SLABS) / FL_CLUSTER_REACH_M));
    bool outside = any(lessThan(cell, vec3(0.0))) || any(greaterThanEqual(cell, vec3(FL_CLUSTER_SLABS)));
    uvec3 slab = uvec3(clamp(cell, 0.0, float(FL_CLUSTER_SLABS) - 1.0));
    uvec3 first = (slab + uvec3(0u, FL_CLUSTER_SLABS, 2 * FL_CLUSTER_SLABS)) * params.mask_words;
    uint lights = kLights > 0u ? min(counts.live_count, kLights) : counts.live_count;
    uint words = outside && kEdges ? 0u : (lights + 31u) / 32u;
    vec3 illuminance_lx = vec3(params.ambient_lx);
    for (uint w = 0u; w < words; ++w) {
      uint bits = clusters[first.x + w] & clusters[first.y + w] & clusters[first.z + w];
      for (; bits != 0u; bits &= bits - 1u) {
        uint index = w * 32u + uint(findLSB(bits));
        BeamRow row = beams[index];
        illuminance_lx += kOwnLaw ? own_law(row, place_m, hit.normal) : our_law(row, index, place_m, hit.normal);
      }
    }
    color = boxes[hit.which].albedo.rgb / 3.141592653589793 * illuminance_lx;
    if (kExtinction) color *= exp(-params.position.w * hit.t_m);
  }
  imageStore(radiance, pixel, vec4(color, hit.t_m));
}
