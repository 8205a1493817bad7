#version 460
// Floors that mirror: replaces a share of a floor's own light by what its facets mirror. The picture of the mirrored
// camera has the light of each ray that one flat mirror throws back; facets with a slope see it beside that, by so much
// as what they see is away from the floor. Along the plane of incidence, where facets turn the light most, the mean
// over slopes is a sum over places; across it the levels of the pyramid are as blurred as the slopes
// (docs/decisions/0149).
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/mirror_levels.glsl"
#include "render/shaders/lib/gloss.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;
layout(set = 0, binding = FL_BINDING_MIRROR, rgba32f) uniform readonly image2D mirror;
layout(push_constant) uniform Push { int width; int height; int levels; uint count; } push;

const float kReach = 2.5;        // of the slopes that are summed up, in standard deviations
const float kSpacing = 1.5;      // of the places, in standard deviations of the blur
const float kPlacesMax = 16.0;
const float kFarM = 1e4;         // what is farther away counts as so far

ivec4 levels[FL_MIRROR_LEVELS];

// which: the texel of each pixel (mirror_levels.glsl).
vec4 level_at(int n, vec2 at, int which) {
  ivec4 level = levels[n];
  // A level whose size was rounded up ends beyond the picture.
  vec2 px = clamp(at, vec2(0.0), vec2(1.0)) * vec2(levels[0].zw) * exp2(-float(n)) - 0.5;
  ivec2 low = ivec2(floor(px));
  vec2 part = px - vec2(low);
  ivec2 most = level.zw - 1;
  ivec2 a = level.xy + clamp(low, ivec2(0), most);
  ivec2 b = level.xy + clamp(low + 1, ivec2(0), most);
  vec4 upper = mix(imageLoad(mirror, mirror_texel(a, which)), imageLoad(mirror, mirror_texel(ivec2(b.x, a.y), which)),
                   part.x);
  vec4 lower = mix(imageLoad(mirror, mirror_texel(ivec2(a.x, b.y), which)), imageLoad(mirror, mirror_texel(b, which)),
                   part.x);
  return mix(upper, lower, part.y);
}

// The picture at `at`, 0 to 1 across and down, blurred by a standard deviation in pixels of level 0: level n has
// (4^n - 1) / 4, and the interpolation between its pixels adds 4^n / 6.
vec4 blurred_at(vec2 at, float blur_px, int which) {
  float n = clamp(0.5 * log2((blur_px * blur_px + 0.25) / 0.4167), 0.0, float(push.levels - 1));
  int low = int(n);
  vec4 light = level_at(low, at, which);
  return n > float(low) ? mix(light, level_at(low + 1, at, which), n - float(low)) : light;
}

struct Floor {
  vec3 place;  // from the camera, m
  vec3 ray;    // unit
  vec3 along;  // level and unit: the way that the ray goes over the floor, and across it
  vec3 aside;
};

// What a facet with slopes against `along` and `aside` mirrors, `far_m` from the floor: xy: where in the picture; z:
// how much of it the eye sees; 0: nothing.
vec3 facet_sees(Floor at, vec2 slopes, float far_m) {
  vec3 normal = vec3(0.0, 0.0, 1.0) - slopes.x * at.along - slopes.y * at.aside;
  float shown = -dot(at.ray, normal);
  vec3 way = at.ray + 2.0 * shown / dot(normal, normal) * normal;
  vec3 mirrored = at.place + far_m * vec3(way.xy, -way.z);
  float depth = dot(mirrored, params.forward.xyz);
  vec2 ndc = vec2(dot(mirrored, params.right.xyz) / dot(params.right.xyz, params.right.xyz),
                  dot(mirrored, params.up.xyz) / dot(params.up.xyz, params.up.xyz)) / max(depth, 1e-6);
  bool sees = shown > 0.0 && way.z > 0.0 && depth > 0.0;
  return vec3(0.5 + 0.5 * clamp(vec2(ndc.x, -ndc.y), vec2(-4.0), vec2(4.0)), sees ? shown : 0.0);
}

vec3 mirrored_light(Floor at, float roughness) {
  vec2 size = vec2(push.width, push.height);
  float t_m = length(at.place);
  vec2 middle = facet_sees(at, vec2(0.0), t_m).xy;
  float slope = roughness * 0.70710678;  // standard deviation on each axis
  if (!(slope > 1e-6)) {
    vec4 sharp = blurred_at(middle, 0.0, 0);
    return sharp.rgb / max(sharp.a, 1e-12);
  }
  // How far away what is mirrored here is, on average.
  float widest_px = length((facet_sees(at, vec2(0.0, slope), kFarM).xy - middle) * size);
  float behind = blurred_at(middle, 0.5 * widest_px, 1).r / max(blurred_at(middle, 0.5 * widest_px, 0).a, 1e-12);
  float far_m = min(t_m * behind / max(1.0 - behind, 1e-6), kFarM);
  vec2 along_px = (facet_sees(at, vec2(slope, 0.0), far_m).xy - facet_sees(at, vec2(-slope, 0.0), far_m).xy) * size;
  float along = 0.5 * length(along_px);
  float across = min(length((facet_sees(at, vec2(0.0, slope), far_m).xy - middle) * size), along);
  // Places have what is left of the variance along.
  float spread = along > 0.0 ? sqrt(max(1.0 - across * across / (along * along), 0.0)) : 0.0;
  float whole_px = 2.0 * kReach * along * spread;
  float places = clamp(ceil(whole_px / (kSpacing * max(across, 0.6))), 1.0, kPlacesMax);
  float blur_px = max(across, whole_px / (kSpacing * places));
  if (places == 1.0) blur_px = max(across, along * spread);
  vec3 sum = vec3(0.0);
  float weights = 0.0;
  for (float i = 0.5; i < places; i += 1.0) {
    float deviations = places > 1.0 ? (2.0 * i / places - 1.0) * kReach : 0.0;
    vec3 seen = facet_sees(at, vec2(deviations * slope * spread, 0.0), far_m);
    float weight = exp(-0.5 * deviations * deviations) * seen.z;
    if (!(weight > 0.0)) continue;
    vec4 light = weight * blurred_at(seen.xy, blur_px, 0);
    sum += light.rgb;
    weights += light.a;
  }
  return weights > 0.0 ? sum / weights : vec3(0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec4 shown = imageLoad(radiance, pixel);
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  uint found = floor_at(ray, shown.a, push.count);
  if (found == FL_NONE) return;
  for (int n = 0; n < FL_MIRROR_LEVELS; ++n) levels[n] = mirror_level(ivec2(push.width, push.height), n);
  float level_length = length(ray.xy);
  vec3 along = level_length > 1e-6 ? vec3(ray.xy / level_length, 0.0) : vec3(1.0, 0.0, 0.0);
  float share = glosses[found].center.w;
  share += (1.0 - share) * pow(clamp(1.0 + ray.z, 0.0, 1.0), 5.0);
  vec3 light = mirrored_light(Floor(ray * shown.a, ray, along, vec3(-along.y, along.x, 0.0)), glosses[found].half_x.w);
  imageStore(radiance, pixel, vec4(mix(shown.rgb, light, share), shown.a));
}
