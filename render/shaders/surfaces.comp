#version 460
// Light on solid things, and how far away they are (alpha of the radiance image, for the beams that follow): albedo /
// pi times the illuminance of every beam that reaches the pixel's surface, dimmed by the haze between it and the eye.
// Lenses shine by themselves. A workgroup has 32 x 32 pixels. Beams that cover the plane in its middle smoothly are
// added as one polynomial; the others are computed pixel by pixel, in patch order (docs/decisions/0104).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
#include "render/shaders/lib/alike.glsl"

#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/surface_tile.glsl"
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_TILES) const bool kTiles = false;
#include "render/shaders/lib/surface_class.glsl"
#define FL_LIT_SHARE(beam, index, p, aside, fixture, lens_m) \
  ((beam).lit >= 0.0 ? (beam).lit : shaded_share(index, (beam).number, p, aside, fixture, lens_m))
float shaded_share(uint index, uint number, vec3 p, vec3 aside, uint fixture, float lens_radius_m);
#define FL_MAP_LIT(beam, index, row, p) lit_share(index, (beam).number, row, p)
float lit_share(uint index, uint number, BeamRow row, vec3 p);
#include "render/shaders/lib/surface_light.glsl"
#include "render/shaders/lib/bounce.glsl"
#include "render/shaders/shared/sheen.h"
#include "render/shaders/lib/sheen.glsl"

layout(local_size_x_id = FL_SPEC_GROUP) in;

layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform writeonly image2D radiance;

// Of FL_BATCH beams of the list: a bit for each that a block of pixels computes, and for each that is in the polynomial
// (only pixels off the plane compute it), covers the plane, or needs all of its row.
#define FL_BATCH 256u
const uint kBatchWords = FL_BATCH / 32u;
shared uint block_bits[FL_BLOCKS][kBatchWords];
shared uint smooth_bits[kBatchWords];
shared uint cover_bits[kBatchWords];
shared uint shaped_bits[kBatchWords];
shared bool has_smooth;  // some beam of the tile is in the polynomial
shared uint covering[FL_COVERS_MAX];  // their numbers in the batch
shared float plane_facing[FL_BATCH];  // plain_facing() of the tile's plane

// Of each beam of the batch, its shadows that reach something that the tile shows: their numbers stand from
// shaded_first on. FL_NONE: all of its shadows count, since there was no room.
#define FL_SHADED_MAX 1536u
shared uint shaded[FL_SHADED_MAX];
shared uint shaded_used;
shared uint shaded_first[FL_BATCH];
shared uint shaded_count[FL_BATCH];

vec3 illuminance_lx[kRows];  // of the thread's pixels
Sheen sheen[kRows];          // of those that are not matt
vec3 reflected[kRows];       // what these reflect of the light of beams, cd/m^2
shared bool has_sheen;       // the tile shows some
#include "render/shaders/lib/sheen_class.glsl"

bool has_others;  // the thread's block has pixels that do not show the plane

// Adds what pixels with sheen reflect of a plain beam. off_tile: only those that have not the tile's polynomials.
void add_plain_sheen(uint index, BeamRow row, Medium medium, float plane_facing, bool has_shade, bool off_tile) {
  vec3 lens_m = lens_place(row);
  for (int i = 0; i < int(kRows); ++i) {
    if (surface[i].sheen == 0u || (off_tile && in_tile_sheen[i])) continue;
    float facing = plane_facing;
    if (!on_plane[i]) facing = plain_facing(row, lens_m, surface[i].normal, dot(surface[i].normal, offset_m[i]));
    float light = plain_illuminance(row, medium, offset_m[i], facing);
    if (!(light > 0.0)) continue;
    vec3 p = row.eye.xyz + to_light(row, offset_m[i]);
    if (kMaps && has_shade) light *= map_lit(index, row, p);
    vec3 way = plain_way(row, p);
    float slant = length(way);
    reflected[i] += row.j0.rgb * light * sheen_share(sheen[i], surface[i], offset_m[i], way_on_stage(row, way / slant),
                                                     lens_angle(row, p.z * slant));
  }
}

