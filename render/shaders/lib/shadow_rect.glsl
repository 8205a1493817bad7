// A rectangle of pixels for shadow_in_cell(), in front of what they show. After shadow.glsl and tile_depth.glsl.
ShadowCell shadow_cell_before(BeamRow row, vec2 low, vec2 high, RectDepth depth) {
  ShadowCell cell = shadow_cell(row, low, high, depth.far_m);
  if (kSolids && depth.is_plane) {
    // A ray of depth 1 makes distances depths.
    vec4 plane_m = vec4(plane_distance(depth, vec2(low.x, low.y), 1.0), plane_distance(depth, vec2(high.x, low.y), 1.0),
                        plane_distance(depth, vec2(high.x, high.y), 1.0),
                        plane_distance(depth, vec2(low.x, high.y), 1.0));
    shadow_cell_end(cell, plane_m);
  }
  shadow_cell_close(cell, row);
  return cell;
}
