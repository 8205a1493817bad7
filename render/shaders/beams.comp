#version 460
// Light in the haze, pixel by pixel: adds the in-scattered light of every beam along the pixel's ray, up to the surface
// it shows. With tile classes, of the beams that the fine pass has left. FL_GOBO_BEAMS: beams may have gobos.
// FL_USE_HAZE: haze is not even. FL_ROW_BEAMS: rowbeams.comp, for the beams with FL_BEAM_ROWS alone, whose shadows are
// rows of maps and whose light is that of nodes. It has no code for others, so more of its threads run at a time.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#ifdef FL_ROW_BEAMS
#define FL_SERIES_TWICE
#endif
layout(constant_id = FL_SPEC_ROW_BEAMS) const bool kRowBeams = false;
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo.glsl"
#else
#include "render/shaders/lib/blades.glsl"
#endif
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo_chord.glsl"
#endif
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
#include "render/shaders/lib/mirror.glsl"

layout(constant_id = FL_SPEC_TILES) const bool kTiles = false;
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
#ifdef FL_ROW_BEAMS
#define FL_DEPTHS_ACCESS
#else
#define FL_DEPTHS_ACCESS readonly
#endif
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/shadow_rect.glsl"
layout(set = 0, binding = FL_BINDING_SHADE_WORDS, std430) readonly buffer ShadeWordsBuffer {
  ShadowWordRow shade_words[];
};
#define FL_PICKS_ACCESS readonly
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"

uint supertile() {
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  return cell.y * params.supertiles_x + cell.x;
}

// FL_ONE_ROW: a thread has one pixel, where gobos have tables. On an H200 at 3840 x 2160 10,000 beams with gobos take
// 106 ms with four, 104 with two and 98 with one (`footlight report --pictures --quick --no-judge --gobos --beams 10000
// --shadows off`); without gobos 3.6 with four and 5.6 with one. On lavapipe one takes twice the time of four: 440
// instead of 230 ms (`footlight render --demo --from 12s --until 12.2s --every 40ms --size 640x360 --json`).
#ifdef FL_ONE_ROW
#define FL_ROWS 1
#endif
// Beams with shadows, of which the passes before have added all of their light: what is in the shadows is subtracted.
#define FL_WALK_FINE (kTiles && counts.fine_groups[0] > 0u)
// Whether shade.comp has run: it does for pictures alone.
#define FL_WALK_LISTS (kShadows && FL_WALK_FINE && kView == uint(FL_VIEW_PICTURE))
#define FL_WALK_ALSO(word) (FL_WALK_LISTS ? shade_words[walk_word(word)].beams : 0u)
#define FL_WALK_BITS(word) (kShadows ? walk_now[word] : walk_bits[word])
uint walk_word(uint word);
bool tile_takes(uint beam, uint number);
#include "render/shaders/lib/tile_walk.glsl"

#include "render/shaders/lib/shadow_walk.glsl"

#ifdef FL_ROW_BEAMS
shared uint walk_leaves;  // the tile has other beams
#endif
// The tile itself, 16 x 16 pixels.
bool tile_takes(uint beam, uint number) {
  BeamRow row = beams[beam];
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  bool by_rows = kRowBeams && (row.flags & FL_BEAM_ROWS) != 0u;
#ifndef FL_ROW_BEAMS
  if (by_rows) return false;
#endif
  if (!beam_touches(row, beam_bound(row, 1.0), low, high)) return false;
#ifdef FL_ROW_BEAMS
  if (!by_rows) {
    atomicOr(walk_leaves, 1u);
    return false;
  }
#endif
  if (kShadows) walk_pairs[number] = picks_here(beam).count;
  return true;
}

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_METHOD) const uint kMethod = FL_METHOD_GAUSS;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
#include "render/shaders/lib/air_nodes.glsl"
#include "render/shaders/lib/shadow_row_light.glsl"

layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

// The code of gobos is long: once in the shader, and not once a row. Without them a loop over rows would take rounds
// from Mesa, which ends the loops of a thread after 65,535 of them.
#if defined(FL_GOBO_BEAMS) && !defined(FL_ONE_ROW)
#define FL_EACH_ROW [[dont_unroll]]
#else
#define FL_EACH_ROW [[unroll]]
#endif

