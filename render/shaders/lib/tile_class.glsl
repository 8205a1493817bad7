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
// Above it the line hardly turns.
const float kAlongSteady = 0.97;

float brightest(vec3 rgb) { return max(rgb.r, max(rgb.g, rgb.b)); }

// Whether the beam has a light that tile_node() knows.
bool tile_knows(BeamRow row) { return (row.flags & FL_BEAM_PLAIN) != 0u; }

// The beam's line on the ray through a place of the rectangle, up to the surface there.
void line_at(BeamShape beam, BeamRow row, Rect rect, vec2 at, out Chord chord, out ChordLine line, out vec3 ray) {
#ifdef FL_HAZE_FIELD
  haze_begin(at);
#endif
  vec3 through = ray_through(at);
  float ray_length = length(through);
  ray = to_light(row, through / ray_length);
  float end_m = FL_FAR_M;
  if (kSolids) end_m = rect.depth.is_plane ? plane_distance(rect.depth, at, ray_length) : rect.depth.far_m;
  beam_line(beam, row.eye.xyz, ray, 0.0, end_m, chord, line);
}

// Quadratics in s for g are good where the profile adds no high powers.
bool has_moments(BeamShape beam) {
  return kNodes <= 3u && (!kProfile || (beam.profile_power > 0.75 && beam.profile_power < 2.5));
}
bool has_many_nodes(BeamShape beam) { return kNodes > 3u || (kProfile && beam.profile_power != 1.0); }

// What is known of a beam before its nodes are computed, from the rectangle's corners and its middle.
const uint kGuessWhole = 1u;       // every chord crosses the whole disc, or misses it
const uint kGuessCut = 2u;         // something cuts them, each end in one way
const uint kGuessSmooth = 4u;      // the light may be smooth
const uint kGuessRecord = 8u;      // there is a record for what is not smooth
const uint kGuessCutBefore = 16u;  // what cuts the near end
const uint kGuessCutAfter = 32u;
const uint kGuessShadowed = 64u;   // what shadows hide of it is subtracted later (beams.comp)
const uint kGuessSurfaces = 128u;  // several surfaces cut the far end: each pixel's own (FL_TILE_SURFACES)
const uint kGuessGobo = 256u;      // an image stands in it (FL_GOBO_TILES)
struct TileGuess {
  uint bits;         // 0: dark, or general
  bool is_dark;
  vec2 fit;          // of cut chords: middle and half length of the part of s where g is sampled
  vec3 middle;       // light, h and rho at the middle
};

// From all of the rectangle's places.
const uint kAlive = 1u;           // some of the ray is in the slab
const uint kUnlit = 2u;           // none is
const uint kThick = 4u;           // the beam is not widened (thin.glsl)
const uint kFromLens = 8u;        // the line begins at the slab
const uint kFromEye = 16u;
const uint kToRange = 32u;        // and ends there
const uint kToPlane = 64u;
const uint kForward = 128u;       // the ray runs as the light does
const uint kBackward = 256u;
const uint kLongBefore = 512u;    // the near end is clearly outside the rim
const uint kCutBefore = 1024u;    // and clearly inside
const uint kLongAfter = 2048u;
const uint kCutAfter = 4096u;
const uint kLong = 8192u;         // the lit part is not short
const uint kNearWithin = 16384u;  // the nearest of several surfaces is before the end of the slab
const uint kNearBeyond = 32768u;  // and behind it

bool has(uint bits, uint all) { return (bits & all) == all; }

// Whether records may have the far ends of their pixels (tile_surfaces.glsl).
#ifdef FL_TILE_SURFACES
const bool kTileSurfaces = true;
#else
const bool kTileSurfaces = false;
#endif
// What float loses of a place is 1e-3 of the beam's radius, or less.
bool surfaces_known(BeamRow row) { return row.x_axis.w > 2e-4 * length(row.eye.xyz); }

