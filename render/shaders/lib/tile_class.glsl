// What one beam is over one rectangle of pixels, decided at 4 x 4 Chebyshev nodes: dark; smooth, so that its light is a
// polynomial; smooth but for its rim, so that h and the line's offset rho are (shared/tile_node.h); or none of these.
// After beam.h, tile_node.h, tile_test.glsl, thin.glsl, tile_depth.glsl. Design and error: docs/decisions/0100.
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

const uint kDark = 0u;
const uint kSmooth = 1u;
const uint kRim = 2u;
const uint kGeneral = 3u;

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

// The polynomials of the beam that was classified last. Light: sum of fit_light[4 n + m] T_m(x) T_n(y), x and y from -1
// to 1 over the hull. rho and h: 1, x, y, x^2, x y, y^2.
float fit_light[16];
float fit_rho[6];
float fit_h[6];

float brightest(vec3 rgb) { return max(rgb.r, max(rgb.g, rgb.b)); }

// Whether the beam has a light that tile_node() knows.
bool tile_knows(BeamRow row) {
  bool plain = row.j0.w == 0.0 && row.measured == 0u && row.squeeze == 0.0 && (row.flags & FL_BEAM_BLADES) == 0u &&
               row.y_axis.w <= kWideSpread;
  return plain && !has_gobo(row);
}

