// Where a beam ends at what each pixel shows. A place over its depth is an affine function of the pixel and of 1 /
// depth, and so is the beam's radius there over the depth; they give rho, and V (shared/beam.h) is one of the pixel
// alone. After tile_test.glsl.

// What a record has of a pixel's own place, in three rows: here x and y of light space, and the beam's radius, all over
// the depth. Each of 1, x, y, from -1 to 1 over the hull, and of 1 / depth.
struct PlaceRows {
  vec4 of[3];
};
PlaceRows surface_rows(BeamRow row, vec2 middle, float half_px) {
  vec3 at = ray_through(middle);
  vec3 place = to_light(row, at);
  vec3 right = to_light(row, ray_through(middle + vec2(half_px, 0.0)) - at);
  vec3 down = to_light(row, ray_through(middle + vec2(0.0, half_px)) - at);
  float spread = row.y_axis.w;
  PlaceRows rows;
  rows.of[0] = vec4(place.x, right.x, down.x, row.eye.x);
  rows.of[1] = vec4(place.y, right.y, down.y, row.eye.y);
  rows.of[2] = vec4(spread * vec3(place.z, right.z, down.z), row.x_axis.w + spread * row.eye.z);
  return rows;
}
// at: x, y and 1 / depth. Before the apex of a beam that comes from there it is dark, beyond that of one that goes
// there nothing is cut. Far away on a ray nearly across the beam place.z is small and s is large, as it should be.
float surface_s(PlaceRows rows, vec3 at) {
  vec3 way = vec3(dot(rows.of[0].xyz, vec3(1.0, at.xy)), dot(rows.of[1].xyz, vec3(1.0, at.xy)),
                  dot(rows.of[2].xyz, vec3(1.0, at.xy)));
  vec3 eye = vec3(rows.of[0].w, rows.of[1].w, rows.of[2].w);
  vec3 place = way + at.z * eye;
  vec2 v = way.xy * eye.z - eye.xy * way.z;
  float s = dot(v, place.xy) * inversesqrt(max(dot(v, v), 1e-30)) / place.z;
  return place.z > 0.0 ? s : way.z > 0.0 ? -4.0 : 4.0;
}
