// Light in the haze of a beam with images in it, for any pass: gobo_inscatter(). After forms.glsl, gobo.glsl, gauss.h
// and beam.h.
//
// One sharp image has tables, and so has the image of a gate (the pass of gobos builds them): a chord across the whole
// disc is one texel, four weights of the nodes of W. A chord that is cut, by a surface, a blade or an iris, is sums
// along lines of the nearest of 64 directions, piece by piece. One that frost or the focus blurs is several of these. A
// short one is samples. Whatever else stands in a beam is samples.
#include "render/shaders/shared/gobo_chord.h"
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_whole.glsl"
#include "render/shaders/lib/gobo_blurs.glsl"
layout(set = 0, binding = FL_BINDING_GOBO_BLURS) uniform sampler2DArray gobo_blurs;
layout(constant_id = FL_SPEC_GOBO_METHOD) const uint kGoboMethod = FL_GOBO_TABLES;
layout(set = 0, binding = FL_BINDING_GOBO_LINES) uniform sampler2DArray gobo_lines;
#include "render/shaders/lib/gate_image.glsl"

// Chords that are shorter, in radii of the image, are sampled, at most so often.
const float kShortChord = 0.25;
const uint kShortTaps = 32u;
// A texel and a half of an image of 512, in its radii: samples nearer to each other show nothing new of its edges.
const float kTapStep = 1.5 * 2.0 / 512.0;

// A chord across the whole disc. way: its direction in the image.
vec3 gobo_whole_chord(uint layer, uint planes, Chord chord, ChordWeight weight, vec2 way) {
  vec4 w = vec4(weight.at_node[0], weight.at_node[1], weight.at_node[2], weight.at_node[3]);
  return gobo_whole_mean(layer, planes, chord.offset, way, w) * chord_measure(chord);
}

// Samples and pieces are taken four at a time, so that four times as many texels are on their way: the loops wait for
// them, not for arithmetic.

// An image as it stands in a beam, with its tables.
struct GoboTables {
  uint image;
  uint gate;    // as GoboTableRow::gate
  uint planes;
  uint lines;   // first layers, plus 1; 0: none
  uint whole;
  uint blurs;   // none without a focus
};
vec3 gobo_through(GoboTables tables, vec2 p) {
  p = 0.5 * p + 0.5;
  if (tables.gate != 0u) return gate_image(tables.gate - 1u, tables.planes, p);
  return textureLod(gobo_images, vec3(p, float(tables.image - 1u)), 0.0).rgb;
}

// Where the place s of a chord lies in an image that is turned.
vec2 gobo_end(Chord chord, float s, vec2 turn) {
  vec2 at = gobo_place(s * chord.along + chord.offset * vec2(chord.along.y, -chord.along.x));
  return vec2(turn.x * at.x + turn.y * at.y, turn.x * at.y - turn.y * at.x);
}

// The profile times W at a share `at` of the chord.
float gobo_light_at(BeamShape beam, Chord chord, ChordWeight weight, float at) {
  float s = chord.s_from + at * (chord.s_to - chord.s_from);
  vec2 rho = s * chord.along + chord.offset * vec2(chord.along.y, -chord.along.x);
  return beam_value(beam, rho, s * s + chord.offset * chord.offset) * chord_weight_at(weight, at);
}

// Samples of the stretch x_from..x_to of a chord from `from` to `to` in the image, four at a time; over the chord's
// measure.
vec3 gobo_stretch(GoboTables tables, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to, float x_from,
                  float x_to, uint fours) {
  float part = 0.25 * (x_to - x_from) / float(fours);
  vec3 total = vec3(0.0);
  for (uint four = 0u; four < fours; ++four) {
    float x = x_from + (float(4u * four) + 0.5) * part;
    vec3 through[4];
    [[unroll]] for (int i = 0; i < 4; ++i) through[i] = gobo_through(tables, mix(from, to, x + float(i) * part));
    [[unroll]] for (int i = 0; i < 4; ++i) {
      total += through[i] * gobo_light_at(beam, chord, weight, x + float(i) * part);
    }
  }
  return part * total;
}

