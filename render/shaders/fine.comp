#version 460
// Light in the haze, 32 x 32 pixels a workgroup: of the beams that the coarse pass has left, adds those that are smooth
// there, or smooth but for their rim or for what cuts them, as polynomials, and the coarse pass's polynomial. What is
// none of these stays in a mask for the beam pass. Lists keep the patch order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS writeonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/tile_node.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/tile_gobo.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#define FL_PICKS_ACCESS readonly
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_team.glsl"
#define FL_TILE_SURFACES
#include "render/shaders/lib/tile_class.glsl"
#include "render/shaders/lib/tile_sum.glsl"
#include "render/shaders/lib/tile_entry.glsl"
#include "render/shaders/lib/tile_pixels.glsl"
#include "render/shaders/lib/tile_record.glsl"
#include "render/shaders/lib/tile_surfaces.glsl"
#include "render/shaders/lib/tile_gobo_record.glsl"
#include "render/shaders/lib/tile_polynomial.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };

// What is left of a beam for the pixels: polynomials of x and y, from -1 to 1 over the hull, each 6 coefficients of 1,
// T_1(x), T_1(y), T_2(x), T_1(x) T_1(y), T_2(y). kRim: rho and h; kCut: rho, g_0, g_1, g_2, s_a and s_b, or what gives
// s_b at each pixel's own surface (surface_rows()) or what stands in the beam (gobo_rows()). Then the beam's colour,
// and p of its profile, kSurfaceRow or kGoboRow.
#define FL_RECORDS 128
#define FL_RECORD_ROWS 10
const float kSurfaceRow = 2.0;
const float kGoboRow = 3.0;
shared vec4 records[FL_RECORD_ROWS * FL_RECORDS];
// The kinds of records, a bit each for every block of 16 x 8 pixels: those that it can touch.
shared uint rim_bits[8 * FL_RECORDS / 32];
shared uint cut_bits[8 * FL_RECORDS / 32];
shared uint record_kinds[FL_RECORDS];
shared uint rest_bits[FL_GROUP_TILE];  // of the words of one list

// Puts the coefficients of this team's polynomial number `which` into the record.
void store_fit(uint slot, uint which, float f[kPer]) {
  FL_LANE_NODES(k) {
    uint at = coefficient_slot(node_place(k));
    uint i = 6u * which + at;
    if (at < 6u) records[uint(FL_RECORD_ROWS) * slot + (i >> 2)][i & 3u] = f[k];
  }
}
void store_color(uint slot, uint row_of_color, vec4 color) {
  if (team_lane() == 0u) records[uint(FL_RECORD_ROWS) * slot + row_of_color] = color;
}

vec4 record_row(uint slot, uint row) { return records[uint(FL_RECORD_ROWS) * slot + row]; }
// Column of polynomial number `which`, which begins in the middle of a row if it is odd.
vec3 column(uint slot, uint which, float x, float x2) {
  uint row = which + (which >> 1);
  vec4 first = record_row(slot, row);
  vec4 second = record_row(slot, row + 1u);
  bool odd = (which & 1u) != 0u;
  return record_column(odd ? vec4(first.zw, second.xy) : first, odd ? second.zw : second.xy, x, x2);
}

// A bit for each block of 16 x 8 pixels that |rho| < 1 can reach: blocks 2 q and 2 q + 1 are quarter q's.
uint record_blocks(uint slot) {
  const float half_px = FL_HULL * 0.5 * float(FL_FINE_PX);
  vec4 low = record_row(slot, 0u);
  vec2 high = record_row(slot, 1u).xy;
  uint bits = 0u;
  for (uint block = 0u; block < 8u; ++block) {
    uint quarter = block >> 1;
    vec2 at = vec2(float(quarter & 1u) * 16.0 - 8.0, float(quarter >> 1) * 16.0 + float(block & 1u) * 8.0 - 12.0);
    if (record_reaches(low, high, at / half_px, vec2(7.5, 3.5) / half_px)) bits |= 1u << block;
  }
  return bits;
}

// What the group's pixels show. It is read again where it is needed: registers decide how many groups run side by side.
shared RectDepth group_depth;
Rect group_rect() {
  const float kHalf = 0.5 * float(FL_FINE_PX);
  return Rect(vec2(gl_WorkGroupID.xy * uint(FL_FINE_PX)) + kHalf, FL_HULL * kHalf, group_depth);
}