// Adds a plain beam to the thread's pixels. off_plane: only to those that do not show the tile's plane. facing:
// plain_facing() of that plane. has_shade: its map may hide some of its light. off_tile: as add_plain_sheen() has it.
void add_plain_beam(uint index, Medium medium, bool off_plane, float plane_facing, bool has_shade, bool off_tile) {
  BeamRow row = beams[index];
  float facing[kRows];
  [[unroll]] for (int i = 0; i < int(kRows); ++i) facing[i] = plane_facing;
  if (kSheen && has_sheen) add_plain_sheen(index, row, medium, plane_facing, has_shade, off_tile);
  if (kSheen && off_plane && !has_others) return;
  if (has_others) {
    vec3 lens_m = lens_place(row);
    [[unroll]] for (int i = 0; i < int(kRows); ++i) {
      float own = plain_facing(row, lens_m, surface[i].normal, dot(surface[i].normal, offset_m[i]));
      facing[i] = on_plane[i] ? (off_plane ? 0.0 : plane_facing) : own;
    }
  }
  [[unroll]] for (int i = 0; i < int(kRows); ++i) {
    float light = plain_illuminance(row, medium, offset_m[i], facing[i]);
    if (kMaps && has_shade) light *= map_lit(index, row, row.eye.xyz + to_light(row, offset_m[i]));
    illuminance_lx[i] += row.j0.rgb * light;
  }
}

// lit_share_of() of a beam of the batch.
float shaded_share(uint index, uint number, vec3 p, vec3 aside, uint fixture, float lens_radius_m) {
  uint count = shaded_count[number];
  if (count == 0u) return 1.0;
  uint first = shaded_first[number];
  if (first == FL_NONE) return lit_share_of(index, p, aside, fixture, lens_radius_m);
  float rounding_m = shadow_rounding(p);
  if (kLensPoints > 1u) {
    LensShare lens = lens_share_begin();
    for (uint k = first; k < first + count; ++k) {
      lens_share_add(lens, shaded[k], shadow_share(shaded[k], p, aside, fixture, rounding_m, lens_radius_m));
    }
    lens_share_close(lens);
    return max(lens.lit, 0.0);
  }
  bool dark = false;
  for (uint k = 0u; k < count && !dark; ++k) dark = is_in_shadow(shaded[first + k], p, aside, fixture, rounding_m);
  return dark ? 0.0 : 1.0;
}

// The same for all pixels of the thread, with one point of the lens, of a beam that is not drawn wider.
void shaded_shares_alike(BeamRow row, uint number, out float lit[kRows]) {
  vec3 p[kRows];
  float rounding_m[kRows];
  uint fixture[kRows];
  [[unroll]] for (int i = 0; i < int(kRows); ++i) {
    p[i] = row.eye.xyz + to_light(row, offset_m[i]);
    rounding_m[i] = shadow_rounding(p[i]);
    fixture[i] = fixture_of(surface[i]);
    lit[i] = 1.0;
  }
  for (uint k = 0u; k < shaded_count[number]; ++k) {
    uint shadow = shaded[shaded_first[number] + k];
    uint rounds = shadow_rounds(shadow);
    uint outline = shadow_outline(shadow);
    float slack_m = max(shadows[shadow].slack_m, kShadowSlackM);
    bool dark[kRows];
    [[unroll]] for (int i = 0; i < int(kRows); ++i) dark[i] = shadows[shadow].fixture != fixture[i];
    for (uint round_of = 0u; round_of < rounds; ++round_of) {
      uint first = kShadowRound * round_of;
      FourPlanes four = planes_alike(shadow, uint[4](first, first + 1u, first + 2u, first + 3u));
      [[unroll]] for (uint j = 0u; j < 4u; ++j) {
        [[unroll]] for (int i = 0; i < int(kRows); ++i) {
          float within_m = first + j < outline ? 0.0 : slack_m + rounding_m[i];
          dark[i] = dark[i] && dot(four.of[j].xyz, p[i]) <= four.of[j].w - within_m;
        }
      }
    }
    [[unroll]] for (int i = 0; i < int(kRows); ++i) lit[i] = dark[i] ? 0.0 : lit[i];
  }
}

// Share of a beam's light that its shadow map lets through.
float lit_share(uint index, uint number, BeamRow row, vec3 p) {
  return shaded_count[number] > 0u ? map_lit(index, row, p) : 1.0;
}

