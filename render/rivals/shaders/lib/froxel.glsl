// A grid of cells that are columns of the picture, cut into slices whose depths grow by a constant factor.
layout(constant_id = FL_SPEC_FROXELS_X) const uint kAcross = 160;
layout(constant_id = FL_SPEC_FROXELS_Y) const uint kDown = 90;
layout(constant_id = FL_SPEC_FROXELS_Z) const uint kSlices = 64;
layout(set = 0, binding = FL_BINDING_BOUNDS, std430) readonly buffer BoundsBuffer { BoundsRow bounds; };
layout(set = 0, binding = FL_BINDING_FROXELS, std430) buffer FroxelsBuffer { vec4 froxels[]; };

uint froxel_at(uvec2 column, uint slice) { return (slice * kDown + column.y) * kAcross + column.x; }
// The depth at which slice `slice` begins; a half is its middle.
float froxel_depth_m(float slice) {
  return bounds.low.w * pow(bounds.high.w / bounds.low.w, slice / float(kSlices));
}
// In slices, from the beginning of the first.
float froxel_slice(float depth_m) {
  return float(kSlices) * log(depth_m / bounds.low.w) / log(bounds.high.w / bounds.low.w);
}
// Where the ray through the middle of a column meets the picture, px.
vec2 froxel_pixel(uvec2 column) {
  return (vec2(column) + 0.5) / vec2(kAcross, kDown) * vec2(params.width, params.height);
}