// Call only for beams for which tile_knows() is true.
TileGuess tile_guess(BeamRow row, Rect rect) {
  TileGuess guess = TileGuess(0u, false, vec2(0.0, 1.0), vec3(0.0));
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  bool thin = thin_in_haze_applies(row);
  vec3 eye = row.eye.xyz;
  uint bits = 0xffffffffu;
  float rho_min = 1e30;
  float rho_max = -1e30;
  float a_min = 1e30;  // s at the ends of the line
  float a_max = -1e30;
  float b_min = 1e30;
  float b_max = -1e30;
  float free_min = 1e30;  // s at the nearest of several surfaces
  float slab_min = 1e30;  // s at the end of the slab
  vec2 first = vec2(0.0);
  float turn = 1.0;  // cosine between the lines of two places
  for (uint i = 0u; i < 5u; ++i) {
    vec2 at = rect.middle;  // of the last round
    if (i < 4u) at += rect.half_px / FL_HULL * (vec2(uvec2(i & 1u, i >> 1)) * 2.0 - 1.0);
    vec3 through = ray_through(at);
    float ray_length = length(through);
    vec3 ray = to_light(row, through / ray_length);
    float end_m = rect.depth.is_plane ? plane_distance(rect.depth, at, ray_length) : rect.depth.far_m;
    uint own = kThick;
    if (thin) {
      float radius;
      float wide;
      thin_meets(beam, row, eye, ray, 1.0 / ray_length, end_m, radius, wide);
      if (!(wide < 0.8 * radius * thin_scale(beam, tile_knows(row)))) own = 0u;
    }
    Chord chord;
    ChordLine line;
    beam_line(beam, eye, ray, 0.0, FL_FAR_M, chord, line);
    float slab_from_m = line.t_from_m;
    float slab_to_m = line.t_to_m;
    slab_min = min(slab_min, line.s_b);
    // A line that the surface cuts may have its base outside the slab; the places it passes are those of the whole one.
    float offset = chord.offset;
    vec2 along = chord.along;
    bool ends = kSolids && end_m < slab_to_m;  // at the surface
    if (ends) beam_line(beam, eye, ray, 0.0, end_m, chord, line);
    own |= rect.depth.near_m < slab_to_m ? kNearWithin : kNearBeyond;
    if (kSolids && !rect.depth.is_plane && rect.depth.near_m < slab_to_m) {
      float past_m = rect.depth.near_m - chord.t_base_m;
      float free = chord.s_base + chord.v_length * past_m /
                                      (chord.w_base * max(chord.w_base + past_m * chord.w_slope, 1e-9));
      free_min = min(free_min, rect.depth.near_m > slab_from_m ? free : -1e30);
    }
    own |= line.t_to_m > line.t_from_m ? kAlive : slab_to_m > slab_from_m && !rect.depth.is_plane ? 0u : kUnlit;
    own |= slab_from_m > 0.0 ? kFromLens : kFromEye;
    own |= ends ? kToPlane : kToRange;
    own |= ray.z > 0.0 ? kForward : kBackward;
    float half_chord = sqrt(max(1.0 - offset * offset, 0.0));
    float before = line.s_a + half_chord;  // how far the end is inside the rim
    float after = half_chord - line.s_b;
    own |= (before <= -kEndSlack ? kLongBefore : 0u) | (before >= kEndSlack ? kCutBefore : 0u) |
           (after <= -kEndSlack ? kLongAfter : 0u) | (after >= kEndSlack ? kCutAfter : 0u);
    if (min(line.s_b, half_chord) - max(line.s_a, -half_chord) >= kShortestCut) own |= kLong;
    bits &= own;
    rho_min = min(rho_min, offset);
    rho_max = max(rho_max, offset);
    a_min = min(a_min, line.s_a);
    a_max = max(a_max, line.s_a);
    b_min = min(b_min, line.s_b);
    b_max = max(b_max, line.s_b);
    if (i == 0u) first = along;
    turn = min(turn, dot(along, first));
  }
  guess.is_dark = has(bits, kUnlit);
  if (guess.is_dark || !(turn > kAlongMin) || !has(bits, kThick)) return guess;
  float nearest = rho_min <= 0.0 && rho_max >= 0.0 ? 0.0 : min(abs(rho_min), abs(rho_max));
  float farthest = max(abs(rho_min), abs(rho_max));
  float inner = max(nearest - 0.1 * (rho_max - rho_min), 0.0);
  float longest = sqrt(max(1.0 - inner * inner, 0.0)) + 0.05;  // half of the longest chord, with slack
  // Between the places s may pass the values there, by what the line turns.
  float far_enough = 1.1 * longest;
  bool steady = has(bits, kAlive) && turn > kAlongSteady;
  // The far end is one function of the place where it is the same plane everywhere, or the distance of the farthest.
  bool one_way = (bits & (kForward | kBackward)) != 0u;
  bool ends_alike = has(bits, kToPlane) || (has(bits, kToRange) && one_way);
  guess.is_dark = inner >= 1.0 || (steady && ((ends_alike && b_max <= -far_enough) || a_min >= far_enough));
  if (guess.is_dark || !has(bits, kAlive) || !(brightest(row.j0.rgb) > 0.0)) return guess;
  bool free = has(bits, kNearBeyond) || (has(bits, kNearWithin) && free_min >= longest);
  bool surfaces = kSolids && !rect.depth.is_plane && !free;
  float q_min = 1.0 - farthest * farthest;
  bool inside = q_min > 0.0 && q_min >= kRatioMin * (1.0 - nearest * nearest);
  bool whole_before = a_max <= -longest;
  bool whole_after = b_min >= longest;
  if (surfaces && !(kTileSurfaces && whole_before && slab_min >= longest && surfaces_known(row))) return guess;
  if (whole_before && whole_after && !surfaces) {
    guess.bits = kGuessWhole | kGuessRecord | (inside ? kGuessSmooth : 0u);
    guess.fit.y = clamp(longest, kFitHalfMin, 1.0);
  } else {
    bool from_one = (bits & (kFromLens | kFromEye)) != 0u;
    bool to_one = (bits & (kToRange | kToPlane)) != 0u;
    bool alike = !surfaces && has(bits, kLong) && (has(bits, kLongBefore) || (has(bits, kCutBefore) && from_one)) &&
                 (has(bits, kLongAfter) || (has(bits, kCutAfter) && to_one)) && q_min > 0.02 && inside;
    bool moments = has_moments(beam);
    bool record = moments && (whole_before || has(bits, kFromEye) || (from_one && one_way)) &&
                  (whole_after || has(bits, kToPlane) || (to_one && one_way));
    if (!alike && !record) return guess;
    guess.bits = kGuessCut | (alike ? kGuessSmooth : 0u) | (record ? kGuessRecord : 0u) |
                 (whole_before ? 0u : kGuessCutBefore) | (whole_after ? 0u : kGuessCutAfter) |
                 (surfaces ? kGuessSurfaces : 0u);
    float low = max(a_min, -longest);
    float high = min(b_max, longest);
    guess.fit = vec2(0.5 * (low + high), max(0.5 * (high - low), kFitHalfMin));
  }
  return guess;
}