// Adds a beam that is not plain, or that may be widened, or that has shadows in the tile. number: in the batch.
void add_shaped_beam(uint index, uint number, Medium medium, bool off_plane, bool off_tile) {
  BeamRow row = beams[index];
  gobo_begin(index);
  SurfaceBeam beam = surface_beam(row);
  beam.number = number;
  float lit[kRows];
  bool alike = kAlikeReads && kShadows && !kMaps && kLensPoints == 1u && !beam.thin && shaded_first[number] != FL_NONE;
  if (alike) shaded_shares_alike(row, number, lit);
  for (int i = 0; i < int(kRows); ++i) {
    if (alike) beam.lit = lit[i];
    bool is_added = off_plane && on_plane[i];  // by the polynomial
    bool reflects = kSheen && surface[i].sheen != 0u && !(off_tile && in_tile_sheen[i]);
    if (surface[i].kind == kNothing || (is_added && !reflects)) continue;
    vec2 rho;
    float r_m;
    vec3 light = light_and_place(beam, row, index, medium, surface[i], offset_m[i], rho, r_m);
    if (reflects && light != vec3(0.0)) {
      reflected[i] += light * sheen_share(sheen[i], surface[i], offset_m[i],
                                          way_on_stage(row, beam_direction(beam.shape, rho)), lens_angle(row, r_m));
    }
    if (!is_added) illuminance_lx[i] += light;
  }
}

// Moves the beams that reach a place of the tile to the front of the list. Returns their number.
uint keep_touching() {
  uint number = thread_number();
  uint listed = list_count;
  uint touching = 0u;
  for (uint at = 0u; at < listed; at += kGroup) {
    uint id = 0u;
    bool touches = false;
    if (at + number < listed) {
      id = list_ids[at + number];
      BeamRow row = beams[id];
      BeamShape bound = beam_bound(row, FL_THIN_ON_SURFACE);
      touches = cone_touches(row, bound, spheres[2u * FL_BLOCKS]) ||
                cone_touches(row, bound, spheres[2u * FL_BLOCKS + 1u]);
    }
    uint count;
    uint slot = ordered_slot(touches, count);
    if (touches) list_ids[touching + slot] = id;  // not past what has been read
    touching += count;
  }
  barrier();
  return touching;
}

// Whether a shadow can reach anything that the tile shows.
bool reaches_tile(uint shadow, BeamRow row, vec4 plane) {
  bool reaches = false;
  // A loop, since lavapipe runs both sides of a branch.
  for (uint i = 2u * FL_BLOCKS; i < 2u * FL_BLOCKS + 2u && !reaches; ++i) {
    bool on_plane_only = i == 2u * FL_BLOCKS && !(kRectangle && row.squeeze > 0.0) && beam_thin(row) == 0.0;
    vec3 normal = on_plane_only ? to_light(row, plane.xyz) : vec3(0.0);
    // The middle of the part of the plane that the sphere holds.
    vec3 from_eye = spheres[i].xyz;
    if (on_plane_only) from_eye -= plane.xyz * (dot(plane.xyz, from_eye) - plane.w);
    vec3 center = row.eye.xyz + to_light(row, from_eye);
    float radius_m = spheres[i].w * beam_stretch(row.squeeze);
    // A place beside the beam is brought back into it, where that is widened.
    if (beam_thin(row) > 0.0) {
      radius_m += FL_THIN_ON_SURFACE * beam_thin(row) * beam_stretch(row.squeeze) *
                  sqrt(1.0 + row.y_axis.w * row.y_axis.w) * (length(from_eye) + spheres[i].w);
    }
    if (spheres[i].w >= 0.0) {
      reaches = shadow_near(shadow, center, radius_m, normal, kLensPoints > 1u ? shadow_lens_m(row) : 0.0);
    }
  }
  return reaches;
}

