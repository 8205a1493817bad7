// The shadows in a beam: which of them can reach a rectangle of pixels, and whether a place is in one. After beam.h,
// shadow.h and tile_test.glsl.
layout(constant_id = FL_SPEC_SHADOWS) const bool kShadows = false;
// Whether shadow maps stand for the shadows (shadow_map.glsl): then there are no rows of them, and no lists.
layout(constant_id = FL_SPEC_MAP_PX) const uint kMapPx = 0u;
const bool kMaps = kMapPx > 0u;
#include "render/shaders/lib/shadow_map_words.glsl"
#include "render/shaders/lib/shadow_row_line.glsl"
// Points of the lens from which shadows are cast (shadow.h).
layout(constant_id = FL_SPEC_PENUMBRA) const uint kLensPoints = 1u;
const uint kAllPoints = (1u << kLensPoints) - 1u;
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) readonly buffer ShadowListsBuffer {
  ShadowListRow shadow_lists[];
};
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) readonly buffer ShadowsBuffer { ShadowRow shadows[]; };
#include "render/shaders/lib/shadow_row.glsl"

uint shadow_point(uint shadow) { return kLensPoints > 1u ? shadows[shadow].count >> FL_SHADOW_POINT_SHIFT : 0u; }

// Planes are read four at a time, since Mesa ends the loops of a thread after 65,535 rounds. Everything is inside those
// that fill up the last round.
const uint kShadowRound = 4u;
uint shadow_rounds(uint shadow) { return (shadow_planes(shadow) + kShadowRound - 1u) / kShadowRound; }

// A shadow in a rectangle of pixels: its number, and a bit for each of its planes that has some of the rectangle on
// its outer side. Everything there is inside the others.
const uint kAllPlanes = (1u << FL_SHADOW_PLANE_BITS) - 1u;
uint shadow_entry(uint shadow, uint planes) { return shadow << FL_SHADOW_PLANE_BITS | planes; }
uint entry_shadow(uint entry) { return entry >> FL_SHADOW_PLANE_BITS; }
uint entry_planes(uint entry) { return entry & kAllPlanes; }
// All planes of a shadow.
uint shadow_whole(uint shadow) { return shadow_entry(shadow, (1u << shadow_planes(shadow)) - 1u); }
// Rounds of a loop over planes; next_plane() gives the last one again where no other is left.
uint plane_rounds(uint planes) { return (uint(bitCount(planes)) + kShadowRound - 1u) / kShadowRound; }
// The point of the lens, as a bit.
uint entry_point(uint entry) { return 1u << shadow_point(entry_shadow(entry)); }
// That bit if all of the rectangle is in the shadow.
uint entry_darkens(uint entry) { return entry != FL_NONE && entry_planes(entry) == 0u ? entry_point(entry) : 0u; }
float point_share(uint point) { return kLensPoints == 7u ? (point == 1u ? 0.25 : 0.125) : 1.0 / float(kLensPoints); }
uint next_plane(inout uint planes) {
  uint own = uint(findLSB(planes));
  uint rest = planes & (planes - 1u);
  planes = rest != 0u ? rest : planes;
  return own;
}

// Light that has passed this much of a body, m, is not hidden by it on a surface: else faces would hide themselves.
const float kShadowSlackM = 1e-4;
// The same in the air, for whole rectangles: their planes are exact to 2e-5 of the depth (tile_depth.glsl).
const float kShadowAirSlackM = 1e-3;

// What the pixels of a rectangle show of a beam lies between two depths, in the pyramid through the rectangle's
// corners.
struct ShadowCell {
  vec3 eye;        // in the beam's light space, m
  vec3 corner[4];  // rays of depth 1 there
  float near_m;    // depths
  float far_m;     // below near_m: nothing of the beam is there
  float end_m[4];  // of the corners: a plane that all pixels show; far_m where they show none
  vec2 z_m;        // what is visible of the beam lies between these places of its axis
  vec2 w_m;        // its radii there
  vec2 radius;     // of the beam: at the lens, m, and its growth a metre
  float lens_m;    // radius of the lens from whose points shadows are cast
  bool is_thin;    // places are brought back into the beam (thin.glsl): the corners do not bound them
};
// When the ends of the cell are known.
void shadow_cell_close(inout ShadowCell cell, BeamRow row) {
  vec2 z = vec2(FL_FAR_M, 0.0);
  [[unroll]] for (int c = 0; c < 4; ++c) {
    vec3 at = cell.eye.z + cell.corner[c].z * vec3(cell.near_m, cell.far_m, min(cell.near_m, cell.end_m[c]));
    z = vec2(min(z.x, min(at.x, min(at.y, at.z))), max(z.y, max(at.x, max(at.y, at.z))));
  }
  cell.z_m = clamp(z, 0.0, row.axis.w);
  cell.w_m = row.x_axis.w + row.y_axis.w * cell.z_m;
  cell.is_thin = beam_thin(row) > 0.0;
}

