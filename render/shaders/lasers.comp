#version 460
// Adds the light of lasers in the air and on surfaces. A workgroup has a tile of 16 x 16 pixels and goes through
// the rows that may touch it, in their order, 32 at a time. With FL_USE_HAZE: haze that is not even.
//
// Of each row the light in the air is computed at eight places of its strip of the tile: six give polynomials, which
// make the light of the tile's pixels, and two check them. Where these are off, and where something solid stands among
// the light, each pixel is computed. A row whose light is in front of all that the tile shows lights none of it.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/surface.glsl"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"
#include "render/shaders/lib/laser_strip.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_LASER) const bool kAir = true;  // light in the air is drawn
layout(set = 0, binding = FL_BINDING_LASER_MASKS, std430) readonly buffer LaserMasksBuffer { uint laser_masks[]; };
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX);
const uint kNotes = kThreads / 32u;
const uint kPlaces = 8u;                 // of a row: the nodes and the checks
const uint kBatch = kThreads / kPlaces;  // rows at a time
const float kStripError = 2e-3;  // of the most light of a row in a tile: polynomials are off by no more at the checks
const float kLeastLit = 1e-6;    // share of the light of a row that counts as none
const float kPi = 3.141592653589793;
const float kBodyAlbedo = 0.04;  // as in surface_light.glsl

shared uint word_bits[kNotes];   // of so many words: those that have a row
shared uint row_words[kThreads]; // their numbers, in order
shared uint row_bits[kNotes];    // of so many rows: those that touch the tile
shared uint listed[kThreads];    // their numbers, in order
shared Strip strips[kBatch];
shared vec2 places[kBatch * kPlaces];  // LaserAir.smooth_light and scale, then the coefficients of their polynomials
shared uint most_bits[kBatch];  // the most light of a row at its places, how much of it is lit, and its depths there, as
shared uint lit_bits[kBatch];   // bits of floats
shared uint near_bits[kBatch];
shared uint far_bits[kBatch];
shared uint off_bits;     // rows of a batch whose polynomials are off, a bit each
shared uint by_strip;     // rows whose air is drawn by polynomials
shared uint by_pixel;     // and those whose pixels are computed
shared uint on_surfaces;  // those that may light something solid
shared uint nearest_bits;  // depths of what the tile shows, as bits of floats
shared uint farthest_bits;

// Whether light gets as far as a surface. A body lies within what hides light for it.
bool gets_there(LaserRow row, LaserSheet sheet, LaserSpot spot, Surface surface) {
  float length_m = laser_length(sheet, spot.tau);
  if (spot.r_m <= length_m * 1.0005 + 1e-3 + row.slack_m) return true;
  uint fixture = spot.tau > sheet.jump ? row.end_fixture_2 : row.end_fixture_1;
  return surface.kind == kBody && fixture != FL_NONE && heads[surface.which >> 3].fixture == fixture &&
         spot.r_m < length_m + 1.0;
}