// Lists the shadows of `count` beams of the list from `at` on. Subgroups take beams in turn, threads their shadows.
void list_shaded(uint at, uint count, vec4 plane) {
  if (kMaps) {
    for (uint b = thread_number(); b < count; b += kGroup) {
      uint beam = list_ids[at + b];
      bool reaches = false;
      for (uint i = 2u * FL_BLOCKS; i < 2u * FL_BLOCKS + 2u && !reaches && shadow_lists[beam].count > 0u; ++i) {
        BeamRow row = beams[beam];
        vec3 center = row.eye.xyz + to_light(row, spheres[i].xyz);
        float radius_m = spheres[i].w * beam_stretch(row.squeeze);
        if (spheres[i].w >= 0.0) reaches = map_hides_in_sphere(beam, row, center, radius_m);
      }
      shaded_count[b] = reaches ? 1u : 0u;
    }
    return;
  }
  if (thread_number() == 0u) shaded_used = 0u;
  barrier();
  for (uint b = gl_SubgroupID; b < count; b += gl_NumSubgroups) {
    uint beam = list_ids[at + b];
    ShadowListRow list = shadow_lists[beam];
    uint total = 0u;
    uint first = FL_NONE;
    uint bits = 0u;  // of this thread's shadows, one a round
    uint rounds = (list.count + gl_SubgroupSize - 1u) / gl_SubgroupSize;
    if (rounds > 32u) {
      total = list.count;
    } else if (rounds > 0u) {
      BeamRow row = beams[beam];
      for (uint round_of = 0u; round_of < rounds; ++round_of) {
        uint own = round_of * gl_SubgroupSize + gl_SubgroupInvocationID;
        if (own < list.count && reaches_tile(list.first + own, row, plane)) bits |= 1u << round_of;
      }
      total = subgroupAdd(bitCount(bits));
      if (total > 0u) {
        if (subgroupElect()) first = atomicAdd(shaded_used, total);
        first = subgroupBroadcastFirst(first);
        if (first + total > FL_SHADED_MAX) first = FL_NONE;
      }
      uint place = first;
      for (uint round_of = 0u; first != FL_NONE && round_of < rounds; ++round_of) {
        bool is_one = (bits >> round_of & 1u) != 0u;
        uvec4 ones = subgroupBallot(is_one);
        if (is_one) {
          shaded[place + subgroupBallotExclusiveBitCount(ones)] =
              list.first + round_of * gl_SubgroupSize + gl_SubgroupInvocationID;
        }
        place += subgroupBallotBitCount(ones);
      }
    }
    if (subgroupElect()) {
      shaded_first[b] = first;
      shaded_count[b] = total;
    }
  }
}

// Fills the bits of `count` beams of the list from `at` on. sum: as add_smooth_beams() adds to it.
void classify(uint at, uint count, Medium medium, vec4 plane, inout float sum) {
  uint number = thread_number();
  if (number < FL_BLOCKS * kBatchWords) block_bits[number / kBatchWords][number % kBatchWords] = 0u;
  if (number < kBatchWords) {
    smooth_bits[number] = 0u;
    if (kSheen) sheen_bits[number] = 0u;
    shaped_bits[number] = 0u;
    uint left = count - min(count, number * 32u);
    cover_bits[number] = left >= 32u ? ~0u : (1u << left) - 1u;
  }
  if (kShadows) list_shaded(at, count, plane);
  barrier();
  // Each thread has a beam and a quarter of the tile: two blocks and a corner.
  const uint kCorner[4] = uint[4](0u, 3u, 12u, 15u);
  bool has_nodes = kTiles && plane.xyz != vec3(0.0);
  for (uint e = number; e < count * 4u; e += kGroup) {
    uint b = e >> 2;
    uint quarter = e & 3u;
    uint word = b >> 5;
    uint bit = 1u << (b & 31u);
    BeamRow row = beams[list_ids[at + b]];
    BeamShape bound = beam_bound(row, FL_THIN_ON_SURFACE);
    bool plain = is_plain(row);
    bool is_shaped = !plain || beam_thin(row) > 0.0;
    bool has_shade = kShadows && shaded_count[b] > 0u;
    float facing = plain_facing(row, lens_place(row), plane.xyz, plane.w);
    for (uint block = 2u * quarter; block < 2u * quarter + 2u; ++block) {
      bool touches = cone_touches(row, bound, spheres[2u * block]) && (facing > 0.0 || is_shaped);
      touches = touches || cone_touches_others(row, bound, block);
      if (touches) atomicOr(block_bits[block][word], bit);
    }
    if (quarter == 0u) {
      plane_facing[b] = facing;
      if (is_shaped || (has_shade && !kMaps)) atomicOr(shaped_bits[word], bit);
    }
    bool lights = has_nodes && plain && !has_shade && light_at_node(row, kCorner[quarter], medium, facing) > 0.0;
    if (!lights) atomicAnd(cover_bits[word], ~bit);
  }
  barrier();
  if (!has_nodes) return;
  uint covers = 0u;
  for (uint w = 0u; w < kBatchWords; ++w) covers += bitCount(cover_bits[w]);
  if (covers <= FL_FEW_COVERS) return;
  for (uint base = 0u; base < covers; base += FL_COVERS_MAX) {
    // In patch order.
    for (uint b = number; b < count; b += kGroup) {
      uint slot = bitCount(cover_bits[b >> 5] & ((1u << (b & 31u)) - 1u));
      for (uint w = 0u; w < b >> 5; ++w) slot += bitCount(cover_bits[w]);
      bool is_one = (cover_bits[b >> 5] >> (b & 31u) & 1u) != 0u;
      if (is_one && slot - base < FL_COVERS_MAX) covering[slot - base] = b;
    }
    barrier();
    uint here = min(covers - base, FL_COVERS_MAX);
    for (uint e = number; e < here * FL_NODES; e += kGroup) {
      uint b = covering[e / FL_NODES];
      node_light[e] = light_at_node(beams[list_ids[at + b]], e % FL_NODES, medium, plane_facing[b]);
    }
    barrier();
    uint own = number < here ? covering[number] : 0u;
    vec3 color = number < here ? beams[list_ids[at + own]].j0.rgb : vec3(0.0);
    if (add_smooth_beams(here, color, sum)) {
      atomicOr(smooth_bits[own >> 5], 1u << (own & 31u));
      has_smooth = true;
    }
    barrier();
    if (kSheen && plane_sheen) classify_sheen(at, here, medium, plane.xyz);
  }
}

