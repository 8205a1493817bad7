#version 460
// The table of haze (haze.comp) with the plumes of machines in it. What it holds of the density is what the eye gets:
// less what puffs in front of it take away. Rays of a mirrored camera begin on the floor: puffs below it are in the
// table, where no pass reads it, and take nothing away. A thread a ray.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HAZE
#define FL_HAZE_WRITE
#define FL_HAZE_PLUMES
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/mirror.glsl"
#include "render/shaders/lib/plume.glsl"

layout(local_size_x = FL_GROUP_HAZE) in;

PuffChord chords[FL_PUFFS_MAX];
float reached[FL_PUFFS_MAX];  // the error function at the end of the last slice
uint rows[FL_PUFFS_MAX];
vec3 ray_of_thread;

// Densities at a place of the ray.
struct Place {
  float even;
  float puffs;   // without the noise
  float factor;  // that of the noise
};

Place place_at(vec3 place, float blur_m, uint count, bool clouds) {
  Place here;
  here.even = haze_plumes.even_share * (clouds ? haze_density(haze_field, place, blur_m) : 1.0);
  here.puffs = 0.0;
  here.factor = 1.0;
  float patchy = 0.0;
  float factor = 1.0;
  uint plume = FL_NONE;
  for (uint i = 0u; i < count; ++i) {
    float x = chords[i].per_m * (dot(place - params.position.xyz, ray_of_thread) - chords[i].middle);
    if (abs(x) > 4.0) continue;
    float density = chords[i].scale * chords[i].per_m * 1.1283791671 * exp(-x * x);  // the slope of the error function
    HazePuff puff = haze_puffs[rows[i]];
    if (puff.plume != plume) {
      plume = puff.plume;
      factor = haze_plume_factor(puff.axis, plume, haze_plumes.shift_m, place, blur_m);
    }
    here.puffs += density;
    patchy += factor * density;
  }
  if (here.puffs > 0.0) here.factor = patchy / here.puffs;
  return here;
}

void main() {
  uint node = gl_GlobalInvocationID.x;
  if (node >= uint(FL_HAZE_X * FL_HAZE_Y)) return;
  uvec2 at = uvec2(node % uint(FL_HAZE_X), node / uint(FL_HAZE_X));
  vec2 picture = vec2(float(params.width), float(params.height));
  vec3 from = params.position.xyz;
  vec3 ray = ray_through(vec2(at) / vec2(FL_HAZE_X - 1, FL_HAZE_Y - 1) * picture);
  float ray_length = length(ray);
  ray /= ray_length;
  ray_of_thread = ray;
  float side = 2.0 * max(length(params.right.xyz) / float(FL_HAZE_X - 1), length(params.up.xyz) / float(FL_HAZE_Y - 1));
  float cell = side / ray_length;
  float blur = 0.7 * cell;  // as in haze.comp
  bool clouds = haze_field.noise > 0.0 || haze_field.per_height > 0.0;
  uint count = 0u;
  for (uint i = 0u; i < min(haze_plumes.count, uint(FL_PUFFS_MAX)); ++i) {
    PuffChord chord = puff_chord(haze_puffs[i], from, ray, cell);
    if (chord.scale == 0.0) continue;
    chords[count] = chord;
    reached[count] = plume_erf(chord.per_m * (haze_distance(0.0) - chord.middle));
    rows[count] = i;
    ++count;
  }
  float sum = 0.0;
  float last_m = haze_distance(0.0);
  float through = 1.0;  // what reaches the eye from there
  float begin_m = ray_begin(ray);
  Place begin = place_at(from + ray * last_m, blur * last_m, count, clouds);
  for (uint k = 0u; k < uint(FL_HAZE_SLICES); ++k) {
    float next_m = haze_distance(float(k + 1u) / float(FL_HAZE_SLICES));
    float length_m = next_m - last_m;
    Place end = place_at(from + ray * next_m, blur * next_m, count, clouds);
    float puffs = 0.0;
    float hidden = 0.0;  // of puffs: below the floor
    for (uint i = 0u; i < count; ++i) {
      float x = chords[i].per_m * (next_m - chords[i].middle);
      if (x < -4.0) continue;
      float now = x < 4.0 ? plume_erf(x) : 1.0;
      puffs += chords[i].scale * (now - reached[i]);
      if (kGloss && begin_m > last_m) {
        float floor_erf = plume_erf(chords[i].per_m * (begin_m - chords[i].middle));
        hidden += chords[i].scale * max(min(now, floor_erf) - reached[i], 0.0);
      }
      reached[i] = now;
    }
    // Of what is evenly mixed in a slice of optical depth d the mean (1 - exp(-d)) / d gets out.
    float depth = haze_plumes.scattering_per_m * (puffs - hidden);
    float left = through * exp(-depth);
    float seen = depth > 1e-3 ? (through - left) / depth : through * (1.0 - 0.5 * depth);
    float even = 0.5 * (begin.even + end.even) * length_m;
    float next = sum + seen * (even + 0.5 * (begin.factor + end.factor) * puffs) - length_m;
    float begin_slope = (through * (begin.even + begin.factor * begin.puffs) - 1.0) * haze_slope(k);
    float end_slope = (left * (end.even + end.factor * end.puffs) - 1.0) * haze_slope(k + 1u);
    imageStore(haze_table, ivec3(at, k), vec4(sum, next, begin_slope, end_slope));
    sum = next;
    through = left;
    last_m = next_m;
    begin = end;
  }
}
