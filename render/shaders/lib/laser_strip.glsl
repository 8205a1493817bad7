// The part of a tile that a row of lasers touches, and polynomials over it. After laser_row.glsl.
//
// What a pixel sees of a sheet is LaserAir.profile, which changes from pixel to pixel, times what is smooth: `air`. That
// and LaserAir.scale are computed at kNodes places of the strip and are polynomials between these, of degree 2 along the
// beams and 1 across.

const uint kNodesAlong = 3u;
const uint kNodesAcross = 2u;
const uint kNodes = kNodesAlong * kNodesAcross;

struct Strip {
  vec3 light;   // of the row, lm
  float reach;  // of its sheet
  vec2 middle;  // pixels from the middle of the tile
  vec2 along;   // unit
  vec2 half_px;  // along, across, between the edges of the sheet, or around a beam; 0: the row is not seen in the tile
  vec2 per_px;   // one over the change of dot(ray, cross_1) a pixel across; and of that at the last edge
  vec3 edge_1;  // dot(edge, (1, pixels from the middle of the tile)) is dot(ray, cross_1)
  vec3 edge_2;  // of cross_2
};

vec2 strip_across(vec2 along) { return vec2(along.y, -along.x); }

// A dot product of the rays of a tile's pixels.
vec3 laser_edge(vec3 ray, vec3 normal) {
  return vec3(dot(ray, normal), dot(laser_step_x(), normal), dot(laser_step_y(), normal));
}

// middle: of the tile.
Strip laser_strip(LaserRow row, LaserSheet sheet, vec2 middle) {
  const float half_tile = 0.5 * float(FL_TILE_PX);
  LaserPixel pixel = LaserPixel(ray_through(middle), laser_step_x(), laser_step_y());
  Strip strip;
  strip.light = row.light.rgb;
  strip.reach = sheet.reach;
  strip.edge_1 = laser_edge(pixel.ray, sheet.cross_1);
  strip.edge_2 = laser_edge(pixel.ray, sheet.cross_2);
  vec3 last = strip.edge_1 + strip.edge_2 * sheet.reach;
  vec3 mean = 0.5 * (strip.edge_1 + last);
  float slope = length(mean.yz);
  vec2 across = slope > 0.0 ? mean.yz / slope : vec2(0.0, 1.0);
  strip.along = vec2(-across.y, across.x);
  float whole = half_tile * (abs(across.x) + abs(across.y));  // half of the tile's extent, along as across
  // What the pixels see of a beam is so wide here, with something to spare for the other end of the tile.
  float tau = clamp(-strip.edge_1.x / (abs(strip.edge_2.x) > 0.0 ? strip.edge_2.x : 1.0), 0.0, sheet.reach);
  float margin = 1.2 * kLaserReach / max(laser_meeting(sheet, pixel, tau).scale * slope, 1e-20) + 0.5;
  margin = min(margin, row.cross_2.w);
  // Where both edges cross the strip's ends.
  float low = -whole;
  float high = whole;
  vec2 along_edge = vec2(dot(strip.edge_1.yz, strip.along), dot(last.yz, strip.along));
  vec2 across_edge = vec2(dot(strip.edge_1.yz, across), dot(last.yz, across));
  bool is_even = across_edge.x > 0.2 * length(strip.edge_1.yz) && across_edge.y > 0.2 * length(last.yz);
  strip.per_px = is_even ? 1.0 / across_edge : vec2(0.0);
  if (is_even) {
    vec2 at = -vec2(strip.edge_1.x, last.x) * strip.per_px;
    vec2 turn = abs(along_edge * strip.per_px) * whole;
    low = min(at.x - turn.x, at.y - turn.y);
    high = max(at.x + turn.x, at.y + turn.y);
  }
  bool is_seen = low - margin < whole && high + margin > -whole;
  float from = -whole;
  float to = whole;
  float reach = half_tile + 0.5 * (high - low) + margin;
  if (reach < 2.0 * half_tile) {  // what of a narrow strip is in the tile
    vec2 center = across * (0.5 * (low + high));
    for (int axis = 0; axis < 2; ++axis) {
      float way = strip.along[axis];
      if (abs(way) < 1e-3) continue;
      float a = (-reach - center[axis]) / way;
      float b = (reach - center[axis]) / way;
      from = max(from, min(a, b));
      to = min(to, max(a, b));
    }
  }
  // Its light begins at the lens.
  vec3 lens = laser_picture(pixel, -sheet.eye);
  if (lens.z > kLaserNearest) {
    vec2 lens_px = lens.xy / lens.z;
    vec3 last_beam = sheet.first + sheet.second * sheet.reach;
    vec3 ways[2] = vec3[2](laser_picture(pixel, sheet.first), laser_picture(pixel, last_beam));
    vec2 way = vec2(dot(ways[0].xy - lens_px * ways[0].z, strip.along), dot(ways[1].xy - lens_px * ways[1].z, strip.along));
    float at = dot(lens_px, strip.along);
    if (way.x > 0.0 && way.y > 0.0) from = max(from, at - margin);
    if (way.x < 0.0 && way.y < 0.0) to = min(to, at + margin);
  }
  if (sheet.reach == 0.0) {
    low -= margin;
    high += margin;
  } else {
    low = clamp(low, -whole - margin, whole + margin - 0.5);
    high = clamp(high, low + 0.5, whole + margin);
  }
  strip.middle = strip.along * (0.5 * (from + to)) + across * (0.5 * (low + high));
  strip.half_px = is_seen && from < to ? 0.5 * vec2(to - from, high - low) : vec2(0.0);
  return strip;
}

// Where a place of a strip, -1 to 1, is; pixels from the middle of the tile.
vec2 strip_px(Strip strip, vec2 place) {
  return strip.middle + strip.along * (place.x * strip.half_px.x) + strip_across(strip.along) * (place.y * strip.half_px.y);
}

// Places of a strip, -1 to 1: the nodes, then two at which the polynomials are checked: where these are off most, and
// where a narrow sheet has light.
const float kAlong = 0.8660254037844386;
const float kAcross = 0.7071067811865476;
vec2 strip_place(uint number) {
  if (number >= kNodes) return vec2(number == kNodes ? -1.0 : 0.5, 0.0);
  return vec2(kAlong * (1.0 - float(number % kNodesAlong)), number < kNodesAlong ? kAcross : -kAcross);
}

// The light is a sum of products of Chebyshev's polynomials of the first kind: three along, two across.
vec3 chebyshev(float x) { return vec3(1.0, x, 2.0 * x * x - 1.0); }
// What the values at the nodes weigh in the coefficient of polynomial `which`.
vec3 weights_along(uint which) {
  if (which == 0u) return vec3(1.0 / 3.0);
  return which == 1u ? vec3(1.0, 0.0, -1.0) * (kAlong / 1.5) : vec3(1.0, -2.0, 1.0) / 3.0;
}
vec2 weights_across(uint which) { return which == 0u ? vec2(0.5) : vec2(kAcross, -kAcross); }