// A cut chord from `from` to `to` in the image, in one colour, over the chord's measure. Pieces begin and end at places
// of the table, since a sum between two places would be that of an even image. What is left at the ends is sampled.
float gobo_lines_plane(GoboTables tables, uint plane, BeamShape beam, Chord chord, ChordWeight weight, vec2 from,
                       vec2 to) {
  vec2 way = to - from;
  uint direction = uint(half_turns(way) * float(FL_GOBO_DIRECTIONS) + 0.5) % uint(FL_GOBO_DIRECTIONS);
  float angle = float(direction) * (3.141592653589793 / float(FL_GOBO_DIRECTIONS));
  vec2 along = vec2(cos(angle), sin(angle));
  vec2 aside = vec2(along.y, -along.x);
  float s_length = dot(way, along);
  // In places of the table from the chord's beginning, whose direction is that of the table or its opposite.
  const float kHalf = 0.5 * float(FL_GOBO_NODES - 1);
  float u_from = clamp((dot(from, along) + 1.0) * kHalf, 0.0, 2.0 * kHalf);
  float u_to = clamp((dot(to, along) + 1.0) * kHalf, 0.0, 2.0 * kHalf);
  bool back = s_length < 0.0;
  int first = int(back ? floor(u_from) : ceil(u_from));
  int last = int(back ? ceil(u_to) : floor(u_to));
  int cells = last - first;
  int fours = clamp((abs(cells) + 15) / 16, 1, 4);
  float inverse = 1.0 / s_length;
  float s_from = dot(from, along);
  const float kRows = float(FL_GOBO_DIRECTIONS * FL_GOBO_NODES);
  float row_first = float(direction * uint(FL_GOBO_NODES)) + 0.5;
  float column_from = gobo_offset_texel(dot(from, aside), float(FL_GOBO_LINES));
  float column_length = 0.5 * float(FL_GOBO_LINES - 1) / float(FL_GOBO_LINES) * dot(way, aside);
  float layer = float(tables.lines - 1u + plane);
  float total = 0.0;
  for (int four = 0; four < fours; ++four) {
    vec2 sums[4];
    vec2 ends[4];
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float low = float(first + cells * (4 * four + i) / (4 * fours));
      float high = float(first + cells * (4 * four + i + 1) / (4 * fours));
      ends[i] = (vec2(low, high) / kHalf - 1.0 - s_from) * inverse;
      float column = column_from + 0.5 * (ends[i].x + ends[i].y) * column_length;
      sums[i] = textureLod(gobo_lines, vec3(column, (row_first + high) / kRows, layer), 0.0).xy -
                textureLod(gobo_lines, vec3(column, (row_first + low) / kRows, layer), 0.0).xy;
    }
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float mass = 2.0 * sums[i].x * inverse;
      float middle = mass > 1e-6 ? (sums[i].y * inverse / mass - s_from) * inverse : 0.0;
      total += mass * gobo_light_at(beam, chord, weight, clamp(middle, ends[i].x, ends[i].y));
    }
  }
  float x_first = (float(first) / kHalf - 1.0 - s_from) * inverse;
  float x_last = (float(last) / kHalf - 1.0 - s_from) * inverse;
  total += gobo_stretch(tables, beam, chord, weight, from, to, 0.0, x_first, 1u)[plane];
  total += gobo_stretch(tables, beam, chord, weight, from, to, x_last, 1.0, 1u)[plane];
  return total;
}

