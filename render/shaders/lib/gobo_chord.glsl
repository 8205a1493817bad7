// Light in the haze of a beam with images in it, for any pass: gobo_inscatter(). After forms.glsl, gobo.glsl, gauss.h
// and beam.h.
//
// One sharp image has tables (the pass of gobos builds them): a chord across the whole disc is one texel, four weights
// of the nodes of W. A chord that is cut, by a surface, a blade or an iris, is sums along lines of the nearest of 64
// directions, piece by piece, of one that frost blurs several of these; a short one is samples. Whatever else stands in
// a beam is samples.
#include "render/shaders/shared/gobo_chord.h"
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
layout(constant_id = FL_SPEC_GOBO_METHOD) const uint kGoboMethod = FL_GOBO_TABLES;
layout(set = 0, binding = FL_BINDING_GOBO_WHOLE) uniform sampler2DArray gobo_whole;
layout(set = 0, binding = FL_BINDING_GOBO_LINES) uniform sampler2DArray gobo_lines;

// Chords that are shorter, in radii of the image, are sampled, at most so often.
const float kShortChord = 0.25;
const uint kShortTaps = 32u;
// A texel and a half of an image, in its radii: samples nearer to each other show nothing new.
const float kTapStep = 1.5 * 2.0 / 512.0;
// Of a chord's pieces, in the same unit.
const float kPieceLength = 0.125;

// The angle of a straight line, in half turns, 0 to 1, within 3e-6. Polynomial 4.4.49 of Abramowitz and Stegun.
float half_turns(vec2 way) {
  vec2 size = abs(way);
  float r = min(size.x, size.y) / max(max(size.x, size.y), 1e-30);
  float q = r * r;
  float angle = r * (0.9998660 + q * (-0.3302995 + q * (0.1801410 + q * (-0.0851330 + q * 0.0208351))));
  if (size.y > size.x) angle = 1.5707963267948966 - angle;
  if ((way.x < 0.0) != (way.y < 0.0)) angle = 3.141592653589793 - angle;
  return angle * 0.3183098861837907;
}

// Where entry `at` of `count` lies in a texture of `size` texels of which the table begins at `first`.
float gobo_texel(float at, float first, float size) { return (first + at + 0.5) / size; }
float gobo_offset_texel(float offset, float count) {
  return gobo_texel((0.5 * offset + 0.5) * (count - 1.0), 0.0, count);
}

// A chord across the whole disc. way: its direction in the image.
vec3 gobo_whole_chord(uint layer, uint planes, Chord chord, ChordWeight weight, vec2 way) {
  bool back = way.y < 0.0;  // the last row of the table has the direction (-1, 0)
  vec4 w = vec4(weight.at_node[0], weight.at_node[1], weight.at_node[2], weight.at_node[3]);
  if (back) w = w.wzyx;
  vec2 at = vec2(gobo_offset_texel(back ? -chord.offset : chord.offset, float(FL_GOBO_CHORDS)),
                 gobo_texel(half_turns(way) * float(FL_GOBO_ANGLES), 0.0, float(FL_GOBO_ANGLES + 1)));
  vec3 light = vec3(dot(textureLod(gobo_whole, vec3(at, float(layer - 1u)), 0.0), w));
  if (planes > 1u) {
    light.g = dot(textureLod(gobo_whole, vec3(at, float(layer)), 0.0), w);
    light.b = dot(textureLod(gobo_whole, vec3(at, float(layer + 1u)), 0.0), w);
  }
  return max(light, vec3(0.0)) * chord_measure(chord);
}

// Samples and pieces are taken four at a time, so that four times as many texels are on their way: the loops wait for
// them, not for arithmetic.

// A cut chord from `from` to `to` in the image, in one colour.
float gobo_lines_plane(float layer, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to) {
  vec2 way = to - from;
  uint direction = uint(half_turns(way) * float(FL_GOBO_DIRECTIONS) + 0.5) % uint(FL_GOBO_DIRECTIONS);
  float angle = float(direction) * (3.141592653589793 / float(FL_GOBO_DIRECTIONS));
  vec2 along = vec2(cos(angle), sin(angle));
  vec2 aside = vec2(along.y, -along.x);
  float s_length = dot(way, along);
  uint fours = uint(clamp(ceil(abs(s_length) / (4.0 * kPieceLength)), 2.0, 4.0));
  float piece = 0.25 / float(fours);
  // Rows and columns of the texture, from 0 to 1, at x = 0, and how far they move for x = 1.
  const float kRows = float(FL_GOBO_DIRECTIONS * FL_GOBO_NODES);
  const float kRowsOfOne = 0.5 * float(FL_GOBO_NODES - 1) / kRows;
  float row_least = (float(direction * uint(FL_GOBO_NODES)) + 0.5) / kRows;
  float row_most = row_least + 2.0 * kRowsOfOne;
  float s_from = dot(from, along);
  float row_from = row_least + (s_from + 1.0) * kRowsOfOne;
  float row_length = s_length * kRowsOfOne;
  float column_from = gobo_offset_texel(dot(from, aside), float(FL_GOBO_LINES));
  float column_length = 0.5 * float(FL_GOBO_LINES - 1) / float(FL_GOBO_LINES) * dot(way, aside);
  float inverse = 1.0 / s_length;
  float total = 0.0;
  for (uint four = 0u; four < fours; ++four) {
    float x = (float(4u * four) + 0.5) * piece;
    vec2 sums[4];
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float at = x + float(i) * piece;
      float column = column_from + at * column_length;
      float high = clamp(row_from + (at + 0.5 * piece) * row_length, row_least, row_most);
      float low = clamp(row_from + (at - 0.5 * piece) * row_length, row_least, row_most);
      sums[i] = textureLod(gobo_lines, vec3(column, high, layer), 0.0).xy -
                textureLod(gobo_lines, vec3(column, low, layer), 0.0).xy;
    }
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float at = x + float(i) * piece;
      float mass = 2.0 * sums[i].x * inverse;
      float middle = mass > 1e-6 ? (sums[i].y * inverse / mass - (s_from + at * s_length)) * inverse : 0.0;
      middle = at + clamp(middle, -0.5 * piece, 0.5 * piece);
      float s = chord.s_from + middle * (chord.s_to - chord.s_from);
      vec2 rho = s * chord.along + chord.offset * vec2(chord.along.y, -chord.along.x);
      total += mass * beam_value(beam, rho, s * s + chord.offset * chord.offset) * chord_weight_at(weight, middle);
    }
  }
  return total * chord_measure(chord);
}