// Light of a part of a chord, over J0 and sigma_s.
vec3 part_light(BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray, uint nodes, bool gobo) {
#ifdef FL_GOBO_BEAMS
  if (gobo) {
    if (kMethod == uint(FL_METHOD_MARCH)) {
      gobo_sample = 0u;
      const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
      return chord_inscatter_march_gobo(beam, medium, chord, ray, kNodes, kExtinction, row.gobo, as_it_is);
    }
    return gobo_inscatter(beam, medium, chord, ray, kExtinction);
  }
#endif
  if (kMethod == uint(FL_METHOD_MARCH)) {
    return vec3(chord_inscatter_march(beam, medium, chord, ray, kNodes, kExtinction));
  }
  if (kMeasured && row.measured != 0u) {
    return vec3(chord_inscatter_measured(beam, medium, chord, ray, kNodes, kExtinction));
  }
  if (kWide && beam.spread > kWideSpread) {
    return vec3(chord_inscatter_wide(beam, medium, chord, ray, kNodes > 3u ? 2u : 1u, kExtinction));
  }
  return vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
}

// Of the lit parts of a chord, or of its dark ones where those are subtracted.
vec3 parts_light(ShadowParts parts, BeamShape beam, BeamRow row, Medium medium, Chord whole, vec3 ray, uint nodes,
                 bool gobo, uint found, bool subtracts) {
  Chord chord = whole;
  vec3 value = vec3(0.0);
  // The parts, one after the other. Without shadows there is one.
  float at = 0.0;
  bool more = true;
  while (more) {
    float from = 0.0;
    float to = 1.0;
    more = false;
    if (kShadows) {
      float dark_from;
      float dark_to;
      more = shadow_parts_next(parts, at, dark_from, dark_to);
      if (subtracts && !more) break;
      from = subtracts ? dark_from : at;
      to = subtracts ? dark_to : min(dark_from, 1.0);
      at = dark_to;
      if (found != 0u) chord = chord_part(whole, from, to);
    }
    vec3 part = part_light(beam, row, medium, chord, ray, nodes, gobo);
    value += to > from ? part : vec3(0.0);
  }
  return value;
}

#ifdef FL_ROW_BEAMS
// That the eye is beside the beam was decided with the flag: a second test may decide otherwise by rounding.
vec3 chord_light(uint index, uint number, uint begin, BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray,
                 uint nodes, bool gobo, uint found, bool subtracts) {
  if (found == 0u) return vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
  return vec3(row_light(index, beam, medium, chord, ray, row_line_of(chord, ray), subtracts));
}
#else
// Of a chord: the mean over the points of the lens from which shadows are cast. Where light is computed at nodes alone,
// they only change the weights of the whole chord's nodes; else each point has its own parts.
const uint kTurns = kLensPoints > 1u ? kLensPoints + 1u : 1u;
vec3 chord_light(uint index, uint number, uint begin, BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray,
                 uint nodes, bool gobo, uint found, bool subtracts) {
  WalkShadows shadows_of;
  ShadowChord ends;
  if (found != 0u) {
    shadows_of = walk_shadows_of(number, begin);
    ends = shadow_chord(row, beam, chord, ray);
  }
  bool by_nodes = found != 0u && !gobo && kMethod == uint(FL_METHOD_GAUSS) &&
                  !(kMeasured && row.measured != 0u) && !(kWide && beam.spread > kWideSpread);
  if (by_nodes && has_series(row, ends.line)) {
    return vec3(row_light(index, beam, medium, chord, ray, ends.line, subtracts));
  }
  bool weighs = kLensPoints > 1u && by_nodes;
  ShadowWeights weights;
  if (kLensPoints > 1u) shadow_weights_clear(weights);
  vec3 value = vec3(0.0);
  uint at = 0u;
  float rest = 1.0;  // share of the points without shadows: of those that are not met
  for (uint turn = 0u; turn < kTurns; ++turn) {
    ShadowParts parts;
    shadow_parts_clear(parts);
    float share = rest;
    if (found != 0u && (kLensPoints == 1u || at < shadows_of.count)) {
      uint point;
      parts = chord_shadows(index, shadows_of, ends, at, point);
      share = point_share(point);
    }
    if (weighs) shadow_parts_weigh(parts, share, weights);
    else if (kLensPoints == 1u || share > 0.0) {
      vec3 here = parts_light(parts, beam, row, medium, chord, ray, nodes, gobo, found, subtracts);
      value += kLensPoints == 1u ? here : share * here;
    }
    rest -= share;
  }
  if (weighs) {
    if (!subtracts) shadow_weights_invert(weights);
    value = vec3(chord_inscatter_shaded(beam, medium, chord, ray, soft_nodes(nodes), weights, kExtinction));
  }
  return value;
}
#endif