// Adds the polynomial in part_sums to the pixels on the plane. from_px: of the thread's first pixel, from the middle.
void add_polynomial(vec2 from_px) {
  vec4 tx = chebyshev(from_px.x / kHalfHullPx);
  vec3 rows[4];
  [[unroll]] for (int n = 0; n < 4; ++n) {
    rows[n] = vec3(0.0);
    [[unroll]] for (int m = 0; m < 4; ++m) {
      int k = 3 * (4 * n + m);
      rows[n] += tx[m] * vec3(part_sums[k], part_sums[k + 1], part_sums[k + 2]);
    }
  }
  [[unroll]] for (int i = 0; i < int(kRows); ++i) {
    vec4 ty = chebyshev((from_px.y + float(i)) / kHalfHullPx);
    if (on_plane[i]) illuminance_lx[i] += rows[0] * ty.x + rows[1] * ty.y + rows[2] * ty.z + rows[3] * ty.w;
  }
}

// Fills what is known of pixels with sheen before any beam.
void begin_sheen(uvec2 pixel_low) {
  bool any = false;
  for (int i = 0; i < int(kRows); ++i) {
    reflected[i] = vec3(0.0);
    if (surface[i].sheen == 0u) continue;
    sheen[i] = surface_sheen(ivec2(pixel_low) + ivec2(0, i), surface[i], albedo_of(surface[i]));
    any = true;
  }
  barrier();
  if (any) has_sheen = true;  // a barrier follows before it is read
}

