// A cone of walls round a beam, FL_CONE_SIDES of them: a corner of its triangles, by gl_VertexIndex. After
// beam_ends.glsl.
struct ConeWall {
  vec3 from_camera_m;
  vec3 normal;
  vec2 on_wall;  // 0 at the lens, 1 at the end; around, in turns
};
ConeWall cone_wall(BeamRow row) {
  uint corner = uint(gl_VertexIndex) % 6u;
  uint side = uint(gl_VertexIndex) / 6u + (corner == 1u || corner == 2u || corner == 4u ? 1u : 0u);
  ConeWall wall;
  wall.on_wall = vec2(corner == 2u || corner == 4u || corner == 5u ? 1.0 : 0.0, float(side) / float(FL_CONE_SIDES));
  float angle = 6.283185307179586 * wall.on_wall.y;
  vec2 around = vec2(cos(angle), sin(angle));
  float z = wall.on_wall.x * row.axis.w;
  float w = row.x_axis.w + row.y_axis.w * z;
  wall.from_camera_m = from_light(row, vec3(w * around, z) - row.eye.xyz);
  wall.normal = from_light(row, vec3(around, -row.y_axis.w));
  return wall;
}