// Light, h and rho at the rectangle's middle.
vec3 light_at_middle(BeamRow row, Rect rect) {
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  Chord chord;
  ChordLine line;
  vec3 ray;
  line_at(beam, row, rect, rect.middle, chord, line, ray);
  TileNode node = tile_node(beam, Medium(params.anisotropy, params.position.w), chord, line, ray, has_many_nodes(beam),
                            kExtinction);
  return vec3(node.light, node.h, chord.offset);
}

// The share of the polynomial's value at the middle that this lane's coefficients give: T_2(0) = -1, T_1(0) = T_3(0) =
// 0. degree: terms with a higher m + n do not count.
float at_middle(float f[kPer], uint degree) {
  float sum = 0.0;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    bool counts = ((place.x | place.y) & 1u) == 0u && place.x + place.y <= degree;
    sum += counts ? (place.x == place.y ? f[k] : -f[k]) : 0.0;
  }
  return sum;
}
// What quadratics leave out, this lane's share.
float quadratic_tail(float f[kPer]) {
  float tail = 0.0;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    if (place.x + place.y >= 3u) tail += abs(f[k]);
  }
  return tail;
}

// The beam at this lane's nodes.
float node_light[kPer];  // of kSmooth
float node_rho[kPer];
vec3 node_g[kPer];     // of cut chords g_0, g_1, g_2; of whole ones x: h
vec2 node_ends[kPer];  // s_a, s_b

