// What one beam is over one rectangle of pixels, decided by a team at 4 x 4 Chebyshev nodes: dark; smooth, so that its
// light is a polynomial; smooth but for its rim, so that h and the line's offset rho are; cut, so that rho, the places
// of the cuts and the coefficients of g are (shared/tile_node.h); or none of these. After beam.h, tile_node.h,
// tile_test.glsl, thin.glsl, tile_depth.glsl, tile_team.glsl. Design and error: docs/decisions/0100.
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

const uint kDark = 0u;
const uint kSmooth = 1u;
const uint kRim = 2u;
const uint kCut = 3u;
const uint kGeneral = 4u;

struct Rect {
  vec2 middle;   // pixels
  float half_px; // of the nodes' hull, which holds every pixel's centre
  RectDepth depth;
};

// Largest share that a beam's own tail may have, whatever the tolerance; and of the smallest q over the largest.
const float kTailMax = 0.1;
const float kOffsetTailMax = 0.04;
const float kRatioMin = 0.05;
// Where a chord is taken as cut, or as not cut: this far from its end in s.
const float kEndSlack = 0.02;
const float kShortestCut = 0.03;
// Least cosine between the lines of two rays of a tile. Below it the apex is near.
const float kAlongMin = 0.7;

// The beam that was classified last, at this lane's nodes. kSmooth: its light. kRim and kCut: coefficients of T_m T_n of
// what the record of the kind has, in its order: rho and h; rho, g_0, g_1, g_2, s_a and s_b.
float node_light[kPer];
float fits[6][kPer];

float brightest(vec3 rgb) { return max(rgb.r, max(rgb.g, rgb.b)); }

// Whether the beam has a light that tile_node() knows.
bool tile_knows(BeamRow row) {
  bool plain = row.j0.w == 0.0 && row.measured == 0u && row.squeeze == 0.0 && (row.flags & FL_BEAM_BLADES) == 0u &&
               row.y_axis.w <= kWideSpread;
  return plain && !has_gobo(row);
}

// The beam on the ray through a place of the rectangle, up to the surface there.
TileNode node_at(BeamRow row, BeamShape beam, Rect rect, vec2 at, bool many, out Chord chord) {
  vec3 through = ray_through(at);
  float ray_length = length(through);
  vec3 ray = to_light(row, through / ray_length);
  ChordLine line;
  beam_line(beam, row.eye.xyz, ray, 0.0, FL_FAR_M, chord, line);
  if (kSolids) {
    float end_m = rect.depth.is_plane ? plane_distance(rect.depth, at, ray_length) : rect.depth.far_m;
    if (end_m < line.t_to_m) beam_line(beam, row.eye.xyz, ray, 0.0, end_m, chord, line);
  }
  return tile_node(beam, Medium(params.anisotropy, params.position.w), chord, line, ray, many, kExtinction);
}

// Light, h and rho at the rectangle's middle.
vec3 light_at_middle(BeamRow row, Rect rect) {
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  Chord chord;
  bool many = kNodes > 3u || (kProfile && beam.profile_power != 1.0);
  TileNode node = node_at(row, beam, rect, rect.middle, many, chord);
  return vec3(node.light, node.h, chord.offset);
}

const uint kAlive = 1u;        // some of the ray is in the slab
const uint kUnlit = 2u;        // none is
const uint kSameSide = 4u;     // the line runs as that of the first node
const uint kThick = 8u;        // the beam is not widened (thin.glsl)
const uint kFromLens = 16u;    // the line begins at the slab
const uint kFromEye = 32u;
const uint kToRange = 64u;     // and ends there
const uint kToPlane = 128u;
const uint kForward = 256u;    // the ray runs as the light does
const uint kBackward = 512u;
const uint kWholeBefore = 1024u;  // nothing cuts the near end of the chord
const uint kWholeAfter = 2048u;
const uint kPast = 4096u;      // the line ends before the disc
const uint kAhead = 8192u;     // the line begins behind it
const uint kFree = 16384u;     // the light ends before the nearest of several surfaces
const uint kLongBefore = 32768u;  // the near end is clearly outside the rim
const uint kCutBefore = 65536u;   // and clearly inside
const uint kLongAfter = 131072u;
const uint kCutAfter = 262144u;
const uint kLong = 524288u;  // the lit part is not short

bool has(uint bits, uint all) { return (bits & all) == all; }

