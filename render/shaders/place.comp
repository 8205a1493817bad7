#version 460
// What is drawn of each body: nothing outside the picture, else the plainest level whose error is not visible.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) writeonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_BODY_SPACES, std430) writeonly buffer SpacesBuffer { BodySpaceRow spaces[]; };
layout(set = 0, binding = FL_BINDING_BODY_ROUNDS, std430) buffer RoundsBuffer {
  BodyRoundsHead rounds_head;
  BodyRoundRow rounds[];
};

// Asks for the workgroups that draw it.
void add_rounds(uint slot, uint triangles) {
  uint count = (triangles + FL_GROUP_TRIANGLES - 1u) / FL_GROUP_TRIANGLES;
  uint first = atomicAdd(rounds_head.count, count);
  atomicMax(rounds_head.groups_x, min(first + count, uint(FL_ROUNDS_X)));
  atomicMax(rounds_head.groups_y, (first + count + FL_ROUNDS_X - 1u) / FL_ROUNDS_X);
  for (uint i = 0u; i < count; ++i) rounds[first + i] = BodyRoundRow(slot, i * FL_GROUP_TRIANGLES);
}

void main() {
  uint slot = gl_GlobalInvocationID.x;
  if (slot >= uint(slots.length())) return;
  BodySlotRow body = slots[slot];
  BodyMeshRow mesh = meshes[body.mesh];
  HeadRow row = heads[body.head];
  TypeRow type = types[row.type];
  HeadState state = states[body.head];
  float tan_x = length(params.right.xyz);
  float tan_y = length(params.up.xyz);
  float focal_px = 0.5 * float(params.width) / tan_x;
  float near_m = params.right.w;

  bool visible = false;
  float px_per_m = 0.0;     // of the mesh, at most, where it is visible
  float diameter_px = 0.0;  // at most, of the largest part, visible or not
  vec2 rows = vec2(1e9, -1e9);
  uint away = 0u;
  for (uint depth = 0u; depth < 4u; ++depth) {
    vec4 sphere = mesh.sphere[depth];
    if (sphere.w < 0.0) continue;
    Placed at = place(row, type, state, depth);
    mat3x4 space = space_of(at);
    for (uint i = 0u; i < 3u; ++i) spaces[slot].to_picture[3u * depth + i] = space[i];
    vec3 centre = at.origin + at.x_axis * sphere.x + at.y_axis * sphere.y + at.z_axis * sphere.z;
    float scale = stretch(at);
    float away_m = length(centre);
    // What float loses of a place grows with its distance from the stage's origin and from the camera.
    float radius_m = sphere.w * scale * 1.001 + 1e-5 + 2e-6 * (away_m + length(params.position.xyz));
    if (away_m > radius_m + near_reach_m()) away |= away_in(space) << (2u * depth);
    float z = dot(centre, params.forward.xyz);
    float x = abs(dot(centre, params.right.xyz)) / tan_x;
    float y = abs(dot(centre, params.up.xyz)) / tan_y;
    bool seen = z + radius_m > near_m && x - z * tan_x < radius_m * sqrt(1.0 + tan_x * tan_x) &&
                y - z * tan_y < radius_m * sqrt(1.0 + tan_y * tan_y);
    // A length at depth z is focal / z times as long in the picture, and where it is off the middle, distance / z times
    // that.
    float nearest_m = z - radius_m;
    float here = nearest_m > 2.0 * near_m ? focal_px * (away_m + radius_m) / (nearest_m * nearest_m) : 1e30;
    diameter_px = max(diameter_px, min(2.0 * radius_m * here, 1e30));
    // The rows of pixels that it may cover.
    float row_px = 0.5 * float(params.height) - focal_px * dot(centre, params.up.xyz) / (tan_y * max(z, near_m));
    float reach_px = min(radius_m * here, 1e30) + 2.0;
    rows = vec2(min(rows.x, row_px - reach_px), max(rows.y, row_px + reach_px));
    if (seen) px_per_m = max(px_per_m, min(here * scale, 1e30));
    visible = visible || seen;
  }

  uint choice = FL_CHOICE_NONE;
  if (visible && diameter_px >= params.body_error_px * FL_BODY_LEAST) {
    choice = mesh.level_first;
    for (uint i = 1u; i < mesh.level_count && params.body_error_px > 0.0; ++i) {
      if (levels[mesh.level_first + i].error_m * px_per_m <= params.body_error_px) choice = mesh.level_first + i;
    }
    if (!(diameter_px < float(FL_WIDE_BODY_PX))) choice |= FL_CHOICE_WIDE;
  }
  choices[slot] = choice;
  spaces[slot].first_px = rows.x;
  spaces[slot].last_px = rows.y;
  spaces[slot].away = away;
  if (choice != FL_CHOICE_NONE) add_rounds(slot, levels[choice & FL_CHOICE_LEVEL].index_count / 3u);
}
