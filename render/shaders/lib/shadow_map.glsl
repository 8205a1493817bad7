// Shadow maps: for directions of light in a beam the distances along its axis at which it meets the first body, and
// at which it has passed the first one. Light keeps its place rho in the gobo plane (shadow.h), so all behind that is
// dark, and a chord is a straight line in the map: the map's error is where edges lie, to half a texel. Error:
// docs/numerics.md. After shadow.glsl.
layout(set = 0, binding = FL_BINDING_BEAM_MAPS, std430) readonly buffer ShadowMapsBuffer { uint shadow_maps[]; };

// Distances in half floats; the largest stands for none. A lens inside a body gives no light, not even at 0.
vec2 map_distances(uint word) {
  vec2 at = unpackHalf2x16(word);
  at = vec2(at.x > 0.0 ? at.x : -1.0, at.y > 0.0 ? at.y : -1.0);
  return vec2(at.x < 65504.0 ? at.x : FL_FAR_M, at.y < 65504.0 ? at.y : FL_FAR_M);
}
// Of a texel: first body met, first body passed.
vec2 map_texel(uint beam, ivec2 at) {
  uvec2 texel = uvec2(clamp(at, ivec2(0), ivec2(int(kMapPx) - 1)));
  return map_distances(shadow_maps[beam * kMapWords + kMapCells * kMapCells + texel.y * kMapPx + texel.x]);
}
// Of the texels of a cell: the nearest and the farthest distance at which a body is met.
vec2 map_cell(uint beam, ivec2 at) {
  uvec2 cell = uvec2(clamp(at, ivec2(0), ivec2(int(kMapCells) - 1)));
  return map_distances(shadow_maps[beam * kMapWords + cell.y * kMapCells + cell.x]);
}

// Cells that hold the places low to high of rho: bits 0 and 1, whether some and all of what lies there between the
// distances z_m is behind a body.
uint map_hides(uint beam, vec2 low, vec2 high, vec2 z_m) {
  const float kHalf = 0.5 * float(kMapCells);
  ivec2 first = clamp(ivec2(floor(kHalf * clamp(low, -1.0, 1.0) + kHalf - 1e-3)), 0, int(kMapCells) - 1);
  ivec2 last = clamp(ivec2(floor(kHalf * clamp(high, -1.0, 1.0) + kHalf + 1e-3)), 0, int(kMapCells) - 1);
  vec2 distances = vec2(FL_FAR_M, 0.0);
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      vec2 cell = map_cell(beam, ivec2(x, y));
      distances = vec2(min(distances.x, cell.x), max(distances.y, cell.y));
    }
  }
  return (distances.x < z_m.y ? 1u : 0u) | (distances.y <= z_m.x ? 2u : 0u);
}

// What shadow_in_cell() gives for a list: FL_NONE where no light of the beam is hidden in the cell, an entry without
// planes only where all of it is.
uint map_in_cell(uint beam, ShadowCell cell) {
  if (cell.near_m > cell.far_m) return FL_NONE;
  // Nearly at the apex places in the map are far off.
  float w_min = cell.radius.x * 0.5;
  bool is_whole = cell.is_thin;
  vec2 low = vec2(FL_FAR_M);
  vec2 high = vec2(-FL_FAR_M);
  [[unroll]] for (int c = 0; c < 4; ++c) {
    [[unroll]] for (int end = 0; end < 2; ++end) {
      vec3 p = cell.eye + cell.corner[c] * (end == 0 ? cell.near_m : cell.end_m[c]);
      float w = cell.radius.x + cell.radius.y * p.z;
      is_whole = is_whole || !(w > w_min);
      vec2 rho = p.xy / max(w, w_min);
      low = min(low, rho);
      high = max(high, rho);
    }
  }
  uint hides = is_whole ? map_hides(beam, vec2(-1.0), vec2(1.0), cell.z_m) : map_hides(beam, low, high, cell.z_m);
  if ((hides & 1u) == 0u) return FL_NONE;
  return shadow_entry(0u, (hides & 2u) != 0u && !is_whole ? 0u : 1u);
}

// Whether some of a sphere may be behind a body; light space.
bool map_hides_in_sphere(uint beam, BeamRow row, vec3 center, float radius_m) {
  vec2 z_m = center.z + radius_m * vec2(-1.0, 1.0);
  vec2 w = row.x_axis.w + row.y_axis.w * z_m;
  bool is_whole = beam_thin(row) > 0.0 || !(w.x > 0.5 * row.x_axis.w);
  vec2 inverse = 1.0 / max(w, 0.5 * row.x_axis.w);
  vec2 low = center.xy - radius_m;
  vec2 high = center.xy + radius_m;
  const vec2 beside = vec2(2.0 / float(kMapPx));  // map_lit() reads a texel round a place
  low = is_whole ? vec2(-1.0) : min(low * inverse.x, low * inverse.y) - beside;
  high = is_whole ? vec2(1.0) : max(high * inverse.x, high * inverse.y) + beside;
  return (map_hides(beam, low, high, z_m) & 1u) != 0u;
}