// Keeps the depths at which a corner can be inside: at + depth way[c] <= 0.
void shadow_cell_keep(inout ShadowCell cell, float at, float way[4]) {
  float enter = FL_FAR_M;
  float leave = 0.0;
  [[unroll]] for (int c = 0; c < 4; ++c) {
    float crossing = way[c] != 0.0 ? -at / way[c] : FL_FAR_M;
    enter = way[c] < 0.0 ? min(enter, crossing) : enter;
    leave = max(leave, way[c] > 0.0 ? crossing : FL_FAR_M);
  }
  if (at > 0.0) cell.near_m = max(cell.near_m, enter);
  else cell.far_m = min(cell.far_m, leave);
}

// low, high: corners of the rectangle in pixels. far_m: no pixel shows anything beyond this depth.
ShadowCell shadow_cell(BeamRow row, vec2 low, vec2 high, float far_m) {
  ShadowCell cell;
  cell.eye = row.eye.xyz;
  cell.corner[0] = to_light(row, ray_through(vec2(low.x, low.y)));
  cell.corner[1] = to_light(row, ray_through(vec2(high.x, low.y)));
  cell.corner[2] = to_light(row, ray_through(vec2(high.x, high.y)));
  cell.corner[3] = to_light(row, ray_through(vec2(low.x, high.y)));
  cell.near_m = 0.0;
  cell.far_m = far_m;
  cell.radius = vec2(row.x_axis.w, row.y_axis.w);
  cell.lens_m = kLensPoints > 1u ? shadow_lens_m(row) : 0.0;
  BeamShape beam = beam_bound(row, 1.0);
  float way[4];
  // In front of the lens, and within the range.
  [[unroll]] for (int c = 0; c < 4; ++c) way[c] = -cell.corner[c].z;
  shadow_cell_keep(cell, -cell.eye.z, way);
  [[unroll]] for (int c = 0; c < 4; ++c) way[c] = cell.corner[c].z;
  shadow_cell_keep(cell, cell.eye.z - beam.range_m, way);
  // Within the disc, along the line that the middle's ray draws in the gobo plane and across it.
  vec3 middle = 0.25 * (cell.corner[0] + cell.corner[1] + cell.corner[2] + cell.corner[3]);
  float w = beam.lens_radius_m + beam.spread * cell.eye.z;
  vec2 v = middle.xy * w - cell.eye.xy * (beam.spread * middle.z);
  vec2 along = dot(v, v) > 1e-30 ? v * inversesqrt(dot(v, v)) : vec2(1.0, 0.0);
  [[unroll]] for (int side = 0; side < 2; ++side) {
    float sign_of = side == 0 ? 1.0 : -1.0;
    [[unroll]] for (int c = 0; c < 4; ++c) {
      way[c] = sign_of * dot(along, cell.corner[c].xy) - beam.spread * cell.corner[c].z;
    }
    shadow_cell_keep(cell, sign_of * dot(along, cell.eye.xy) - w, way);
  }
  // Nothing is farther than the end of the range, which a float can hold.
  cell.far_m = min(cell.far_m, 1e7);
  [[unroll]] for (int c = 0; c < 4; ++c) cell.end_m[c] = cell.far_m;
  return cell;
}
// All pixels show one plane, at these depths in the corners. The pyramid up to the plane and that up to far_m both hold
// what is visible of the beam; a hull of nearer ends than the plane's would not.
void shadow_cell_end(inout ShadowCell cell, vec4 plane_m) {
  float most = max(max(plane_m.x, plane_m.y), max(plane_m.z, plane_m.w));
  cell.far_m = min(cell.far_m, most);
  [[unroll]] for (int c = 0; c < 4; ++c) cell.end_m[c] = most < 1e7 ? plane_m[c] : cell.far_m;
}

// How far from a plane of the outline, along the lens, half shadows reach up to a place of the axis.
float shadow_soft_m(uint shadow, float z_m, float lens_m) {
  float begin_m = max(shadows[shadow].planes[FL_SHADOW_PLANES - 1].w - 1.0, 1e-3);  // shadows.comp
  return lens_part_radius(kLensPoints) * lens_m * max(z_m / begin_m - 1.0, 0.0);
}