// Radii of the image's blur by the focus at both ends of a chord. The focus blurs by the distance from the lens: a ray
// through one point of the lens is straight in the gate, so between the ends its place beside the chord changes evenly
// with the place in the gate, and has the other sign beyond the focus.
vec2 gobo_shifts(BeamRow row, Chord chord, vec3 d) {
  if (!kFocus || row.focus < 0.0) return vec2(0.0);
  float s;
  vec2 t_m;
  chord_point(chord, 0.0, s, t_m.x);
  chord_point(chord, 1.0, s, t_m.y);
  vec2 z_m = chord.base.z + t_m * d.z;
  return vec2(focus_shift(row.x_axis.w, row.y_axis.w, z_m.x, row.focus),
              focus_shift(row.x_axis.w, row.y_axis.w, z_m.y, row.focus));
}
// Together with frost, which blurs alike everywhere.
vec2 gobo_line_blurs(BeamRow row, vec2 shifts) {
  vec2 blurs = vec2(row.gobo_blur > 1e-4 ? row.gobo_blur : 0.0);
  if (!kFocus || row.focus < 0.0) return blurs;
  // The wider of both counts. A little frost does not make lines parallel that cross in the focus.
  return all(greaterThan(abs(shifts), blurs)) ? shifts : max(blurs, abs(shifts));
}

// A cut or blurred chord: the mean of straight lines beside it, by Gauss's rule for the shadow of the blur's disc. A
// shift along the chord is left out; it would change its ends alone.
const uint kBlurLines = 6u;
const float kWidestBlur = 0.25;  // six lines lie too far apart in a wider one, as near a lens: docs/numerics.md
const float kWidestBlurOfLines = 0.03;  // where the image has blurred copies
vec3 gobo_lines_chord(GoboTables tables, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to,
                      vec2 blurs) {
  uint count = any(greaterThan(abs(blurs), vec2(1e-4))) ? kBlurLines : 1u;
  vec2 aside = normalize(to - from).yx * vec2(1.0, -1.0);
  vec3 total = vec3(0.0);
  // One loop over colours and lines, so that the code of a line is there once.
  for (uint i = 0u; i < tables.planes * count; ++i) {
    float angle = 3.141592653589793 / float(count + 1u) * float(i % count + 1u);
    float share = 2.0 / float(count + 1u) * sin(angle) * sin(angle);
    vec2 u = cos(angle) * aside;
    uint plane = i / count;
    float light =
        share * gobo_lines_plane(tables, plane, beam, chord, weight, from + blurs.x * u, to + blurs.y * u);
    total += light * vec3(plane == 0u, plane == 1u, plane == 2u);
  }
  return (tables.planes == 1u ? vec3(total.r) : total) * chord_measure(chord);
}

// What a gobo lets through in a disc around a place of it. blur: its radius, up to kBlurMost.
vec3 gobo_blurred(GoboTables tables, vec2 p, float blur) {
  float octave = log2(max(blur, kBlurLeast) / kBlurLeast);
  uint level = min(uint(octave), uint(FL_GOBO_BLUR_LEVELS - 1));
  vec4 t = 3.0 * (octave - float(level)) - vec4(0.0, 1.0, 2.0, 3.0);
  vec4 share = vec4(-t.y * t.z * t.w, 3.0 * t.x * t.z * t.w, -3.0 * t.x * t.y * t.w, t.x * t.y * t.z) / 6.0;
  float side = float(blur_side(level));
  vec2 at = clamp((0.5 * p + 0.5) * side, 0.5, side - 0.5) + vec2(blur_corner(level));
  at /= vec2(FL_GOBO_BLUR_COLUMNS, FL_GOBO_BLUR_PX);
  float layer = float(tables.blurs - 1u);
  vec3 through = vec3(dot(textureLod(gobo_blurs, vec3(at, layer), 0.0), share));
  if (tables.planes > 1u) {
    through.g = dot(textureLod(gobo_blurs, vec3(at, layer + 1.0), 0.0), share);
    through.b = dot(textureLod(gobo_blurs, vec3(at, layer + 2.0), 0.0), share);
  }
  return blur < kBlurLeast ? mix(gobo_through(tables, p), through, blur / kBlurLeast) : through;
}

