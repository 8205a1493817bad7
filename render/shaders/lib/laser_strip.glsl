// The part of a square of the picture that a row of lasers touches: a strip along its beams, and polynomials over it.
// After laser_row.glsl.
//
// What a pixel sees of a sheet is a mean of the normal density, which changes from pixel to pixel, times what is
// smooth: LaserAir.smooth_light. That and LaserAir.scale are computed at kNodes places of the strip and are polynomials
// between these, of degree 3 along the beams and 2 across.

const uint kNodesAlong = 4u;
const uint kNodesAcross = 3u;
const uint kNodes = kNodesAlong * kNodesAcross;
const uint kPlaces = 16u;  // the nodes, and four that check them

vec2 strip_across(vec2 along) { return vec2(along.y, -along.x); }

// A dot product of the rays of a square's pixels.
vec3 laser_edge(vec3 ray, vec3 normal) {
  return vec3(dot(ray, normal), dot(laser_step_x(), normal), dot(laser_step_y(), normal));
}

// middle, half_square: of the square, pixels. Without its polynomials.
LaserStripRow laser_strip(LaserRow row, LaserSheet sheet, vec2 middle, float half_square) {
  LaserPixel pixel = LaserPixel(ray_through(middle), laser_step_x(), laser_step_y());
  vec3 first = laser_edge(pixel.ray, sheet.cross_1);
  vec3 change = laser_edge(pixel.ray, sheet.cross_2);
  vec3 last = first + change * sheet.reach;
  vec3 mean = 0.5 * (first + last);
  float slope = length(mean.yz);
  vec2 across = slope > 0.0 ? mean.yz / slope : vec2(0.0, 1.0);
  vec2 along = vec2(-across.y, across.x);
  float whole = half_square * (abs(across.x) + abs(across.y));  // half of the square's extent, along as across
  // What the pixels see of a beam is so wide here, with something to spare for the other end of the square.
  float tau = clamp(-first.x / (abs(change.x) > 0.0 ? change.x : 1.0), 0.0, sheet.reach);
  float margin = 1.2 * kLaserReach / max(laser_meeting(sheet, pixel, tau).scale * slope, 1e-20) + 0.5;
  // It grows with the distance from where the beams go to.
  vec3 last_beam = sheet.first + sheet.second * sheet.reach;
  vec3 ways[2] = vec3[2](laser_picture(pixel, sheet.first), laser_picture(pixel, last_beam));
  vec2 gone = ways[0].xy / (abs(ways[0].z) > 1e-6 ? ways[0].z : 1e-6);
  margin = min(margin * (1.0 + 1.5 * half_square / max(length(gone), 1.0)), row.cross_2.w);
  // Where both edges cross the strip's ends.
  float low = -whole;
  float high = whole;
  vec2 along_edge = vec2(dot(first.yz, along), dot(last.yz, along));
  vec2 across_edge = vec2(dot(first.yz, across), dot(last.yz, across));
  bool is_even = across_edge.x > 0.2 * length(first.yz) && across_edge.y > 0.2 * length(last.yz);
  vec2 per_px = is_even ? 1.0 / across_edge : vec2(0.0);
  if (is_even) {
    vec2 at = -vec2(first.x, last.x) * per_px;
    vec2 turn = abs(along_edge * per_px) * whole;
    low = min(at.x - turn.x, at.y - turn.y);
    high = max(at.x + turn.x, at.y + turn.y);
  }
  bool is_seen = low - margin < whole && high + margin > -whole;
  float from = -whole;
  float to = whole;
  float reach = half_square + 0.5 * (high - low) + margin;
  if (reach < 2.0 * half_square) {  // what of a narrow strip is in the square
    vec2 center = across * (0.5 * (low + high));
    for (int axis = 0; axis < 2; ++axis) {
      float way = along[axis];
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
    vec2 way = vec2(dot(ways[0].xy - lens_px * ways[0].z, along), dot(ways[1].xy - lens_px * ways[1].z, along));
    float at = dot(lens_px, along);
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
  vec2 half_px = is_seen && from < to ? 0.5 * vec2(to - from, high - low) : vec2(0.0);
  vec4 none[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
  return LaserStripRow(vec4(row.light.rgb, sheet.reach),
                       vec4(along * (0.5 * (from + to)) + across * (0.5 * (low + high)), along), vec4(half_px, per_px),
                       vec4(first, margin), vec4(change, 0.0), none, none, vec4(0.0));
}

// Where a place of a strip, -1 to 1, is; pixels from the middle of the square.
vec2 strip_px(LaserStripRow strip, vec2 place) {
  vec2 along = strip.frame.zw;
  return strip.frame.xy + along * (place.x * strip.size.x) + strip_across(along) * (place.y * strip.size.y);
}

// Places of a strip, -1 to 1: the nodes, then four at which the polynomials are checked: where these are off most, and
// where a narrow sheet has light.
const float kPi_8 = 0.39269908169872414;
const float kAcross = 0.8660254037844386;
vec2 strip_place(uint number) {
  if (number < kNodes) {
    return vec2(cos(kPi_8 * float(2u * (number % kNodesAlong) + 1u)), kAcross * (1.0 - float(number / kNodesAlong)));
  }
  uint check = number - kNodes;
  return vec2(check < 2u ? 2.0 * float(check) - 1.0 : 0.0, (check & 1u) == 0u ? 0.3 : -0.3);
}

// The light is a sum of products of Chebyshev's polynomials of the first kind: four along, three across.
vec4 chebyshev(float x) {
  float square = x * x;
  return vec4(1.0, x, 2.0 * square - 1.0, x * (4.0 * square - 3.0));
}
// What the values at the nodes weigh in the coefficient of polynomial `which`.
vec4 weights_along(uint which) {
  return which == 0u ? vec4(0.25) : 0.5 * cos(kPi_8 * float(which) * vec4(1.0, 3.0, 5.0, 7.0));
}
vec3 weights_across(uint which) {
  if (which == 0u) return vec3(1.0 / 3.0);
  return which == 1u ? vec3(1.0, 0.0, -1.0) * (kAcross / 1.5) : vec3(1.0, -2.0, 1.0) / 3.0;
}

// The light of a row by the polynomials of its strip. px: from the middle of the square.
float light_of_strip(LaserStripRow strip, vec2 px) {
  vec2 away = px - strip.frame.xy;
  float x = dot(away, strip.frame.zw) / strip.size.x;
  float across_px = dot(away, strip_across(strip.frame.zw));
  if (abs(x) > 1.001) return 0.0;
  float edge = dot(strip.edge_1.xyz, vec3(1.0, px));
  float reach = strip.light.w;
  float last = edge + dot(strip.edge_2.xyz, vec3(1.0, px)) * reach;
  vec2 at = across_px - vec2(edge, last) * strip.size.zw;
  float beside_px = max(min(at.x, at.y) - across_px, across_px - max(at.x, at.y));
  if (reach == 0.0 ? abs(across_px) > strip.size.y : beside_px > strip.edge_1.w) return 0.0;
  vec4 along = chebyshev(x);
  vec3 light = vec3(dot(strip.smooth_light[0], along), dot(strip.smooth_light[1], along),
                    dot(strip.smooth_light[2], along));
  vec3 scales = vec3(dot(strip.scale[0], along), dot(strip.scale[1], along), dot(strip.scale[2], along));
  if (reach == 0.0) {
    vec3 across = chebyshev(across_px / strip.size.y).xyz;
    float scale = dot(scales, across);
    return max(dot(light, across) * scale, 0.0) * normal_at(edge * scale);
  }
  // Across, the beam of the sheet that the pixel sees in the middle.
  float y = clamp(across_px, min(at.x, at.y), max(at.x, at.y)) / strip.size.y;
  float scale = dot(scales, chebyshev(clamp(y, -1.0, 1.0)).xyz);
  if (min(abs(edge), abs(last)) * scale > 5.5 && edge * last > 0.0) return 0.0;
  float middle;
  float profile = normal_mean(edge * scale, last * scale, middle);
  y = mix(at.x, at.y, middle) / strip.size.y;
  return max(dot(light, chebyshev(clamp(y, -1.0, 1.0)).xyz) * scale, 0.0) * profile;
}
