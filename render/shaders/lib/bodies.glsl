// The tables of bodies, and where a body is. Needs FL_USE_HEADS and FL_USE_POSE.
layout(set = 0, binding = FL_BINDING_INSTANCES, std430) readonly buffer SlotsBuffer { BodySlotRow slots[]; };
layout(set = 0, binding = FL_BINDING_BODY_MESHES, std430) readonly buffer MeshesBuffer { BodyMeshRow meshes[]; };
layout(set = 0, binding = FL_BINDING_BODY_LEVELS, std430) readonly buffer LevelsBuffer { BodyLevelRow levels[]; };

// The space behind `depth` joints, camera-relative, m.
struct Placed {
  vec3 origin;
  vec3 x_axis;
  vec3 y_axis;
  vec3 z_axis;
};
Placed place(HeadRow row, TypeRow type, HeadState state, uint depth) {
  Placed at;
  at.origin = fixture_to_stage_point(row, chain_to_fixture(type, state, depth, vec3(0.0), 1.0)) - params.position.xyz;
  at.x_axis = fixture_to_stage_direction(row, chain_to_fixture(type, state, depth, vec3(1.0, 0.0, 0.0), 0.0));
  at.y_axis = fixture_to_stage_direction(row, chain_to_fixture(type, state, depth, vec3(0.0, 1.0, 0.0), 0.0));
  at.z_axis = fixture_to_stage_direction(row, chain_to_fixture(type, state, depth, vec3(0.0, 0.0, 1.0), 0.0));
  return at;
}

// The most that a space stretches a length: the largest row sum of the products of its axes is no smaller than the
// square of that, and equal where the axes are at right angles.
float stretch(Placed at) {
  float xy = abs(dot(at.x_axis, at.y_axis));
  float xz = abs(dot(at.x_axis, at.z_axis));
  float yz = abs(dot(at.y_axis, at.z_axis));
  return sqrt(max(dot(at.x_axis, at.x_axis) + xy + xz,
                  max(dot(at.y_axis, at.y_axis) + xy + yz, dot(at.z_axis, at.z_axis) + xz + yz)));
}

// That of the stage, in which objects are.
Placed stage_space() { return Placed(-params.position.xyz, vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)); }

// dot(), to the same bits in every shader: glslang leaves a dot() of a precise number to the driver.
float exact_dot(vec3 a, vec3 b) {
  precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// Beyond the surface of a shell, how far the camera may be while the near plane still cuts it, m.
float near_reach_m() {
  float right = length(params.right.xyz);
  float up = length(params.up.xyz);
  return params.right.w * sqrt(1.0 + right * right + up * up);
}
// FL_AWAY_... of a space with these rows, for a camera outside the shells there. A corner of a triangle less the eye,
// times the rows, is (x times w, y times w, w), so an outward triangle that faces the eye has an area in the picture
// with the other sign than their determinant. A space that is nearly flat has no sign.
uint away_in(mat3x4 space) {
  float volume = dot(cross(space[0].xyz, space[1].xyz), space[2].xyz);
  float most = length(space[0].xyz) * length(space[1].xyz) * length(space[2].xyz);
  if (!(abs(volume) > 1e-3 * most)) return 0u;
  return volume > 0.0 ? FL_AWAY_POSITIVE : FL_AWAY_NEGATIVE;
}

// Rows that take a place in it to (x times w, y times w, w); x and y in pixels from the picture's middle.
mat3x4 space_of(Placed at) {
  precise vec3 across = params.right.xyz * (0.5 * float(params.width) / exact_dot(params.right.xyz, params.right.xyz));
  precise vec3 down = params.up.xyz * (-0.5 * float(params.height) / exact_dot(params.up.xyz, params.up.xyz));
  vec3 rows[3] = vec3[3](across, down, params.forward.xyz);
  mat3x4 space;
  for (int i = 0; i < 3; ++i) {
    space[i] = vec4(exact_dot(at.x_axis, rows[i]), exact_dot(at.y_axis, rows[i]), exact_dot(at.z_axis, rows[i]),
                    exact_dot(at.origin, rows[i]));
  }
  return space;
}
