#version 460
// Depth of field: each pixel gets the light of those around it whose discs reach it. What is nearer lies over it. What
// is behind it shows through where its own disc reaches past its edge.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/blur.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_BLURRED, rgba32f) uniform writeonly image2D blurred;
layout(set = 0, binding = FL_BINDING_BLURS, std430) readonly buffer BlursBuffer { float blurs[]; };

const float kNothingPx = 0.05;  // of blur

// The share of a disc's light that a pixel at this distance from its middle gets. Its edge is a pixel wide.
float share_of(float distance_px, float radius_px) {
  float shown = clamp(radius_px + 0.5 - distance_px, 0.0, 1.0);
  if (shown == 0.0) return 0.0;
  // The sum over all pixels.
  float near = min(radius_px + 0.5, 1.0) + 4.0 * clamp(radius_px - 0.5, 0.0, 1.0) +
               4.0 * clamp(radius_px - 0.9142136, 0.0, 1.0);
  return shown / (radius_px < 1.5 ? near : 3.14159265 * (radius_px * radius_px + 1.0 / 12.0));
}

// The blur that can reach this tile, pixels.
float reach_px() {
  ivec2 tiles = ivec2(gl_NumWorkGroups.xy);
  ivec2 own = ivec2(gl_WorkGroupID.xy);
  const int across = (FL_BLUR_PX_MAX + FL_TILE_PX - 1) / FL_TILE_PX;
  float widest = 0.0;
  for (int y = max(own.y - across, 0); y <= min(own.y + across, tiles.y - 1); ++y) {
    for (int x = max(own.x - across, 0); x <= min(own.x + across, tiles.x - 1); ++x) {
      ivec2 away = max(abs(ivec2(x, y) - own) - 1, ivec2(0)) * FL_TILE_PX;
      float px = blurs[y * tiles.x + x];
      if (px + 1.0 >= float(max(away.x, away.y))) widest = max(widest, px);
    }
  }
  return widest;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = ivec2(params.width, params.height);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  vec4 own = imageLoad(radiance, pixel);
  float reach = reach_px();
  if (reach < kNothingPx) {
    imageStore(blurred, pixel, own);
    return;
  }
  float own_px = blur_px(uvec2(pixel), own.a);
  vec3 over = vec3(0.0);
  vec3 under = vec3(0.0);
  float over_weight = 0.0;
  float under_weight = 0.0;
  int side = int(ceil(reach + 0.5));
  for (int y = -side; y <= side; ++y) {
    for (int x = -side; x <= side; ++x) {
      ivec2 at = pixel + ivec2(x, y);
      // Beyond the border the picture is mirrored, so that no light is lost.
      at = max(at, -1 - at);
      at = clamp(min(at, 2 * size - 1 - at), ivec2(0), size - 1);
      vec4 there = imageLoad(radiance, at);
      float px = blur_px(uvec2(at), there.a);
      float away = length(vec2(x, y));
      float nearer = clamp(own_px - px - 0.5, 0.0, 1.0);
      float behind = clamp(px - own_px - 0.5, 0.0, 1.0);
      float lying = nearer * share_of(away, abs(px));
      float lit = (1.0 - nearer) * share_of(away, mix(abs(px), abs(own_px), behind));
      over += lying * there.rgb;
      over_weight += lying;
      under += lit * there.rgb;
      under_weight += lit;
    }
  }
  vec3 light = under_weight > 0.0 ? under / under_weight : own.rgb;
  light = over_weight > 1.0 ? over / over_weight : over + (1.0 - over_weight) * light;
  imageStore(blurred, pixel, vec4(light, own.a));
}