vec3 albedo_of(Surface surface) {
  if (surface.kind == kBox) return boxes[surface.which].albedo.rgb;
  if (surface.kind == kBody) return vec3(kBodyAlbedo);
  return vec3((uvec3(surface.which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
}

// The polynomials of a row: LaserAir.smooth_light and scale.
vec2 strip_value(uint slot, vec3 along, float across) {
  uint first = slot * kPlaces;
  return along.x * places[first] + along.y * places[first + 1u] + along.z * places[first + 2u] +
         across * (along.x * places[first + 3u] + along.y * places[first + 4u] + along.z * places[first + 5u]);
}

// The light of a row by the polynomials of its strip.
float light_of_strip(uint slot, vec2 px) {
  Strip strip = strips[slot];
  vec2 away = px - strip.middle;
  float x = dot(away, strip.along) / strip.half_px.x;
  float across_px = dot(away, strip_across(strip.along));
  if (abs(x) > 1.001) return 0.0;
  vec3 along = chebyshev(x);
  float edge = dot(strip.edge_1, vec3(1.0, px));
  if (strip.reach == 0.0) {
    float y = across_px / strip.half_px.y;
    if (abs(y) > 1.0) return 0.0;
    vec2 value = strip_value(slot, along, y);
    return max(value.x * value.y, 0.0) * normal_at(edge * value.y);
  }
  float last = edge + dot(strip.edge_2, vec3(1.0, px)) * strip.reach;
  // Where both edges are across, then the beam of the sheet that the pixel sees in the middle.
  vec2 at = across_px - vec2(edge, last) * strip.per_px;
  float y = clamp(across_px, min(at.x, at.y), max(at.x, at.y)) / strip.half_px.y;
  float scale = strip_value(slot, along, clamp(y, -1.0, 1.0)).y;
  if (min(abs(edge), abs(last)) * scale > 5.5 && edge * last > 0.0) return 0.0;
  float middle;
  float profile = normal_mean(edge * scale, last * scale, middle);
  y = mix(at.x, at.y, middle) / strip.half_px.y;
  return max(strip_value(slot, along, clamp(y, -1.0, 1.0)).x * scale, 0.0) * profile;
}

// Coefficient number `which` of the polynomials through the nodes of a row.
vec2 coefficient(uint slot, uint which) {
  vec3 along = weights_along(which % kNodesAlong);
  vec2 across = weights_across(which / kNodesAlong);
  uint first = slot * kPlaces;
  return across.x * (along.x * places[first] + along.y * places[first + 1u] + along.z * places[first + 2u]) +
         across.y * (along.x * places[first + 3u] + along.y * places[first + 4u] + along.z * places[first + 5u]);
}

// Which way the air of a row of the batch is drawn, and whether it lights something solid.
void choose(uint slot, LaserRow row) {
  // One over the depth of a sheet is even in the picture; the corners are somewhat beyond the places.
  float near_m = uintBitsToFloat(near_bits[slot]);
  float far_m = uintBitsToFloat(far_bits[slot]);
  bool is_along = !(near_m > 0.0 && far_m < 2.0 * near_m);
  float beyond = 0.15 * (1.0 / near_m - 1.0 / far_m);
  near_m = 1.0 / (1.0 / near_m + beyond);
  far_m = 1.0 / (1.0 / far_m - beyond);
  // A body is lit somewhat behind the end of the light, in what hides light for it.
  bool has_body = row.end_fixture_1 != FL_NONE || row.end_fixture_2 != FL_NONE;
  float behind_m = 1e-3 + 1e-3 * far_m + row.slack_m + (has_body ? 1.0 : 0.0);
  bool is_free = !is_along && far_m + behind_m < uintBitsToFloat(nearest_bits);
  bool is_hidden = !is_along && near_m > uintBitsToFloat(farthest_bits);
  bool is_off = !is_free || (off_bits >> slot & 1u) != 0u;
  bool is_lit = uintBitsToFloat(most_bits[slot]) > 0.0 && uintBitsToFloat(lit_bits[slot]) > kLeastLit;
  uint bit = is_hidden ? 0u : 1u << slot;
  if (kAir && is_lit && is_off) atomicOr(by_pixel, bit);
  if (kAir && is_lit && !is_off) atomicOr(by_strip, bit);
  if (!is_free) atomicOr(on_surfaces, bit);
}

// Adds some of the rows that touch the tile.
void add_batch(uint begin, uint count, vec2 middle, vec2 from_middle, Surface surface, float ray_length,
               inout vec3 air, inout vec3 lx) {
  uint thread = gl_LocalInvocationIndex;
  uint slot = thread / kPlaces;
  uint place = thread % kPlaces;
  if (thread == 0u) {
    by_strip = 0u;
    by_pixel = 0u;
    on_surfaces = 0u;
    off_bits = 0u;
  }
  if (place == 0u) {
    most_bits[slot] = 0u;
    lit_bits[slot] = 0u;
    near_bits[slot] = floatBitsToUint(FL_FAR_M);
    far_bits[slot] = 0u;
  }
  barrier();
  // First the places of all rows; then, where these do not do, the pixels. One call in a loop, since it is long code.
  uint left = 1u;
  for (bool at_places = true; left != 0u;) {
    LaserRow row = lasers[listed[begin + (at_places ? min(slot, count - 1u) : uint(findLSB(left)))]];
    LaserSheet sheet = laser_sheet(row);
    vec2 px = from_middle;
    float end_m = surface.t_m;
    bool works = true;
    if (at_places) {
      Strip strip = laser_strip(row, sheet, middle);
      if (place == 0u) strips[slot] = strip;
      px = strip_px(strip, strip_place(place));
      end_m = kNothingM;
      works = slot < count && strip.half_px.x > 0.0;
    }
    LaserPixel view = LaserPixel(ray_through(middle + px), laser_step_x(), laser_step_y());
#ifdef FL_USE_HAZE
    haze_begin(middle + px);
#endif
    LaserAir seen;
    seen.light = 0.0;
    if (works) seen = laser_in_air(sheet, view, end_m, params.anisotropy, params.position.w, kExtinction);
    if (!at_places) {
      air += row.light.rgb * seen.light;
      left &= left - 1u;
      continue;
    }
    if (works) {
      places[thread] = vec2(seen.smooth_light, seen.scale);
      atomicMax(most_bits[slot], floatBitsToUint(abs(seen.light)));
      atomicMax(lit_bits[slot], floatBitsToUint(abs(seen.lit)));
      atomicMin(near_bits[slot], floatBitsToUint(seen.is_along ? 0.0 : abs(max(seen.near_m, 0.0))));
      atomicMax(far_bits[slot], floatBitsToUint(seen.is_along ? FL_FAR_M : abs(max(seen.far_m, 0.0))));
    }
    barrier();
    vec2 value = vec2(0.0);
    if (place < kNodes) value = coefficient(slot, place);
    barrier();
    if (place < kNodes) places[thread] = value;
    barrier();
    float most = uintBitsToFloat(most_bits[slot]);
    if (works && place >= kNodes && !(abs(light_of_strip(slot, px) - seen.light) <= kStripError * most)) {
      atomicOr(off_bits, 1u << slot);
    }
    barrier();
    if (works && place == 0u) choose(slot, row);
    barrier();
    left = by_pixel;
    at_places = false;
  }
  for (uint bits = by_strip; bits != 0u; bits &= bits - 1u) {
    uint of = uint(findLSB(bits));
    air += strips[of].light * light_of_strip(of, from_middle);
  }
  LaserPixel view = LaserPixel(ray_through(middle + from_middle), laser_step_x(), laser_step_y());
  for (uint bits = surface.kind == kNothing ? 0u : on_surfaces; bits != 0u; bits &= bits - 1u) {
    LaserRow row = lasers[listed[begin + uint(findLSB(bits))]];
    LaserSheet sheet = laser_sheet(row);
    float depth = surface.t_m / ray_length;
    LaserSpot spot = laser_on_surface(sheet, view, sheet.eye + view.ray * depth, depth, surface.normal);
    if (spot.illuminance > 0.0 && gets_there(row, sheet, spot, surface)) {
      float lost = kExtinction ? exp(-params.position.w * spot.r_m) : 1.0;
      lx += row.light.rgb * (spot.illuminance * lost);
    }
  }
  barrier();
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  uvec2 pixel = gl_GlobalInvocationID.xy;
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = low + float(FL_TILE_PX);
  vec2 middle = 0.5 * (low + high);
  vec2 from_middle = vec2(pixel) + 0.5 - middle;
  uvec2 size = uvec2(params.width, params.height);
  bool is_drawn = all(lessThan(pixel, size));
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  uint rows = uint(lasers.length());
  uint words = (rows + 31u) / 32u;
  uint mask = (cell.y * params.supertiles_x + cell.x) * words;

  Surface surface;
  float ray_length = 1.0;
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  bool ready = false;
  for (uint base = 0u; base < words; base += kThreads) {
    barrier();
    if (thread < kNotes) word_bits[thread] = 0u;
    if (thread == 0u) {
      nearest_bits = floatBitsToUint(kNothingM);
      farthest_bits = 0u;
    }
    barrier();
    uint word = base + thread < words ? laser_masks[mask + base + thread] : 0u;
    if (word != 0u) atomicOr(word_bits[thread / 32u], 1u << (thread % 32u));
    barrier();
    uint before = 0u;
    uint count = 0u;
    for (uint w = 0u; w < kNotes; ++w) {
      uint here = uint(bitCount(word_bits[w]));
      if (w < thread / 32u) before += here;
      count += here;
    }
    before += uint(bitCount(word_bits[thread / 32u] & ((1u << (thread % 32u)) - 1u)));
    if (word != 0u) row_words[before] = base + thread;
    for (uint from = 0u; from < count; from += kNotes) {
      barrier();
      if (thread < kNotes) row_bits[thread] = 0u;
      barrier();
      uint which = from + thread / 32u;
      uint index = 0u;
      if (which < count) {
        index = 32u * row_words[which] + thread % 32u;
        bool touches = (laser_masks[mask + row_words[which]] >> (thread % 32u) & 1u) != 0u;
        if (touches && laser_touches(lasers[index], low, high)) {
          atomicOr(row_bits[thread / 32u], 1u << (thread % 32u));
        }
      }
      barrier();
      uint earlier = 0u;
      uint total = 0u;
      for (uint w = 0u; w < kNotes; ++w) {
        uint here = uint(bitCount(row_bits[w]));
        if (w < thread / 32u) earlier += here;
        total += here;
      }
      uint own = row_bits[thread / 32u];
      earlier += uint(bitCount(own & ((1u << (thread % 32u)) - 1u)));
      if ((own >> (thread % 32u) & 1u) != 0u) listed[earlier] = index;
      if (total > 0u && !ready) {
        vec3 ray = ray_through(vec2(pixel) + 0.5);
        ray_length = length(ray);
        surface = surface_at(ivec2(min(pixel, size - 1u)), ray / ray_length);
        ready = true;
        if (is_drawn) {
          atomicMin(nearest_bits, floatBitsToUint(surface.t_m / ray_length));
          atomicMax(farthest_bits, floatBitsToUint(surface.t_m / ray_length));
        }
      }
      barrier();
      for (uint begin = 0u; begin < total; begin += kBatch) {
        add_batch(begin, min(total - begin, kBatch), middle, from_middle, surface, ray_length, air, lx);
      }
    }
  }
  if (!ready || !is_drawn) return;
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air;
    if (surface.kind != kNothing) {
      float lost = kExtinction ? exp(-params.position.w * surface.t_m) : 1.0;
      sum += albedo_of(surface) / kPi * lx * lost;
    }
  }
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb + sum, behind.a));
}