void add_records(uint count) {
  const float half_px = FL_HULL * 0.5 * float(FL_FINE_PX);
  uint block = thread_number() / uint(FL_GROUP_TILE / 8);
  vec2 first_px = first_place();
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) total[i] = vec3(0.0);
  float x = first_px.x / half_px;
  float x2 = 2.0 * x * x - 1.0;
  vec3 y[FL_ROWS];
  float per_depth[FL_ROWS];  // 1 / depth, 1/m
  bool surfaces = kSolids && !group_depth.is_plane;
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    float at = (first_px.y + float(i)) / half_px;
    y[i] = vec3(1.0, at, 2.0 * at * at - 1.0);
    if (surfaces) per_depth[i] = pixel_per_depth(i);
  }
  const uint kWords = uint(FL_RECORDS / 32);
  bool any = false;
  for (uint w = 0u; 32u * w < count; ++w) {
    // The union over the subgroup, which may hold several blocks: a record is right in all of them.
    uint bits = subgroupOr(rim_bits[block * kWords + w]);
    any = any || bits != 0u;
    while (bits != 0u) {
      uint slot = 32u * w + uint(findLSB(bits));
      bits &= bits - 1u;
      vec3 rho = column(slot, 0u, x, x2);
      vec3 h = column(slot, 1u, x, x2);
      vec4 color = record_row(slot, 3u);
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        float light = record_rim(rho, h, y[i], color.w);
        total[i] += kShowsClasses ? (light > 0.0 ? kClassRecord : vec3(0.0)) : light * color.rgb;
      }
    }
    bits = subgroupOr(cut_bits[block * kWords + w]);
    any = any || bits != 0u;
    while (bits != 0u) {
      uint slot = 32u * w + uint(findLSB(bits));
      bits &= bits - 1u;
      vec4 color = record_row(slot, 9u);
      bool by_surface = kSolids && color.w == kSurfaceRow;
      bool by_gobo = kGoboTiles && color.w == kGoboRow;
      CutColumns columns;
      [[unroll]] for (uint i = 0u; i < 4u; ++i) columns.of[i] = column(slot, i, x, x2);
      PlaceRows rows;
      if (by_surface || by_gobo) {
        [[unroll]] for (uint i = 0u; i < 3u; ++i) rows.of[i] = record_row(slot, 6u + i);
        columns.of[4] = vec3(-4.0, 0.0, 0.0);
      } else {
        [[unroll]] for (uint i = 4u; i < 6u; ++i) columns.of[i] = column(slot, i, x, x2);
      }
      if (by_gobo) {
        [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
          vec3 light = record_gobo(rows, columns, x, y[i]);
          total[i] += kShowsClasses ? (brightest(light) > 0.0 ? kClassRecord : vec3(0.0)) : light * color.rgb;
        }
        continue;
      }
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        if (by_surface) columns.of[5] = vec3(surface_s(rows, vec3(x, y[i].y, per_depth[i])), 0.0, 0.0);
        float light = record_cut(columns, y[i]);
        total[i] += kShowsClasses ? (light > 0.0 ? kClassRecord : vec3(0.0)) : light * color.rgb;
      }
    }
  }
  if (any) add_to_pixels(total);
}