void main() {
  Medium medium = Medium(params.anisotropy, params.position.w);
  uvec2 size = uvec2(params.width, params.height);
  uvec2 tile_low = gl_WorkGroupID.xy * uint(FL_SURFACE_PX);
  uvec2 pixel_low = tile_low + first_pixel();
  for (int i = 0; i < int(kRows); ++i) {
    uvec2 pixel = pixel_low + uvec2(0, i);
    vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
    // Threads past the edge of the picture look at its last pixel.
    surface[i] = surface_at(ivec2(min(pixel, size - 1u)), d);
    if (any(greaterThanEqual(pixel, size))) surface[i].kind = kNothing;
    offset_m[i] = d * surface[i].t_m;
    illuminance_lx[i] = vec3(params.ambient_lx);
  }
  if (thread_number() == 0u) {
    has_smooth = false;
    if (kSheen) has_sheen = false;
  }
  if (kSheen) begin_sheen(pixel_low);
  uvec2 middle_px = min(tile_low + uint(FL_SURFACE_PX / 2), size - 1u);
  find_shapes(pixel_low, middle_px);
  if (spheres[2u * FL_BLOCKS + 1u].w >= 0.0) find_slices();
  if (kSheen) find_tile_sheen(pixel_low, middle_px);
  vec4 plane = tile_plane;
  vec2 middle = vec2(tile_low) + 0.5 * float(FL_SURFACE_PX);
  if (kTiles) place_nodes(plane, middle);

  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_SURFACE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  bool is_empty = spheres[2u * FL_BLOCKS].w < 0.0 && spheres[2u * FL_BLOCKS + 1u].w < 0.0;
  uint words = is_empty ? 0u : (counts.live_count + 31u) / 32u;
  uint block = own_block();
  has_others = spheres[2u * block + 1u].w >= 0.0;
  float smooth_sum = 0.0;  // of thread k < 48: as add_smooth_beams() adds to it
  for (uint from = 0u; from < words;) {
    from = list_fill(supertile, from);
    uint touching = keep_touching();
    for (uint at = 0u; at < touching; at += FL_BATCH) {
      uint here = min(touching - at, FL_BATCH);
      classify(at, here, medium, plane, smooth_sum);
      // Words without beams take time on lavapipe: it runs the body of a loop once if the loop has no round.
      for (uint w = 0u; 32u * w < here; ++w) {
        uint rest = block_bits[block][w];
        // Compilers then keep the threads of a subgroup together through the loop.
        if (gl_SubgroupSize <= kBlockThreads) rest = subgroupBroadcastFirst(rest);
        uint smooth_ones = smooth_bits[w];
        uint sheen_ones = kSheen ? sheen_bits[w] : 0u;
        if (!has_others && !(kSheen && plane_sheen)) rest &= ~smooth_ones;
        if (kSheen && !has_others && plane_sheen && !plane_mixed) rest &= ~(smooth_ones & sheen_ones);
        // Two loops, since lavapipe runs both sides of a branch.
        for (uint bits = rest & ~shaped_bits[w]; bits != 0u; bits &= bits - 1u) {
          uint b = uint(findLSB(bits));
          add_plain_beam(list_ids[at + w * 32u + b], medium, (smooth_ones >> b & 1u) != 0u, plane_facing[w * 32u + b],
                         kMaps && shaded_count[w * 32u + b] > 0u, (sheen_ones >> b & 1u) != 0u);
        }
        for (uint bits = rest & shaped_bits[w]; bits != 0u; bits &= bits - 1u) {
          uint b = uint(findLSB(bits));
          uint own = w * 32u + b;
          add_shaped_beam(list_ids[at + own], own, medium, (smooth_ones >> b & 1u) != 0u,
                          (sheen_ones >> b & 1u) != 0u);
        }
      }
      barrier();  // the bits and the list have been read
    }
  }
  if (has_smooth) {
    fit_sums(smooth_sum);
    add_polynomial(vec2(pixel_low) + 0.5 - middle);
  }
  if (kSheen && has_sheen_sums) add_sheen_sums(vec2(pixel_low) + 0.5 - middle);

  for (int i = 0; i < int(kRows); ++i) {
    uvec2 pixel = pixel_low + uvec2(0, i);
    if (any(greaterThanEqual(pixel, size))) continue;
    vec3 color = vec3(0.0);
    uint which = surface[i].which;
    // Of surfaces with sheen the light of beams is in `reflected`.
    bool shows_sheen = kSheen && surface[i].sheen != 0u && kView != uint(FL_VIEW_LUX);
    if (shows_sheen) illuminance_lx[i] = vec3(params.ambient_lx);
    if (kBounce) illuminance_lx[i] += bounced_lx(surface[i], params.position.xyz + offset_m[i]);
    if (surface[i].kind == kBox) {
      float form = work_light(surface[i].normal, offset_m[i]);
      color = boxes[which].albedo.rgb / kPi * (illuminance_lx[i] + params.work_lx * form);
    } else if (surface[i].kind == kObject) {
      vec3 albedo = vec3((uvec3(which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
      float form = work_light(surface[i].normal, offset_m[i]);
      color = albedo / kPi * (illuminance_lx[i] + params.ambient_lx * (form - 1.0) + params.work_lx * form);
    } else if (surface[i].kind == kBody) {
      vec3 ray = normalize(offset_m[i]);
      float form = work_light(surface[i].normal, offset_m[i]);
      color = vec3(kBodyAlbedo / kPi) *
              (illuminance_lx[i] + params.ambient_lx * (form - 1.0) + params.work_lx * form);
      if ((which & uint(FL_PART_LENS)) != 0u) {
        color += lens_radiance(which >> 3, surface[i].t_m, ray, surface[i].normal);
      }
    }
    if (shows_sheen) color += reflected[i];
    if (kExtinction) color *= exp(-medium.extinction_per_m * surface[i].t_m);
    if (kView == uint(FL_VIEW_LUX)) color = surface[i].kind != kNothing ? illuminance_lx[i] : vec3(0.0);
    if (kShowsClasses) color = vec3(0.0);
    imageStore(radiance, ivec2(pixel), vec4(color, surface[i].t_m));
  }
}