// A chord out of focus: cells as long as the blur in them is wide, and a sample in the middle of each. The blur changes
// evenly from shifts.x to shifts.y, and is nowhere below `frost`. Cells become no shorter where the image is sharper
// than `sharpest`: their ends are at even steps of the integral of 1 / max(|shift|, sharpest), blur_steps().
const float kBlurStep = 0.6;  // length of a cell, in radii of the blur
const float kBlurCells = 24.0;  // of a long chord, at least: the profile changes along it
const float kBlurCellsMost = 128.0;
float blur_steps(float shift, float sharpest) {
  float size = abs(shift) / sharpest;
  return sign(shift) * (size < 1.0 ? size : 1.0 + log(size));
}
float blur_at_step(float steps, float sharpest) {
  float size = abs(steps);
  return sign(steps) * sharpest * (size < 1.0 ? size : exp(size - 1.0));
}
vec3 gobo_blurred_chord(GoboTables tables, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to,
                        vec2 shifts, float frost) {
  float sharpest = max(frost, kBlurLeast);
  float change = shifts.y - shifts.x;
  float steps = blur_steps(shifts.x, sharpest);
  float more = blur_steps(shifts.y, sharpest) - steps;
  float nearest = shifts.x * shifts.y < 0.0 ? sharpest : max(min(abs(shifts.x), abs(shifts.y)), sharpest);
  bool even = abs(change) < 0.1 * nearest;
  float far = distance(from, to);
  float wanted = far / kBlurStep * (even ? 1.0 / nearest : more / change);
  uint fours = uint(0.25 * clamp(wanted, kBlurCells * min(2.0 * far, 1.0), kBlurCellsMost - 4.0)) + 1u;
  float cells = 4.0 * float(fours);
  vec3 total = vec3(0.0);
  float end = 0.0;
  for (uint four = 0u; four < fours; ++four) {
    float x[4];
    float part[4];
    vec3 through[4];
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float cell = float(4u * four) + float(i + 1);
      float next = cell / cells;
      if (!even && cell < cells) next = (blur_at_step(steps + more * next, sharpest) - shifts.x) / change;
      part[i] = next - end;
      x[i] = 0.5 * (next + end);
      end = next;
    }
    [[unroll]] for (int i = 0; i < 4; ++i) {
      through[i] = gobo_blurred(tables, mix(from, to, x[i]), max(abs(mix(shifts.x, shifts.y, x[i])), frost));
    }
    [[unroll]] for (int i = 0; i < 4; ++i) total += through[i] * (part[i] * gobo_light_at(beam, chord, weight, x[i]));
  }
  return max(total, vec3(0.0)) * chord_measure(chord);
}

// A short chord from `from` to `to` in the image.
vec3 gobo_short_chord(GoboTables tables, BeamShape beam, Chord chord, ChordWeight weight, vec2 from, vec2 to) {
  uint fours = uint(clamp(distance(from, to) / (4.0 * kTapStep) + 1.0, 1.0, float(kShortTaps / 4u)));
  return gobo_stretch(tables, beam, chord, weight, from, to, 0.0, 1.0, fours) * chord_measure(chord);
}