// A cut chord. Frost blurs it by a radius `blur`: the mean of straight lines beside it, by Gauss's rule for the shadow
// of the blur's disc. A shift along the chord is left out; it would change its ends alone.
const uint kBlurLines = 6u;
vec3 gobo_lines_chord(uint layer, uint planes, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to,
                      float blur) {
  uint count = blur > 0.0 ? kBlurLines : 1u;
  vec2 aside = blur * normalize(to - from).yx * vec2(1.0, -1.0);
  vec3 total = vec3(0.0);
  // One loop over colours and lines, so that the code of a line is there once.
  for (uint i = 0u; i < planes * count; ++i) {
    float angle = 3.141592653589793 / float(count + 1u) * float(i % count + 1u);
    float share = 2.0 / float(count + 1u) * sin(angle) * sin(angle);
    vec2 shift = cos(angle) * aside;
    uint plane = i / count;
    float light = share * gobo_lines_plane(float(layer - 1u + plane), beam, chord, weight, from + shift, to + shift);
    total += light * vec3(plane == 0u, plane == 1u, plane == 2u);
  }
  return planes == 1u ? vec3(total.r) : total;
}

// A short chord from `from` to `to` in the image.
vec3 gobo_short_chord(uint image, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to) {
  uint fours = uint(clamp(distance(from, to) / (4.0 * kTapStep) + 1.0, 1.0, float(kShortTaps / 4u)));
  float part = 0.25 / float(fours);
  vec3 total = vec3(0.0);
  for (uint four = 0u; four < fours; ++four) {
    float x = (float(4u * four) + 0.5) * part;
    vec3 through[4];
    [[unroll]] for (int i = 0; i < 4; ++i) {
      vec2 p = mix(from, to, x + float(i) * part);
      through[i] = textureLod(gobo_images, vec3(0.5 * p + 0.5, float(image - 1u)), 0.0).rgb;
    }
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float at = x + float(i) * part;
      float s = chord.s_from + at * (chord.s_to - chord.s_from);
      vec2 rho = s * chord.along + chord.offset * vec2(chord.along.y, -chord.along.x);
      total += through[i] *
               (beam_value(beam, rho, s * s + chord.offset * chord.offset) * chord_weight_at(weight, at));
    }
  }
  return total * (part * chord_measure(chord));
}

// The light along a chord of the beam that gobo_begin() was called with, over sigma_s J0. d: the ray in light space.
vec3 gobo_inscatter(BeamRow row, BeamShape beam, Medium medium, Chord chord, vec3 d, bool with_extinction) {
  const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
  gobo_sample = 0u;
  if (kGoboMethod == uint(FL_GOBO_MIDPOINTS) || (kWide && beam.spread > kWideSpread)) {
    return chord_inscatter_gobo(beam, medium, chord, d, kGoboTaps, with_extinction, row.gobo, as_it_is);
  }
  ChordWeight weight = chord_weight(beam, medium, chord, d, with_extinction);
  if (kGoboMethod == uint(FL_GOBO_TABLES)) {
    GoboImage only = gobo_only_image(row);
    uint lines = gobo_lines_layer(row, only);
    if (lines != 0u) {
      uint planes = gobo_tables[only.image - 1u].planes;
      uint whole = gobo_whole_layer(row, only);
      float nearer = min(chord.s_from * chord.s_from, chord.s_to * chord.s_to);
      vec2 turn = only.turn;
      if (whole != 0u && nearer + chord.offset * chord.offset > 0.998 && chord.s_from < 0.0 && chord.s_to > 0.0) {
        vec2 way = vec2(turn.x * chord.along.x + turn.y * chord.along.y,
                        turn.x * chord.along.y - turn.y * chord.along.x);
        return gobo_whole_chord(whole, planes, chord, weight, way);
      }
      vec2 across = chord.offset * vec2(chord.along.y, -chord.along.x);
      vec2 from = gobo_place(chord.s_from * chord.along + across);
      vec2 to = gobo_place(chord.s_to * chord.along + across);
      from = vec2(turn.x * from.x + turn.y * from.y, turn.x * from.y - turn.y * from.x);
      to = vec2(turn.x * to.x + turn.y * to.y, turn.x * to.y - turn.y * to.x);
      bool sharp = gobo_is_sharp(row);
      if (distance(from, to) > kShortChord) {
        float blur = sharp ? 0.0 : row.gobo_blur;
        return gobo_lines_chord(lines, planes, beam, chord, weight, from, to, blur);
      }
      if (sharp) return gobo_short_chord(only.image, beam, chord, weight, from, to);
    }
  }
  return chord_inscatter_taps(beam, chord, weight, d, kGoboTaps, row.gobo, as_it_is);
}