// Whether a place in the haze is behind a body; light space.
bool map_hides_place(uint beam, BeamRow row, vec3 p) {
  vec2 rho = p.xy / max(row.x_axis.w + row.y_axis.w * p.z, 1e-9);
  return p.z > map_texel(beam, ivec2(floor((0.5 * rho + 0.5) * float(kMapPx)))).x;
}

// Share of the light that reaches a place on a surface: of the four texels round it, those whose first body is not yet
// passed. Bodies do not hide light from their own faces, so a place may be a texel's width behind a body's far side.
float map_lit(uint beam, BeamRow row, vec3 p) {
  float w = max(row.x_axis.w + row.y_axis.w * p.z, 1e-9);
  vec2 at = (0.5 * p.xy / w + 0.5) * float(kMapPx) - 0.5;
  ivec2 texel = ivec2(floor(at));
  vec2 share = at - vec2(texel);
  float reach_m = p.z - 1e-3 * abs(p.z) - 2.0 * w / float(kMapPx);
  vec4 passed = vec4(map_texel(beam, texel).y, map_texel(beam, texel + ivec2(1, 0)).y,
                     map_texel(beam, texel + ivec2(0, 1)).y, map_texel(beam, texel + ivec2(1, 1)).y);
  vec4 lit = vec4(greaterThanEqual(passed, vec4(reach_m)));
  return mix(mix(lit.x, lit.y, share.x), mix(lit.z, lit.w, share.x), share.y);
}

#include "render/shaders/lib/shadow_rows.glsl"

// Whether a place of a chord is behind a body. from, way: texels; depth, deeper: z over w and 1 over w, which are
// linear in the chord's measure x.
bool map_hides_chord(uint beam, vec2 from, vec2 way, vec2 depth, vec2 deeper, float x) {
  vec2 at = depth + deeper * x;
  return at.x > map_texel(beam, ivec2(floor(from + way * x))).x * at.y;
}

// The dark parts of a chord: samples kMapStep texels apart, and between two that differ the place of the change to an
// eighth of that. What is narrower than a step may be missed.
const float kMapStep = 4.0;
const int kMapBatch = 16;  // samples that are read together
ShadowParts map_parts(uint beam, ShadowChord ends) {
  if (has_row(ends.line)) return row_parts(beam, ends.line);
  ShadowParts parts;
  shadow_parts_clear(parts);
  vec2 from = 0.5 * float(kMapPx) * (ends.from.xy + 1.0);
  vec2 way = 0.5 * float(kMapPx) * (ends.to.xy - ends.from.xy);
  vec2 depth = vec2(ends.from.z, -ends.from.w);
  vec2 deeper = vec2(ends.to.z, -ends.to.w) - depth;
  float steps = clamp(ceil(max(abs(way.x), abs(way.y)) / kMapStep), 4.0, float(kMapPx) / kMapStep);
  bool was_dark = map_hides_chord(beam, from, way, depth, deeper, 0.0);
  float dark_from = 0.0;
  for (float first = 0.0; first < steps; first += float(kMapBatch)) {
    // All samples before any change, so that few of them wait for another.
    uint dark = was_dark ? 1u : 0u;  // a bit each, from `first` on
    int count = min(int(steps - first), kMapBatch);
    for (int k = 1; k <= count; k += 4) {  // what is past the last one does not count
      [[unroll]] for (int j = k; j < k + 4; ++j) {
        dark |= map_hides_chord(beam, from, way, depth, deeper, (first + float(j)) / steps) ? 1u << j : 0u;
      }
    }
    uint changes = (dark ^ dark >> 1) & ((1u << count) - 1u);
    for (; changes != 0u; changes &= changes - 1u) {
      int k = findLSB(changes);
      bool begins = (dark >> k & 1u) == 0u;
      float before = (first + float(k)) / steps;
      float after = (first + float(k + 1)) / steps;
      for (int half_of = 0; half_of < 3; ++half_of) {
        float middle = 0.5 * (before + after);
        bool same = map_hides_chord(beam, from, way, depth, deeper, middle) != begins;
        before = same ? middle : before;
        after = same ? after : middle;
      }
      float edge = 0.5 * (before + after);
      if (!begins) shadow_parts_add(parts, dark_from, edge);
      dark_from = edge;
    }
    was_dark = (dark >> count & 1u) != 0u;
  }
  if (was_dark) shadow_parts_add(parts, dark_from, 1.0);
  return parts;
}