// From coefficients of T_m T_n, m + n <= 2, to 1, x, y, x^2, x y, y^2.
void powers_of(inout float c[6]) {
  c[0] -= c[3] + c[5];
  c[3] *= 2.0;
  c[5] *= 2.0;
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

// tolerance: largest error of this beam's light over sigma_s, in its brightest channel. Call only for beams for which
// tile_knows() and beam_touches() are true.
uint tile_class(BeamRow row, Rect rect, float tolerance) {
  const float kAt[4] = float[4](0.92387953, 0.38268343, -0.38268343, -0.92387953);
  const float kTwo[4] = float[4](0.70710678, -0.70710678, -0.70710678, 0.70710678);
  const float kThree[4] = float[4](0.38268343, -0.92387953, 0.92387953, -0.38268343);
  Medium medium = Medium(params.anisotropy, params.position.w);
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  bool many = kNodes > 3u || (kProfile && beam.profile_power != 1.0);
  bool thin = thin_in_haze_applies(row);
  vec3 eye = row.eye.xyz;
  [[unroll]] for (int i = 0; i < 16; ++i) fit_light[i] = 0.0;
  float rho_tail[4] = float[4](0.0, 0.0, 0.0, 0.0);
  float h_tail[4] = float[4](0.0, 0.0, 0.0, 0.0);
  [[unroll]] for (int i = 0; i < 6; ++i) {
    fit_rho[i] = 0.0;
    fit_h[i] = 0.0;
  }
  float rho_min = 1e30;
  float rho_max = -1e30;
  float a_min = 1e30;  // s at the ends of the line
  float a_max = -1e30;
  float b_min = 1e30;
  float b_max = -1e30;
  float free_min = 1e30;       // s at the nearest surface of a rectangle that shows several
  float shortest = 1e30;       // lit part
  float cut_before = 1e30;     // how far the near end is behind the rim, least and most
  float cut_before_max = -1e30;
  float cut_after = 1e30;
  float cut_after_max = -1e30;
  bool any_alive = false;
  bool all_alive = true;
  bool same_side = true;
  bool thick = true;
  bool from_lens = true;  // the line begins at the slab
  bool from_eye = true;
  bool to_range = true;  // and ends there
  bool to_plane = true;
  vec2 along = vec2(0.0);
  for (int j = 0; j < 4; ++j) {
    vec4 light = vec4(0.0);
    vec4 rho = vec4(0.0);
    vec4 h = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
      vec2 at = rect.middle + rect.half_px * vec2(kAt[i], kAt[j]);
      vec3 through = ray_through(at);
      float ray_length = length(through);
      vec3 ray = to_light(row, through / ray_length);
      float end_m = rect.depth.is_plane ? plane_distance(rect.depth, at, ray_length) : rect.depth.far_m;
      if (thin) {
        float own;
        float wide;
        thin_meets(beam, row, eye, ray, 1.0 / ray_length, end_m, own, wide);
        thick = thick && wide < 0.8 * own * thin_scale(beam, true);
      }
      Chord chord;
      ChordLine line;
      beam_line(beam, eye, ray, 0.0, FL_FAR_M, chord, line);
      float slab_from_m = line.t_from_m;
      float slab_to_m = line.t_to_m;
      if (i == 0 && j == 0) along = chord.along;
      same_side = same_side && dot(chord.along, along) > kAlongMin;
      // Where the surface ends the ray.
      bool ends = end_m < slab_to_m;
      if (kSolids) {
        if (ends) beam_line(beam, eye, ray, 0.0, end_m, chord, line);
        if (!rect.depth.is_plane) {
          // Free of the surfaces: the light ends before the nearest one.
          float free = 1e30;
          if (rect.depth.near_m < slab_to_m) {
            float past_m = rect.depth.near_m - chord.t_base_m;
            free = rect.depth.near_m > slab_from_m
                       ? chord.s_base + chord.v_length * past_m /
                                            (chord.w_base * max(chord.w_base + past_m * chord.w_slope, 1e-9))
                       : -1e30;
          }
          free_min = min(free_min, free);
        }
      }
      TileNode node = tile_node(beam, medium, chord, line, ray, many, kExtinction);
      any_alive = any_alive || node.alive;
      all_alive = all_alive && node.alive;
      from_lens = from_lens && slab_from_m > 0.0;
      from_eye = from_eye && slab_from_m <= 0.0;
      to_range = to_range && !ends;
      to_plane = to_plane && ends;
      rho_min = min(rho_min, chord.offset);
      rho_max = max(rho_max, chord.offset);
      a_min = min(a_min, line.s_a);
      a_max = max(a_max, line.s_a);
      b_min = min(b_min, line.s_b);
      b_max = max(b_max, line.s_b);
      cut_before = min(cut_before, line.s_a + node.half_chord);
      cut_before_max = max(cut_before_max, line.s_a + node.half_chord);
      cut_after = min(cut_after, node.half_chord - line.s_b);
      cut_after_max = max(cut_after_max, node.half_chord - line.s_b);
      shortest = min(shortest, min(line.s_b, node.half_chord) - max(line.s_a, -node.half_chord));
      vec4 t = vec4(1.0, kAt[i], kTwo[i], kThree[i]);
      light += node.light * t;
      rho += chord.offset * t;
      h += node.h * t;
    }
    [[unroll]] for (int m = 0; m < 4; ++m) {
      fit_light[m] += light[m];
      fit_light[4 + m] += kAt[j] * light[m];
      fit_light[8 + m] += kTwo[j] * light[m];
      fit_light[12 + m] += kThree[j] * light[m];
    }
    fit_rho[0] += rho.x;
    fit_rho[1] += rho.y;
    fit_rho[2] += kAt[j] * rho.x;
    fit_rho[3] += rho.z;
    fit_rho[4] += kAt[j] * rho.y;
    fit_rho[5] += kTwo[j] * rho.x;
    rho_tail[0] += rho.w;
    rho_tail[1] += kAt[j] * rho.z;
    rho_tail[2] += kTwo[j] * rho.y;
    rho_tail[3] += kThree[j] * rho.x;
    fit_h[0] += h.x;
    fit_h[1] += h.y;
    fit_h[2] += kAt[j] * h.x;
    fit_h[3] += h.z;
    fit_h[4] += kAt[j] * h.y;
    fit_h[5] += kTwo[j] * h.x;
    h_tail[0] += h.w;
    h_tail[1] += kAt[j] * h.z;
    h_tail[2] += kTwo[j] * h.y;
    h_tail[3] += kThree[j] * h.x;
  }
  if (!any_alive) return kDark;
  if (!same_side || !thick) return kGeneral;
  float nearest = rho_min <= 0.0 && rho_max >= 0.0 ? 0.0 : min(abs(rho_min), abs(rho_max));
  float farthest = max(abs(rho_min), abs(rho_max));
  float inner = max(nearest - 0.1 * (rho_max - rho_min), 0.0);
  if (inner >= 1.0) return kDark;
  float longest = sqrt(max(1.0 - inner * inner, 0.0)) + 0.05;  // half of the longest chord, with slack
  if (all_alive && (b_max <= -longest || a_min >= longest)) return kDark;
  if (kSolids && !rect.depth.is_plane && !(free_min >= longest)) return kGeneral;
  if (!all_alive) return kGeneral;

  float q_min = 1.0 - farthest * farthest;
  float q_max = 1.0 - nearest * nearest;
  bool whole = b_min >= longest && a_max <= -longest;
  bool inside = q_min > 0.0 && q_min >= kRatioMin * q_max;
  bool smooth_light = whole && inside;
  if (!whole) {
    bool before = cut_before_max <= -kEndSlack || (cut_before >= kEndSlack && (from_lens || from_eye));
    bool after = cut_after_max <= -kEndSlack || (cut_after >= kEndSlack && (to_range || to_plane));
    if (!(before && after && shortest >= kShortestCut && q_min > 0.02 && inside)) return kGeneral;
    smooth_light = true;
  }
  // Coefficients from sums: 1/16, times 2 for each m > 0 and n > 0. The tests below add what the polynomials leave out:
  // their last terms, and what they miss at the middle, since the terms of a light that is even about the middle are
  // zero. They are written so that NaN is general.
  float lum = brightest(row.j0.rgb);
  if (!(lum > 0.0)) return kGeneral;
  float allowed = tolerance / lum;
  Chord chord;
  TileNode middle = node_at(row, beam, rect, rect.middle, many, chord);
  if (smooth_light) {
    [[unroll]] for (int n = 0; n < 4; ++n) {
      [[unroll]] for (int m = 0; m < 4; ++m) fit_light[4 * n + m] *= (m > 0 ? 0.125 : 0.0625) * (n > 0 ? 2.0 : 1.0);
    }
    float tail = abs(middle.light - (fit_light[0] - fit_light[2] - fit_light[8] + fit_light[10]));
    [[unroll]] for (int k = 0; k < 4; ++k) tail += abs(fit_light[12 + k]) + (k < 3 ? abs(fit_light[4 * k + 3]) : 0.0);
    if (tail <= allowed && tail <= kTailMax * abs(fit_light[0])) return kSmooth;
    if (!whole) return kGeneral;
  }
  const float kScale[6] = float[6](0.0625, 0.125, 0.125, 0.125, 0.25, 0.125);
  [[unroll]] for (int k = 0; k < 6; ++k) {
    fit_rho[k] *= kScale[k];
    fit_h[k] *= kScale[k];
  }
  float rho_over = (abs(rho_tail[0]) + abs(rho_tail[3])) * 0.125 + (abs(rho_tail[1]) + abs(rho_tail[2])) * 0.25 +
                   abs(chord.offset - (fit_rho[0] - fit_rho[3] - fit_rho[5]));
  float h_over = (abs(h_tail[0]) + abs(h_tail[3])) * 0.125 + (abs(h_tail[1]) + abs(h_tail[2])) * 0.25 +
                 abs(middle.h - (fit_h[0] - fit_h[3] - fit_h[5]));
  // q^(p + 1/2) changes by at most 2 for a change of rho by 1.
  bool close = h_over <= allowed && h_over <= kTailMax * abs(fit_h[0]) &&
               2.0 * abs(fit_h[0]) * rho_over <= allowed && rho_over <= kOffsetTailMax;
  if (!close) return kGeneral;
  powers_of(fit_rho);
  powers_of(fit_h);
  return kRim;
}