// The entry of a shadow in a cell, from that in a larger one. FL_NONE: it does not reach the cell. Without planes: all
// of the cell is in it.
uint shadow_in_cell(uint entry, ShadowCell cell) {
  uint shadow = entry_shadow(entry);
  uint planes = entry_planes(entry);
  uint rounds = plane_rounds(planes);
  bool outside = cell.near_m > cell.far_m || shadow_is_hidden(shadow);
  uint crossing = 0u;
  uint outline = shadow_outline(shadow);
  float slack_m = max(shadows[shadow].slack_m, kShadowAirSlackM);
  float soft_m = kLensPoints > 1u ? shadow_soft_m(shadow, cell.z_m.y, cell.lens_m) : 0.0;
  for (uint round_of = 0u; round_of < rounds && !outside; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = next_plane(planes);
      vec4 plane = shadows[shadow].planes[own];
      float at = dot(plane.xyz, cell.eye) - plane.w;
      vec2 least = vec2(FL_FAR_M);  // up to far_m, and up to the plane
      float most = -FL_FAR_M;
      [[unroll]] for (int c = 0; c < 4; ++c) {
        float way = dot(plane.xyz, cell.corner[c]);
        float near = at + way * cell.near_m;
        float far = at + way * cell.far_m;
        // Where the plane is nearer than the beam, what is between them is outside of the beam.
        float before = at + way * min(cell.near_m, cell.end_m[c]);
        least = min(least, min(vec2(near, before), vec2(far, at + way * cell.end_m[c])));
        most = max(most, max(near, far));
      }
      float soft = kLensPoints > 1u && own < outline ? soft_m * length(plane.xy) : 0.0;
      float slack = own < outline ? soft : -slack_m;
      outside = outside || (!cell.is_thin && max(least.x, least.y) > slack);
      // The same for the beam between two places of its axis.
      vec2 on_axis = plane.z * cell.z_m - plane.w;
      vec2 reach = length(plane.xy) * cell.w_m;
      vec2 nearest = on_axis - reach;
      vec2 farthest = on_axis + reach;
      outside = outside || min(nearest.x, nearest.y) > slack;
      bool inside = (!cell.is_thin && most <= -soft) || max(farthest.x, farthest.y) <= -soft;
      if (!inside) crossing |= 1u << own;
    }
  }
  return outside ? FL_NONE : shadow_entry(shadow, crossing);
}

// What float may lose of a place in light space, m.
float shadow_rounding(vec3 p) { return 1e-6 * length(p) + 1e-7 * length(params.position.xyz); }

// Whether a shadow can reach a sphere, or the part of a plane that is in it; light space, m. normal: of the plane,
// unit; 0: all of the sphere. Of a rectangular beam the radius is stretched.
bool shadow_near(uint shadow, vec3 center, float radius_m, vec3 normal, float lens_radius_m) {
  uint rounds = shadow_rounds(shadow);
  uint outline = shadow_outline(shadow);
  float slack_m = max(shadows[shadow].slack_m, kShadowSlackM) + shadow_rounding(center);
  bool may = true;
  // Half shadows are outside the planes.
  float soft_m = kLensPoints > 1u ? shadow_soft_m(shadow, center.z + radius_m, lens_radius_m) : 0.0;
  for (uint round_of = 0u; round_of < rounds && may; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = kShadowRound * round_of + k;
      vec4 plane = shadows[shadow].planes[own];
      float reach_m = radius_m * length(plane.xyz - normal * dot(plane.xyz, normal));
      if (kLensPoints > 1u && own < outline) reach_m += soft_m * length(plane.xy);
      may = may && dot(plane.xyz, center) - plane.w <= reach_m - (own < outline ? 0.0 : slack_m);
    }
  }
  return may;
}

// Whether a place is inside the planes of one round. aside: the same place within the beam, where it is drawn wider
// than it is; else p.
bool shadow_holds(uint shadow, uint round_of, uint outline, vec3 p, vec3 aside, float slack_m) {
  bool inside = true;
  [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
    uint own = kShadowRound * round_of + k;
    vec4 plane = shadows[shadow].planes[own];
    inside = inside && (own < outline ? dot(plane.xyz, aside) <= plane.w : dot(plane.xyz, p) <= plane.w - slack_m);
  }
  return inside;
}