void compute_nodes(BeamRow row, Rect rect, bool whole, vec2 fit) {
  Medium medium = Medium(params.anisotropy, params.position.w);
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  bool many = has_many_nodes(beam);
  bool moments = has_moments(beam);
  bool three = whole ? !many : moments;
  FL_LANE_NODES(k) {
    Chord chord;
    ChordLine line;
    vec3 ray;
    line_at(beam, row, rect, rect.middle + rect.half_px * node_position(k), chord, line, ray);
    node_rho[k] = chord.offset;
    node_ends[k] = vec2(line.s_a, line.s_b);
    if ((kProfile || kNodes > 3u) && !three) {
      TileNode node = tile_node(beam, medium, chord, line, ray, many, kExtinction);
      node_g[k] = vec3(node.h, 0.0, 0.0);
      node_light[k] = node.light;
    } else {
      float q = 1.0 - chord.offset * chord.offset;
      float at = whole ? 0.0 : fit.x;
      float away = whole ? kRimNode3 * min(sqrt(abs(q)), 1.0) : kFitNode * fit.y;
      float half_length = whole ? min(sqrt(abs(q)), 1.0) : fit.y;
      float inverse = 1.0 / max(chord.v_length, 1e-12);
      float center = inverse * tile_integrand(beam, medium, chord, line, ray, at, 0.0, true, kExtinction)
          FL_TIMES_DENSITY(at, 0.35 * half_length);
      float before = inverse * tile_integrand(beam, medium, chord, line, ray, at - away, 0.0, true, kExtinction)
          FL_TIMES_DENSITY(at - away, 0.3 * half_length);
      float after = inverse * tile_integrand(beam, medium, chord, line, ray, at + away, 0.0, true, kExtinction)
          FL_TIMES_DENSITY(at + away, 0.3 * half_length);
      if (whole) {
        float pair = before + after;
        if (q < 0.0) pair = 4.0 * center - pair;
        node_g[k] = vec3(kRimMiddle3 * center + kRimWeight3 * pair, 0.0, 0.0);
        node_light[k] = node_g[k].x * rim_factor(max(q, 0.0), 1.0);
      } else {
        node_g[k] = cut_fit(before, center, after, fit.x, fit.y);
        node_light[k] = dot(node_g[k], cut_moments(max(q, 0.0), line.s_a, line.s_b));
      }
    }
  }
}

// The tests add what the polynomials leave out, their last terms, and what they miss at the middle, since the terms of
// a light that is even about the middle are zero. They are written so that NaN fails. allowed: largest error of the
// light over J0 and sigma_s. All lanes of a subgroup call them together, with one beam a team.
// The error of what is subtracted, of a beam with that light: that of the nodes of a dark part.
const float kSubtractedShare = 1e-3;
float subtracted(uint bits, float size) { return (bits & kGuessShadowed) != 0u ? kSubtractedShare * size : 0.0; }