// Whether a beam with a gobo has samples of one sharp image.
bool gobo_is_sampled(BeamRow row) {
  return kGoboMethod == uint(FL_GOBO_TAPS) && !(kWide && row.y_axis.w > kWideSpread) && gobo_is_sharp(row) &&
         gobo_only_image(row).image != 0u;
}
// Light along a chord of such a beam: of its lit parts, or of its dark ones where `subtracts`. What stands for a sample
// counts by its share of them.
vec3 gobo_sampled(BeamShape beam, Medium medium, Chord chord, vec3 d, bool with_extinction, ShadowParts parts,
                  bool subtracts) {
  BeamRow row = gobo_row;
  ChordWeight weight = chord_weight(beam, medium, chord, d, with_extinction);
  GoboImage only = gobo_only_image(row);
  vec2 from = gobo_end(chord, chord.s_from, only.turn);
  vec2 to = gobo_end(chord, chord.s_to, only.turn);
  const float kPart = 1.0 / float(kGoboTaps);
  vec3 total = vec3(0.0);
  for (uint tap = 0u; tap < kGoboTaps; ++tap) {
    float begin = float(tap) * kPart;
    float at = begin + 0.5 * kPart;
    float share = 1.0;
    if (kShadows) {
      float dark = 0.0;
      [[unroll]] for (int j = 0; j < FL_SHADOW_PARTS; ++j) {
        dark += max(min(begin + kPart, parts.to[j]) - max(begin, parts.from[j]), 0.0);
      }
      share = subtracts ? dark / kPart : 1.0 - dark / kPart;
    }
    total += gobo_image(only.image, mix(from, to, at), 0.0) * (share * gobo_light_at(beam, chord, weight, at));
  }
  return max(total, vec3(0.0)) * (kPart * chord_measure(chord));
}

// The light along a chord of the beam that gobo_begin() was called with, over sigma_s J0. d: the ray in light space.
// Without the row as an argument: a driver that does not inline this function would store all of it for each call.
vec3 gobo_inscatter(BeamShape beam, Medium medium, Chord chord, vec3 d, bool with_extinction) {
  BeamRow row = gobo_row;
  const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
  gobo_sample = 0u;
  if (kGoboMethod == uint(FL_GOBO_MIDPOINTS) || (kWide && beam.spread > kWideSpread)) {
    return chord_inscatter_gobo(beam, medium, chord, d, kGoboTaps, with_extinction, row.gobo, as_it_is);
  }
  ChordWeight weight = chord_weight(beam, medium, chord, d, with_extinction);
  if (kGoboMethod == uint(FL_GOBO_TABLES)) {
    GoboImage only = gobo_only_image(row);
    GoboTables tables;
    tables.lines = gobo_lines_layer(only);
    if (tables.lines != 0u) {
      tables.image = only.image;
      tables.gate = gobo_tables[only.image - 1u].gate;
      tables.planes = gobo_tables[only.image - 1u].planes;
      tables.whole = gobo_whole_layer(row, only);
      float nearer = min(chord.s_from * chord.s_from, chord.s_to * chord.s_to);
      vec2 turn = only.turn;
      if (tables.whole != 0u && nearer + chord.offset * chord.offset > 0.998 && chord.s_from < 0.0 &&
          chord.s_to > 0.0) {
        vec2 way = vec2(turn.x * chord.along.x + turn.y * chord.along.y,
                        turn.x * chord.along.y - turn.y * chord.along.x);
        return gobo_whole_chord(tables.whole, tables.planes, chord, weight, way);
      }
      vec2 from = gobo_end(chord, chord.s_from, turn);
      vec2 to = gobo_end(chord, chord.s_to, turn);
      bool sharp = gobo_is_sharp(row);
      vec2 shifts = gobo_shifts(row, chord, d);
      vec2 blurs = gobo_line_blurs(row, shifts);
      tables.blurs = kFocus ? gobo_blurs_layer(only) : 0u;
      float widest = tables.blurs != 0u ? kWidestBlurOfLines : kWidestBlur;
      if (distance(from, to) > kShortChord && all(lessThan(abs(blurs), vec2(widest)))) {
        return gobo_lines_chord(tables, beam, chord, weight, from, to, blurs);
      }
      if (sharp) return gobo_short_chord(tables, beam, chord, weight, from, to);
      if (tables.blurs != 0u && all(lessThanEqual(abs(blurs), vec2(kBlurMost)))) {
        return gobo_blurred_chord(tables, beam, chord, weight, from, to, shifts, row.gobo_blur);
      }
    }
  }
  return chord_inscatter_taps(beam, chord, weight, d, kGoboTaps, row.gobo, as_it_is);
}