// Whether a place on a surface is in one of a beam's shadows; p, aside: light space, m. fixture: what stands for its
// body does not hide it. The first round has no loop of its own, since most shadows end there.
const uint kNoFixture = FL_NONE - 1u;  // and FL_NONE is what belongs to none
bool is_in_shadow(uint shadow, vec3 p, vec3 aside, uint fixture, float rounding_m) {
  uint rounds = shadow_rounds(shadow);
  uint outline = shadow_outline(shadow);
  float slack_m = max(shadows[shadow].slack_m, kShadowSlackM) + rounding_m;
  bool dark = shadows[shadow].fixture != fixture && shadow_holds(shadow, 0u, outline, p, aside, slack_m);
  for (uint next = 1u; next < rounds && dark; ++next) dark = shadow_holds(shadow, next, outline, p, aside, slack_m);
  return dark;
}

// The same with several points of the lens: the share of the part of the lens around the shadow's point that it hides.
float shadow_share(uint shadow, vec3 p, vec3 aside, uint fixture, float rounding_m, float lens_radius_m) {
  if (shadows[shadow].fixture == fixture) return 0.0;
  uint rounds = shadow_rounds(shadow);
  uint outline = shadow_outline(shadow);
  float slack_m = max(shadows[shadow].slack_m, kShadowSlackM) + rounding_m;
  vec3 point = lens_point(kLensPoints, shadow_point(shadow), lens_radius_m);
  bool behind = true;
  float at = 0.0;
  for (uint round_of = outline / kShadowRound; round_of < rounds && behind; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = kShadowRound * round_of + k;
      vec4 plane = shadows[shadow].planes[own];
      float here = dot(plane.xyz, p) - plane.w;
      behind = behind && (own < outline || here <= -slack_m);
      at = own < outline ? at : max(at, shadow_front_at(dot(plane.xyz, point) - plane.w, here));
    }
  }
  float share = behind ? 1.0 : 0.0;
  float radius_m = lens_part_radius(kLensPoints) * lens_radius_m;
  for (uint round_of = 0u; kShadowRound * round_of < outline && share > 0.0; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = kShadowRound * round_of + k;
      vec4 plane = shadows[shadow].planes[own];
      float edge = shadow_edge_share(dot(plane.xyz, aside) - plane.w, length(plane.xy), radius_m, at);
      share = own < outline ? min(share, edge) : share;
    }
  }
  return share;
}
// What several shadows hide of a lens. Those from one point follow each other. Where two bodies touch, their shares add
// up; where one stands behind the other's edge, less is hidden than the sum.
struct LensShare {
  float lit;
  uint point;  // whose shadows are added up
  float dark;  // of the part around it
};
LensShare lens_share_begin() { return LensShare(1.0, 0u, 0.0); }
void lens_share_close(inout LensShare lens) {
  lens.lit -= point_share(1u << lens.point) * min(lens.dark, 1.0);
  lens.dark = 0.0;
}
void lens_share_add(inout LensShare lens, uint shadow, float share) {
  uint point = shadow_point(shadow);
  if (point != lens.point) lens_share_close(lens);
  lens.point = point;
  lens.dark += share;
}

// The share of the lens that lights a place; of one point 0 or 1.
float lit_share_of(uint beam, vec3 p, vec3 aside, uint fixture, float lens_radius_m) {
  uint first = shadow_lists[beam].first;
  uint count = shadow_lists[beam].count;
  float rounding_m = shadow_rounding(p);
  if (kLensPoints > 1u) {
    LensShare lens = lens_share_begin();
    for (uint s = first; s < first + count; ++s) {
      lens_share_add(lens, s, shadow_share(s, p, aside, fixture, rounding_m, lens_radius_m));
    }
    lens_share_close(lens);
    return max(lens.lit, 0.0);
  }
  bool dark = false;
  for (uint s = first; s < first + count && !dark; ++s) dark = is_in_shadow(s, p, aside, fixture, rounding_m);
  return dark ? 0.0 : 1.0;
}