bool is_smooth(float allowed, uint bits, vec3 middle) {
  float f[kPer];
  FL_LANE_NODES(k) f[k] = node_light[k];
  to_coefficients(f);
  float tail = 0.0;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    if (max(place.x, place.y) == 3u) tail += abs(f[k]);
  }
  vec2 sums = team_sum(vec2(tail, at_middle(f, 6u)));
  float size = abs(team_first(f[0]));
  float over = sums.x + abs(middle.x - sums.y);
  return over + subtracted(bits, size) <= allowed && over <= kTailMax * size;
}

// As is_smooth(), for a beam with whole chords that is smooth but for its rim: coefficients of rho and of h. Those with
// m + n > 2 are left out of a record.
bool fit_rim(float allowed, uint bits, vec3 middle, out float rho[kPer], out float h[kPer]) {
  FL_LANE_NODES(k) rho[k] = node_rho[k];
  to_coefficients(rho);
  FL_LANE_NODES(k) h[k] = node_g[k].x;
  to_coefficients(h);
  float size = abs(team_first(h[0]));
  vec4 sums = team_sum(vec4(quadratic_tail(rho), quadratic_tail(h), at_middle(rho, 2u), at_middle(h, 2u)));
  float rho_over = sums.x + abs(middle.z - sums.z);
  float over = sums.y + abs(middle.y - sums.w);
  // q^(p + 1/2) changes by at most 2 for a change of rho by 1.
  return over + 2.0 * size * rho_over + subtracted(bits, size) <= allowed && over <= kTailMax * size &&
         rho_over <= kOffsetTailMax;
}
// The same for a beam whose chords are cut: coefficients of rho, g_0, g_1, g_2, s_a and s_b. bits: TileGuess::bits.
struct CutFits {
  float of[6][kPer];
};
bool fit_cut(float allowed, uint bits, vec3 middle, out CutFits fits) {
  bool cut_before = (bits & kGuessCutBefore) != 0u;
  bool cut_after = (bits & kGuessCutAfter) != 0u;
  FL_LANE_NODES(k) {
    fits.of[0][k] = node_rho[k];
    fits.of[1][k] = node_g[k].x;
    fits.of[2][k] = node_g[k].y;
    fits.of[3][k] = node_g[k].z;
    fits.of[4][k] = cut_before ? node_ends[k].x : -4.0;
    fits.of[5][k] = cut_after ? node_ends[k].y : 4.0;
  }
  [[unroll]] for (uint i = 0u; i < 6u; ++i) to_coefficients(fits.of[i]);
  float size = abs(team_first(fits.of[1][0]));
  // What the light misses for what g_0, g_1, g_2 miss: the largest |M_0|, |M_1|, |M_2| of a disc.
  vec4 sums = team_sum(vec4(quadratic_tail(fits.of[0]),
                            1.34 * quadratic_tail(fits.of[1]) + 0.25 * quadratic_tail(fits.of[2]) +
                                0.27 * quadratic_tail(fits.of[3]),
                            quadratic_tail(fits.of[4]) + quadratic_tail(fits.of[5]), at_middle(fits.of[0], 2u)));
  vec4 at = team_sum(vec4(at_middle(fits.of[1], 2u), at_middle(fits.of[2], 2u), at_middle(fits.of[3], 2u),
                          at_middle(fits.of[4], 2u)));
  float to = team_sum(vec2(at_middle(fits.of[5], 2u), 0.0)).x;
  float rho_over = sums.x + abs(middle.z - sums.w);
  float light = dot(at.xyz, cut_moments(max(1.0 - sums.w * sums.w, 0.0), at.w, to));
  float over = sums.y + size * sums.z + abs(middle.x - light);
  return over + 2.0 * size * rho_over + subtracted(bits, size) <= allowed && sums.y <= kTailMax * size &&
         rho_over <= kOffsetTailMax && sums.z <= 2.0 * kOffsetTailMax;
}
// Where a record's coefficient of node (m, n) stands; 6 and more: nowhere.
uint coefficient_slot(uvec2 place) {
  uint order = place.x + place.y;
  return order == 0u ? 0u : order == 1u ? 1u + place.y : order == 2u ? 3u + place.y : 6u;
}