// Adds the light of one beam to the thread's pixels. number: in the walk; begin: of its beams that are tested together.
void add_beam(uint index, uint number, uint begin, Medium medium, vec3 d[FL_ROWS], float t_max_m[FL_ROWS],
              inout vec3 total[FL_ROWS]) {
  BeamRow row = beams[index];
  BeamShape shape = beam_shape(row);
  shape.profile_power = drawn_profile(shape.profile_power);
  uint nodes = air_nodes(shape.profile_power);
  // The light of the beam's lit parts; of a beam that was added as a whole that of its dark parts, which is subtracted.
  uint found = kShadows ? subgroupBroadcastFirst(walk_found[number]) : 0u;
  bool subtracts = found != 0u && !is_left(index);
  // A rectangle's profile is the product of two.
  if (kRectangle && row.squeeze > 0.0) nodes = min(kNodes + 5u, 8u);
#ifdef FL_GOBO_BEAMS
  gobo_begin(index);
  bool gobo = has_gobo(row);
#else
  const bool gobo = false;
#endif
  bool plain = thin_is_plain(row, gobo);
  bool thin = thin_in_haze_applies(row);
  if (thin && plain) nodes = min(max(nodes, kNodes + 1u), 8u);  // (1 - rho^2)^3
  FL_EACH_ROW for (int i = 0; i < FL_ROWS; ++i) {
    vec3 eye = row.eye.xyz;
    vec3 ray = to_light(row, d[i]);
    BeamShape beam = shape;
    float gain = 1.0;
    if (thin) {
      gain = thin_in_haze(beam, row, eye, ray, dot(d[i], params.forward.xyz), t_max_m[i], plain);
    }
#ifdef FL_HAZE_FIELD
    haze_begin(vec2(tile_pixel(i)) + 0.5);
#endif
    Chord chord;
    bool seen = beam_chord(beam, eye, ray, ray_begin(d[i]), t_max_m[i], chord);
    if (kRectangle && row.squeeze > 0.0 && seen) seen = chord_in_rectangle(chord);
    if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u && seen) {
      for (int e = 0; e < 4; ++e) {
        seen = chord_cut(chord, blades[index].edge[e].xy, blades[index].edge[e].z) && seen;
      }
      chord_close(chord);
    }
    if (seen) {
      vec3 value = chord_light(index, number, begin, beam, row, medium, chord, ray, nodes, gobo, found, subtracts);
      if (subtracts) value = -value;
      if (!kShowsClasses) total[i] += row.j0.rgb * (gain * value);
      else if (!subtracts) total[i] += kClassPixel;
    }
  }
}

void main() {
  uint tile = gl_WorkGroupID.y * tiles_across() + gl_WorkGroupID.x;
#ifdef FL_ROW_BEAMS
  if (gl_LocalInvocationIndex == 0u) walk_leaves = 0u;
  barrier();
#else
  if (kRowBeams && tile_depths[tile].beams_left == 0u) return;
#endif
  Medium medium = Medium(params.anisotropy, params.position.w);
  vec3 d[FL_ROWS];
  float t_max_m[FL_ROWS];
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    bool inside = in_picture(pixel);
    d[i] = normalize(ray_through(vec2(pixel) + 0.5));
    t_max_m[i] = inside ? FL_FAR_M : 0.0;
    if ((kBoxes || kBodies) && inside) t_max_m[i] = imageLoad(radiance, pixel).a;  // the surface pass left it there
    if (kGloss && ray_begin(d[i]) >= FL_FAR_M) t_max_m[i] = 0.0;
    total[i] = vec3(0.0);
  }
  RectDepth depth;
  if (kShadows) depth = rect_depth(gl_WorkGroupID.xy, 1u);
  for (uint word = 0u; word < walk_words();) {
    word = tile_walk(word);
    if (walk_count == 0u) continue;
    if (kShadows) walk_number_pairs();
    for (uint begin = 0u; begin < FL_WALK_BEAMS;) {
      uint end = kShadows ? walk_test_shadows(begin, depth) : FL_WALK_BEAMS;
      FL_WALK_BEGIN(number, index)
        add_beam(index, number, begin, medium, d, t_max_m, total);
      FL_WALK_END
      begin = end;
    }
  }
#ifdef FL_ROW_BEAMS
  barrier();
  if (gl_LocalInvocationIndex == 0u) tile_depths[tile].beams_left = walk_leaves;
#endif
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    if (!in_picture(pixel)) continue;
    vec4 behind = kBoxes || kBodies || kTiles ? imageLoad(radiance, pixel) : vec4(0.0, 0.0, 0.0, 1.0);
    vec3 light = behind.rgb + light_scale() * total[i];
    // What is subtracted may be more than what was added, by their errors.
    if (kShadows && kTiles) light = max(light, vec3(0.0));
    imageStore(radiance, pixel, vec4(light, behind.a));  // the distance stays for depth of field
  }
}