void main() {
  uint number = thread_number();
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_FINE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  uint fine_tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  float tolerance = coarse[supertile].tolerance;
  uint words = (counts.live_count + 31u) / 32u;
  if (!(tolerance > 0.0)) {
    for (uint w = number; w < words; w += uint(FL_GROUP_TILE)) {
      fine_masks[fine_tile * params.mask_words + w] = masks[supertile * params.mask_words + w];
    }
    return;
  }
  const uint kSide = uint(FL_FINE_PX / FL_TILE_PX);
  RectDepth depth = rect_depth(gl_WorkGroupID.xy * kSide, kSide);
  if (number == 0u) group_depth = depth;
  vec3 light_here[kPer];  // of smooth beams, at this lane's nodes
  FL_LANE_NODES(k) light_here[k] = vec3(0.0);
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    rest_bits[number] = 0u;
    barrier();
    for (uint at = 0u; at < list_count; at += uint(FL_GROUP_TILE)) {
      bool tries = false;
      uint id = 0u;
      TileGuess guess;
      if (at + number < list_count) {
        id = list_ids[at + number];
        BeamRow row = beams[id];
        vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_FINE_PX));
        vec2 high = min(low + float(FL_FINE_PX), vec2(float(params.width), float(params.height)));
        bool gobo = tile_knows_gobo(row);
        bool known = tile_knows(row) || gobo;
        if (gobo) row.eye.w = 1.0;  // the tables have the profile
        if (known) guess = tile_guess(row, group_rect());
        if (gobo) {
          bool whole = (guess.bits & kGuessWhole) != 0u && gobo_known(row);
          guess.bits = whole ? kGuessCut | kGuessRecord | kGuessGobo : 0u;
        }
        tries = known && guess.bits != 0u;
        if (tries) guess.middle = light_at_middle(row, group_rect());
        if (tries && has_shadows(supertile, id)) guess.bits |= kGuessShadowed;
        bool is_dark = known && guess.is_dark;
        if (!tries && !is_dark && beam_touches(row, beam_bound(row, 1.0), low, high)) {
          atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
        }
      }
      uint entries = add_entry(tries, id, guess).y;
      for (uint begin = 0u; begin < entries; begin += uint(FL_RECORDS)) {
        uint count = min(entries - begin, uint(FL_RECORDS));
        if (number < uint(FL_RECORDS / 4)) {
          rim_bits[number] = 0u;
          cut_bits[number] = 0u;
        }
        if (number < uint(FL_RECORDS)) record_kinds[number] = kDark;
        barrier();
        for (uint e = 0u; e < count; e += kTeams) {
          uint slot = e + team_number();
          TileEntry own = entry_at(begin + min(slot, count - 1u));
          bool is_beam = slot < count && own.bits != 0u;
          BeamRow row = beams[own.id];
          bool gobo = (own.bits & kGuessGobo) != 0u;
          bool surfaces = (own.bits & kGuessSurfaces) != 0u;
          if (gobo) row.eye.w = 1.0;
          bool whole = (own.bits & kGuessWhole) != 0u;
          float allowed = tolerance / brightest(row.j0.rgb);
          compute_nodes(row, group_rect(), whole, own.fit);
          uint kind = is_beam ? kGeneral : kDark;
          bool may = is_beam && (own.bits & kGuessSmooth) != 0u;
          if (subgroupAny(may)) {
            bool close = is_smooth(allowed, own.bits, own.middle);
            if (may && close) kind = kSmooth;
          }
          may = kind == kGeneral && whole;
          if (subgroupAny(may)) {
            float rho[kPer];
            float h[kPer];
            bool close = fit_rim(allowed, own.bits, own.middle, rho, h);
            if (may && close) {
              kind = kRim;
              store_fit(slot, 0u, rho);
              store_fit(slot, 1u, h);
            }
          }
          may = kind == kGeneral && !whole && (own.bits & kGuessRecord) != 0u;
          if (subgroupAny(may)) {
            CutFits fits;
            bool close = fit_cut(allowed, own.bits, own.middle, fits);
            if (may && close) {
              kind = kCut;
              [[unroll]] for (uint i = 0u; i < 6u; ++i) {
                if (i < 4u || !(surfaces || gobo)) store_fit(slot, i, fits.of[i]);
              }
              if ((surfaces || gobo) && team_lane() == 0u) {
                Rect rect = group_rect();
                PlaceRows rows = surface_rows(row, rect.middle, rect.half_px);
                if (gobo) rows = gobo_rows(beams[own.id], rows);
                [[unroll]] for (uint i = 0u; i < 3u; ++i) records[uint(FL_RECORD_ROWS) * slot + 6u + i] = rows.of[i];
              }
            }
          }
          if (kind == kSmooth) {
            FL_LANE_NODES(k) light_here[k] += kShowsClasses ? kClassSmooth : node_light[k] * row.j0.rgb;
          }
          if (kind == kRim) store_color(slot, 3u, vec4(row.j0.rgb, rim_power(drawn_profile(row.eye.w))));
          if (kind == kCut) store_color(slot, 9u, vec4(row.j0.rgb, gobo ? kGoboRow : surfaces ? kSurfaceRow : 1.0));
          if (team_lane() == 0u && (kind == kRim || kind == kCut)) record_kinds[slot] = kind;
          if (team_lane() == 0u && kind == kGeneral) atomicOr(rest_bits[own.id / 32u - first], 1u << (own.id & 31u));
        }
        barrier();
        if (number < count && record_kinds[number] != kDark) {
          uint blocks = record_blocks(number);
          bool is_rim = record_kinds[number] == kRim;
          while (blocks != 0u) {
            uint word = uint(findLSB(blocks)) * uint(FL_RECORDS / 32) + number / 32u;
            blocks &= blocks - 1u;
            if (is_rim) {
              atomicOr(rim_bits[word], 1u << (number & 31u));
            } else {
              atomicOr(cut_bits[word], 1u << (number & 31u));
            }
          }
        }
        barrier();
        add_records(count);
        barrier();
      }
      barrier();
    }
    if (first + number < from) fine_masks[fine_tile * params.mask_words + first + number] = rest_bits[number];
    barrier();
  }
  sum_light(light_here);
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) total[i] = vec3(0.0);
  add_group_light(total);
  vec3 light[16];
  [[unroll]] for (int k = 0; k < 16; ++k) {
    light[k] = vec3(coarse[supertile].light[3 * k], coarse[supertile].light[3 * k + 1],
                    coarse[supertile].light[3 * k + 2]);
  }
  const float kSuper = float(FL_SUPERTILE_PX);
  vec2 middle = (vec2(gl_WorkGroupID.xy) + 0.5) * float(FL_FINE_PX);
  add_light(light, (vec2(cell) + 0.5) * kSuper - middle, FL_HULL * 0.5 * kSuper, total);
  add_to_pixels(total);
}