// Value at the middle of a polynomial from its coefficients, this lane's part: T_2(0) = -1, T_1(0) = T_3(0) = 0.
float at_middle(float f[kPer]) {
  float sum = 0.0;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    bool counts = ((place.x | place.y) & 1u) == 0u;
    sum += counts ? (place.x == place.y ? f[k] : -f[k]) : 0.0;
  }
  return sum;
}
// Of a quadratic: without T_2 T_2.
float at_middle_quadratic(float f[kPer]) {
  float sum = 0.0;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    bool counts = ((place.x | place.y) & 1u) == 0u && place.x + place.y <= 2u;
    sum += counts ? (place.x == place.y ? f[k] : -f[k]) : 0.0;
  }
  return sum;
}

// middle: light, h and rho of the beam at the rectangle's middle. tolerance: largest error of this beam's light over
// sigma_s, in its brightest channel. records: whether kRim and kCut are wanted; without, they are general. All lanes of
// a subgroup call it together, with one beam a team; where is_beam is false the result is kDark. The beams are such for
// which tile_knows() and beam_touches() are true.
uint tile_class(BeamRow row, bool is_beam, vec3 middle, Rect rect, float tolerance, bool records) {
  Medium medium = Medium(params.anisotropy, params.position.w);
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  bool many = kNodes > 3u || (kProfile && beam.profile_power != 1.0);
  bool thin = thin_in_haze_applies(row);
  vec3 eye = row.eye.xyz;
  Chord chord[kPer];
  ChordLine line[kPer];
  vec3 ray[kPer];
  float free[kPer];
  uint bits = 0xffffffffu;
  float rho_min = 1e30;
  float rho_max = -1e30;
  FL_LANE_NODES(k) {
    vec2 at = rect.middle + rect.half_px * node_position(k);
    vec3 through = ray_through(at);
    float ray_length = length(through);
    ray[k] = to_light(row, through / ray_length);
    float end_m = rect.depth.is_plane ? plane_distance(rect.depth, at, ray_length) : rect.depth.far_m;
    uint own = kThick;
    if (thin) {
      float radius;
      float wide;
      thin_meets(beam, row, eye, ray[k], 1.0 / ray_length, end_m, radius, wide);
      if (!(wide < 0.8 * radius * thin_scale(beam, true))) own = 0u;
    }
    beam_line(beam, eye, ray[k], 0.0, FL_FAR_M, chord[k], line[k]);
    float slab_from_m = line[k].t_from_m;
    float slab_to_m = line[k].t_to_m;
    // Where the surface ends the ray.
    bool ends = kSolids && end_m < slab_to_m;
    if (ends) beam_line(beam, eye, ray[k], 0.0, end_m, chord[k], line[k]);
    free[k] = 1e30;
    if (kSolids && !rect.depth.is_plane && rect.depth.near_m < slab_to_m) {
      float past_m = rect.depth.near_m - chord[k].t_base_m;
      free[k] = rect.depth.near_m > slab_from_m
                    ? chord[k].s_base + chord[k].v_length * past_m /
                                            (chord[k].w_base * max(chord[k].w_base + past_m * chord[k].w_slope, 1e-9))
                    : -1e30;
    }
    own |= line[k].t_to_m > line[k].t_from_m ? kAlive : kUnlit;
    own |= slab_from_m > 0.0 ? kFromLens : kFromEye;
    own |= ends ? kToPlane : kToRange;
    own |= ray[k].z > 0.0 ? kForward : kBackward;
    float half_chord = sqrt(max(1.0 - chord[k].offset * chord[k].offset, 0.0));
    float before = line[k].s_a + half_chord;  // how far the end is inside the rim
    float after = half_chord - line[k].s_b;
    own |= (before <= -kEndSlack ? kLongBefore : 0u) | (before >= kEndSlack ? kCutBefore : 0u) |
           (after <= -kEndSlack ? kLongAfter : 0u) | (after >= kEndSlack ? kCutAfter : 0u);
    if (min(line[k].s_b, half_chord) - max(line[k].s_a, -half_chord) >= kShortestCut) own |= kLong;
    bits &= own | kSameSide | kWholeBefore | kWholeAfter | kPast | kAhead | kFree;
    rho_min = min(rho_min, chord[k].offset);
    rho_max = max(rho_max, chord[k].offset);
  }
  vec2 along = vec2(team_first(chord[0].along.x), team_first(chord[0].along.y));
  rho_min = team_min(rho_min);
  rho_max = team_max(rho_max);
  float nearest = rho_min <= 0.0 && rho_max >= 0.0 ? 0.0 : min(abs(rho_min), abs(rho_max));
  float farthest = max(abs(rho_min), abs(rho_max));
  float inner = max(nearest - 0.1 * (rho_max - rho_min), 0.0);
  float longest = sqrt(max(1.0 - inner * inner, 0.0)) + 0.05;  // half of the longest chord, with slack
  FL_LANE_NODES(k) {
    uint own = dot(chord[k].along, along) > kAlongMin ? kSameSide : 0u;
    own |= (line[k].s_a <= -longest ? kWholeBefore : 0u) | (line[k].s_b >= longest ? kWholeAfter : 0u) |
           (line[k].s_b <= -longest ? kPast : 0u) | (line[k].s_a >= longest ? kAhead : 0u) |
           (free[k] >= longest ? kFree : 0u);
    bits &= own | ~(kSameSide | kWholeBefore | kWholeAfter | kPast | kAhead | kFree);
  }
  bits = team_and(bits);

  bool dark = !is_beam || has(bits, kUnlit);
  bool open = !dark && has(bits, kSameSide | kThick);
  dark = dark || (open && (inner >= 1.0 || (has(bits, kAlive) && (bits & (kPast | kAhead)) != 0u)));
  float lum = brightest(row.j0.rgb);
  open = open && !dark && has(bits, kAlive) && lum > 0.0 && (!kSolids || rect.depth.is_plane || has(bits, kFree));
  float q_min = 1.0 - farthest * farthest;
  float q_max = 1.0 - nearest * nearest;
  bool whole = has(bits, kWholeBefore | kWholeAfter);
  bool inside = q_min > 0.0 && q_min >= kRatioMin * q_max;
  bool from_one = (bits & (kFromLens | kFromEye)) != 0u;
  bool to_one = (bits & (kToRange | kToPlane)) != 0u;
  bool alike = has(bits, kLong) && (has(bits, kLongBefore) || (has(bits, kCutBefore) && from_one)) &&
               (has(bits, kLongAfter) || (has(bits, kCutAfter) && to_one)) && q_min > 0.02 && inside;
  // Quadratics in s for g are good where the profile adds no high powers.
  bool moments = kNodes <= 3u && (!kProfile || (beam.profile_power > 0.75 && beam.profile_power < 2.5));
  bool one_way = (bits & (kForward | kBackward)) != 0u;
  bool cuts = records && moments && (has(bits, kWholeBefore) || has(bits, kFromEye) || (from_one && one_way)) &&
              (has(bits, kWholeAfter) || has(bits, kToPlane) || (to_one && one_way));
  open = open && (whole ? inside || records : alike || cuts);

  // Where g of a cut chord is sampled.
  float fit_middle = 0.0;
  float fit_half = 1.0;
  if (subgroupAny(open && !whole)) {
    float low = 1e30;
    float high = -1e30;
    FL_LANE_NODES(k) {
      low = min(low, line[k].s_a);
      high = max(high, line[k].s_b);
    }
    low = max(team_min(low), -longest);
    high = min(team_max(high), longest);
    fit_middle = 0.5 * (low + high);
    fit_half = max(0.5 * (high - low), kFitHalfMin);
  }
  float h[kPer];
  vec3 g[kPer];
  bool three = whole ? !many : moments;
  FL_LANE_NODES(k) {
    node_light[k] = 0.0;
    h[k] = 0.0;
    g[k] = vec3(0.0);
  }
  if (subgroupAny(open && three)) {
    FL_LANE_NODES(k) {
      float q = 1.0 - chord[k].offset * chord[k].offset;
      float at = whole ? 0.0 : fit_middle;
      float away = whole ? kRimNode3 * min(sqrt(abs(q)), 1.0) : kFitNode * fit_half;
      float inverse = 1.0 / max(chord[k].v_length, 1e-12);
      float center = inverse * tile_integrand(beam, medium, chord[k], line[k], ray[k], at, 0.0, true, kExtinction);
      float before = inverse * tile_integrand(beam, medium, chord[k], line[k], ray[k], at - away, 0.0, true, kExtinction);
      float after = inverse * tile_integrand(beam, medium, chord[k], line[k], ray[k], at + away, 0.0, true, kExtinction);
      float pair = before + after;
      if (q < 0.0) pair = 4.0 * center - pair;
      h[k] = kRimMiddle3 * center + kRimWeight3 * pair;
      g[k] = cut_fit(before, center, after, fit_middle, fit_half);
      node_light[k] = whole ? h[k] * rim_factor(max(q, 0.0), 1.0)
                            : dot(g[k], cut_moments(max(q, 0.0), line[k].s_a, line[k].s_b));
    }
  }
  if ((kProfile || kNodes > 3u) && subgroupAny(open && !three)) {
    FL_LANE_NODES(k) {
      TileNode node = tile_node(beam, medium, chord[k], line[k], ray[k], many, kExtinction);
      if (!three) {
        h[k] = node.h;
        node_light[k] = node.light;
      }
    }
  }

  // The tests add what the polynomials leave out, their last terms, and what they miss at the middle, since the terms of
  // a light that is even about the middle are zero. They are written so that NaN is general.
  float allowed = tolerance / lum;
  uint kind = dark ? kDark : kGeneral;
  bool try_smooth = open && (whole ? inside : alike);
  if (subgroupAny(try_smooth)) {
    float f[kPer];
    FL_LANE_NODES(k) f[k] = node_light[k];
    to_coefficients(f);
    float tail = 0.0;
    FL_LANE_NODES(k) {
      uvec2 place = node_place(k);
      if (max(place.x, place.y) == 3u) tail += abs(f[k]);
    }
    vec2 sums = team_sum(vec2(tail, at_middle(f)));
    float over = sums.x + abs(middle.x - sums.y);
    if (try_smooth && over <= allowed && over <= kTailMax * abs(team_first(f[0]))) kind = kSmooth;
  }
  if (!records) return kind;
  bool try_rim = open && whole && kind == kGeneral;
  bool try_cut = open && cuts && !whole && kind == kGeneral;
  if (subgroupAny(try_rim || try_cut)) {
    FL_LANE_NODES(k) {
      fits[0][k] = chord[k].offset;
      fits[1][k] = try_rim ? h[k] : g[k].x;
    }
    to_coefficients(fits[0]);
    to_coefficients(fits[1]);
    float size = abs(team_first(fits[1][0]));
    float tail = 0.0;
    float rho_tail = 0.0;
    FL_LANE_NODES(k) {
      uvec2 place = node_place(k);
      if (place.x + place.y >= 3u) {
        rho_tail += abs(fits[0][k]);
        tail += abs(fits[1][k]);
      }
    }
    vec4 sums = team_sum(vec4(rho_tail, tail, at_middle_quadratic(fits[0]), at_middle_quadratic(fits[1])));
    float rho_over = sums.x + abs(middle.z - sums.z);
    if (subgroupAny(try_rim)) {
      float over = sums.y + abs(middle.y - sums.w);
      // q^(p + 1/2) changes by at most 2 for a change of rho by 1.
      if (try_rim && over + 2.0 * size * rho_over <= allowed && over <= kTailMax * size && rho_over <= kOffsetTailMax) {
        kind = kRim;
      }
    }
    if (subgroupAny(try_cut)) {
      bool cut_a = !has(bits, kWholeBefore);
      bool cut_b = !has(bits, kWholeAfter);
      FL_LANE_NODES(k) {
        fits[2][k] = g[k].y;
        fits[3][k] = g[k].z;
        fits[4][k] = cut_a ? line[k].s_a : -4.0;
        fits[5][k] = cut_b ? line[k].s_b : 4.0;
      }
      [[unroll]] for (int i = 2; i < 6; ++i) to_coefficients(fits[i]);
      // What the light misses for what each of them misses: integrals of 1 - s^2, |s| (1 - s^2), s^2 (1 - s^2).
      float light_tail = 0.0;
      float cut_tail = 0.0;
      FL_LANE_NODES(k) {
        uvec2 place = node_place(k);
        if (place.x + place.y >= 3u) {
          light_tail += 0.25 * abs(fits[2][k]) + 0.27 * abs(fits[3][k]);
          cut_tail += abs(fits[4][k]) + abs(fits[5][k]);
        }
      }
      vec4 more = team_sum(vec4(light_tail, cut_tail, at_middle_quadratic(fits[2]), at_middle_quadratic(fits[3])));
      vec2 ends = team_sum(vec2(at_middle_quadratic(fits[4]), at_middle_quadratic(fits[5])));
      float light = dot(vec3(sums.w, more.zw), cut_moments(max(1.0 - sums.z * sums.z, 0.0), ends.x, ends.y));
      float over = 1.34 * sums.y + more.x + size * more.y + abs(middle.x - light);
      if (try_cut && over + 2.0 * size * rho_over <= allowed && 1.34 * sums.y + more.x <= kTailMax * size &&
          rho_over <= kOffsetTailMax && more.y <= 2.0 * kOffsetTailMax) {
        kind = kCut;
      }
    }
  }
  return kind;
}
