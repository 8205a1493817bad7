// Whether a beam can touch any pixel of a rectangle of the picture. Conservative: never says no when a pixel is
// touched. Two tests: the beam's line in the gobo plane passes the disc by for all four corners (convex in the
// direction, so for all pixels between them); or the whole truncated cone lies outside one side of the rectangle's
// pyramid.

BeamShape beam_shape(BeamRow row) {
  BeamShape beam;
  beam.lens_radius_m = row.x_axis.w;
  beam.spread = row.y_axis.w;
  beam.range_m = row.axis.w;
  beam.profile_power = row.eye.w;
  beam.squeeze = row.squeeze;
  beam.measured = row.measured;
  beam.hidden = row.j0.w;
  return beam;
}

// Radius of the thinnest beam as it is drawn, over its depth; 0: this one is nowhere so thin.
float beam_thin(BeamRow row) { return (row.flags & FL_BEAM_THIN) != 0u ? params.thin : 0.0; }

vec3 to_light(BeamRow row, vec3 v) {
  return vec3(dot(row.x_axis.xyz, v), dot(row.y_axis.xyz, v), dot(row.axis.xyz, v));
}

// Largest n . (p - eye) over the two end discs of the beam, for a plane normal n in light space.
float beam_extent(BeamShape beam, vec3 eye, vec3 n) {
  float across = length(n.xy);
  float at_lens = beam.lens_radius_m * across;
  float at_end = n.z * beam.range_m + (beam.lens_radius_m + beam.spread * beam.range_m) * across;
  return max(at_lens, at_end) - dot(n, eye);
}

// Radius of the lens from whose points shadows are cast. A rectangle's light space has the disc around it: points in a
// smaller disc have the moments of the rectangle there.
float shadow_lens_m(BeamRow row) {
  return FL_NEED_RECTANGLE && row.squeeze > 0.0 ? 0.816496580927726 * row.x_axis.w : row.x_axis.w;
}

// How much longer a thin rectangle's radius may become in its stretched light space than a round beam's. sqrt(2) is for
// the corners. A wide one's height is stretched; a high one's distances are shortened.
float beam_stretch(float squeeze) { return squeeze > 0.0 ? 1.5 * max(sqrt(squeeze), inversesqrt(squeeze)) : 1.0; }

// What holds the beam as it is drawn, where thin beams are drawn wider (thin.glsl) and at most `wider` times as wide as
// that. On a surface, where wider > 1, a step along the axis of a wide beam moves its edge as well: sqrt(1 + k^2). What
// is added is convex along the axis, so it is largest at an end.
BeamShape beam_bound(BeamRow row, float wider) {
  BeamShape beam = beam_shape(row);
  float thin = beam_thin(row);
  if (thin > 0.0) {
    float reach = wider * thin * beam_stretch(row.squeeze);
    if (wider > 1.0) reach *= sqrt(1.0 + beam.spread * beam.spread);
    float at_lens = reach * length(row.eye.xyz) - beam.lens_radius_m;
    float at_end = reach * length(row.eye.xyz - vec3(0.0, 0.0, beam.range_m)) - beam.lens_radius_m -
                   beam.spread * beam.range_m;
    beam.lens_radius_m += max(max(at_lens, at_end), 0.0);
  }
  return beam;
}

// low, high: corners of the rectangle in pixels. beam: what bounds the row's light.
bool beam_touches(BeamRow row, BeamShape beam, vec2 low, vec2 high) {
  vec3 eye = row.eye.xyz;
  vec3 corner_0 = to_light(row, ray_through(vec2(low.x, low.y)));
  vec3 corner_1 = to_light(row, ray_through(vec2(high.x, low.y)));
  vec3 corner_2 = to_light(row, ray_through(vec2(high.x, high.y)));
  vec3 corner_3 = to_light(row, ray_through(vec2(low.x, high.y)));

  float left = min(min(beam_miss(beam, eye, corner_0, 1.0), beam_miss(beam, eye, corner_1, 1.0)),
                   min(beam_miss(beam, eye, corner_2, 1.0), beam_miss(beam, eye, corner_3, 1.0)));
  float right = min(min(beam_miss(beam, eye, corner_0, -1.0), beam_miss(beam, eye, corner_1, -1.0)),
                    min(beam_miss(beam, eye, corner_2, -1.0), beam_miss(beam, eye, corner_3, -1.0)));
  // Rounding of N is about 1e-7 |eye| |d|: a margin of that keeps the test conservative for lasers.
  float margin = 1e-6 * (abs(eye.x) + abs(eye.y)) * length(corner_0);
  if (left > margin || right > margin) return false;

  // Sides of the pyramid, normals inwards. Light space may be mirrored against the screen, so the middle decides.
  vec3 middle = corner_0 + corner_1 + corner_2 + corner_3;
  vec3 side_0 = cross(corner_0, corner_1);
  vec3 side_1 = cross(corner_1, corner_2);
  vec3 side_2 = cross(corner_2, corner_3);
  vec3 side_3 = cross(corner_3, corner_0);
  float inwards = dot(side_0, middle) < 0.0 ? -1.0 : 1.0;
  if (beam_extent(beam, eye, side_0 * inwards) < 0.0) return false;
  if (beam_extent(beam, eye, side_1 * inwards) < 0.0) return false;
  if (beam_extent(beam, eye, side_2 * inwards) < 0.0) return false;
  if (beam_extent(beam, eye, side_3 * inwards) < 0.0) return false;
  vec3 forward = to_light(row, params.forward.xyz);
  if (FL_NEED_RECTANGLE && beam.squeeze > 0.0) forward.y *= beam.squeeze;  // as a plane's normal in stretched space
  return beam_extent(beam, eye, forward) >= 0.0;
}