// The part of a chord that is in one shadow. h over w is linear in its measure: from, to are (p, -1) / w at its ends.
struct ShadowChord {
  vec4 from;
  vec4 to;
  float lens_m;  // radius of the lens from whose points shadows are cast
  RowLine line;  // with kMapRows
};
// beam: as it is drawn; where that is wider than it is, its places across are brought back into the beam.
ShadowChord shadow_chord(BeamRow row, BeamShape beam, Chord chord, vec3 ray) {
  float w = 0.5 * (chord.w_from + chord.w_to);
  // In the map of the beam as it is drawn they stay where they are.
  float narrow = kMaps ? 1.0 : (w - (beam.lens_radius_m - row.x_axis.w)) / w;
  vec4 back = vec4(narrow, narrow, 1.0, 1.0);
  ShadowChord ends;
  ends.from = back * vec4(chord.base + ray * chord.t_from_m, -1.0) / chord.w_from;
  ends.to = back * vec4(chord.base + ray * chord.t_to_m, -1.0) / chord.w_to;
  ends.lens_m = kLensPoints > 1u ? shadow_lens_m(row) : 0.0;
  if (kMapRows) ends.line = row_line(row, chord, ray);
  return ends;
}
// entry: in a rectangle that shows the chord.
bool shadow_part(uint entry, ShadowChord ends, out float x0, out float x1) {
  x0 = 0.0;
  x1 = 1.0;
  uint shadow = entry_shadow(entry);
  uint planes = entry_planes(entry);
  uint rounds = plane_rounds(planes);
  bool dark = true;
  for (uint round_of = 0u; round_of < rounds && dark; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      vec4 plane = shadows[shadow].planes[next_plane(planes)];
      dark = shadow_cut(dot(plane, ends.from), dot(plane, ends.to), x0, x1) && dark;
    }
  }
  return dark;
}
// The same with several points of the lens, each for the part of the lens around it. y below x: there is none.
vec2 soft_shadow_part(uint entry, ShadowChord ends) {
  uint shadow = entry_shadow(entry);
  uint outline = shadow_outline(shadow);
  uint count = shadow_planes(shadow);
  vec3 point = lens_point(kLensPoints, shadow_point(shadow), ends.lens_m);
  // How far behind the outline the chord's ends are, over how far the outline is; over w.
  vec2 rise = vec2(FL_FAR_M);
  for (uint round_of = outline / kShadowRound; kShadowRound * round_of < count; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = kShadowRound * round_of + k;
      vec4 plane = shadows[shadow].planes[own];
      float at_point = max(dot(plane.xyz, point) - plane.w, 1e-9);
      vec2 here = -vec2(dot(plane, ends.from), dot(plane, ends.to)) / at_point;
      rise = own >= outline && own < count ? min(rise, here) : rise;
    }
  }
  vec2 wide = lens_part_radius(kLensPoints) * ends.lens_m * max(rise, vec2(0.0));
  vec2 hard = vec2(0.0, 1.0);
  vec2 outer = hard;
  vec2 inner = hard;
  uint planes = entry_planes(entry);
  uint rounds = plane_rounds(planes);
  for (uint round_of = 0u; round_of < rounds && outer.y > outer.x; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = next_plane(planes);
      vec4 plane = shadows[shadow].planes[own];
      vec2 ramp = own < outline ? length(plane.xy) * wide : vec2(0.0);
      shadow_cut_soft(dot(plane, ends.from), dot(plane, ends.to), ramp.x, ramp.y, hard, outer, inner);
    }
  }
  if (!(outer.y > outer.x)) return vec2(1.0, 0.0);
  if (inner.y > inner.x) return hard;
  vec3 shares = vec3(1.0);
  vec3 at = outer.x + (outer.y - outer.x) * vec3(0.25, 0.5, 0.75);
  planes = entry_planes(entry);
  for (uint round_of = 0u; round_of < rounds; ++round_of) {
    [[unroll]] for (uint k = 0u; k < kShadowRound; ++k) {
      uint own = next_plane(planes);
      vec4 plane = shadows[shadow].planes[own];
      vec3 outside = mix(vec3(dot(plane, ends.from)), vec3(dot(plane, ends.to)), at);
      vec3 ramp = length(plane.xy) * mix(vec3(wide.x), vec3(wide.y), at);
      vec3 here = vec3(shadow_ramp(outside.x, ramp.x), shadow_ramp(outside.y, ramp.y),
                       shadow_ramp(outside.z, ramp.z));
      shares = own < outline ? min(shares, here) : shares;
    }
  }
  return shadow_soft_part(hard, outer, shares);
}
void shadow_parts_join(inout ShadowParts parts, uint entry, ShadowChord ends) {
  if (kLensPoints > 1u) {
    vec2 part = soft_shadow_part(entry, ends);
    if (part.y > part.x) shadow_parts_add(parts, part.x, part.y);
    return;
  }
  float x0;
  float x1;
  if (shadow_part(entry, ends, x0, x1)) shadow_parts_add(parts, x0, x1);
}
// Nodes of a whole chord that shadows from several points of the lens weigh; nodes: of a lit one.
uint soft_nodes(uint nodes) { return min(nodes + 2u, 8u); }
// Adds the dark parts of a chord.
void shadow_parts_weigh(ShadowParts parts, float share, inout ShadowWeights weights) {
  float from = 0.0;
  float to = 0.0;
  while (shadow_parts_next(parts, to, from, to)) shadow_weights_add(weights, share, from, to);
}
#include "render/shaders/lib/shadow_map.glsl"
