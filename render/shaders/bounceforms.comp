#version 460
// How much of the light that a patch emits reaches each other patch and each probe: once a rig. A thread has a pair of
// source and receiver. Places of the source see places of the receiver or do not; what they see of each other is that
// of discs: cos cos a / (pi r^2 + a). Nearer pairs have more places.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bounce_rays.glsl"

layout(local_size_x = FL_GROUP_FORMS) in;
layout(push_constant) uniform Push {
  uint patches;
  uint probes;
  uint patch_row;  // numbers of a source: to patches, and to the faces of probes; multiples of 4
  uint probe_row;
  uint step;
  uint from;
} push;
layout(set = 0, binding = FL_BINDING_BOUNCE_PATCHES, std430) readonly buffer PatchesBuffer {
  BouncePatchRow patches[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_GRID, std430) readonly buffer GridBuffer {
  BounceGrid grid;
  BounceProbeRow grid_probes[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_FORMS, std430) writeonly buffer FormsBuffer { float forms[]; };

const float kPi = 3.141592653589793;
const float kAwayM = 2e-3;  // from both ends of a ray: what is there belongs to the surfaces themselves

// The middle of what is open of part (x, y) of side x side of a patch, and its share of the patch's area. Where that
// middle is covered, the middle of the open cell nearest to it.
vec3 place_of(BouncePatchRow patch_row, uint side, uint x, uint y, out float share) {
  uint cells = uint(FL_BOUNCE_CELLS) / side;  // of a part, along each side
  float count = 0.0;
  vec2 sum = vec2(0.0);
  for (uint c = 0u; c < cells * cells; ++c) {
    uvec2 cell = uvec2(x * cells + c % cells, y * cells + c / cells);
    float open = float(patch_row.exposed >> (uint(FL_BOUNCE_CELLS) * cell.y + cell.x) & 1u);
    count += open;
    sum += open * (vec2(cell) + 0.5);
  }
  share = count / float(FL_BOUNCE_CELLS * FL_BOUNCE_CELLS);
  vec2 mean = sum / max(count, 1.0);
  vec2 open_place = mean;
  float least = count < float(cells * cells) ? 1e9 : 0.0;
  for (uint c = 0u; c < cells * cells; ++c) {
    uvec2 cell = uvec2(x * cells + c % cells, y * cells + c / cells);
    bool open = (patch_row.exposed >> (uint(FL_BOUNCE_CELLS) * cell.y + cell.x) & 1u) != 0u;
    float away = length(vec2(cell) + 0.5 - mean);
    bool nearer = open && away < least;
    least = nearer ? away : least;
    open_place = nearer ? vec2(cell) + 0.5 : open_place;
  }
  vec2 at = open_place * (2.0 / float(FL_BOUNCE_CELLS)) - 1.0;
  return patch_row.center.xyz + at.x * patch_row.half_u.xyz + at.y * patch_row.half_v.xyz;
}

bool sees(vec3 from, vec3 to) {
  vec3 way = to - from;
  float length_m = length(way);
  float t;
  uint face;
  float away = kAwayM / max(length_m, 1e-6);
  if (away >= 0.5) return true;
  return bounce_hit(from, way, away, 1.0 - away, true, t, face) == FL_NONE;
}

void main() {
  uint receiver = gl_GlobalInvocationID.x;
  uint source = gl_WorkGroupID.y;
  bool to_probes = push.step == FL_BOUNCE_TO_PROBES;
  if (receiver >= (to_probes ? push.probes : push.patches)) return;
  BouncePatchRow emits = patches[source];
  float area = 4.0 * length(cross(emits.half_u.xyz, emits.half_v.xyz));
  if (to_probes) {
    uint x = receiver % grid.probes_x;
    uint y = receiver / grid.probes_x % grid.probes_y;
    uint z = receiver / (grid.probes_x * grid.probes_y);
    vec3 place = grid.low.xyz + grid.low.w * vec3(x, y, z);
    float distance_m = length(emits.center.xyz - place);
    uint side = distance_m > 4.0 * emits.half_u.w ? 1u : distance_m > 1.5 * emits.half_u.w ? 2u : 4u;
    vec3 positive = vec3(0.0);
    vec3 negative = vec3(0.0);
    bool facing = dot(emits.normal.xyz, place - emits.center.xyz) > 0.0 && grid_probes[receiver].usable != 0u;
    uint count = facing ? side * side : 0u;
    for (uint s = 0u; s < count; ++s) {
      float share;
      vec3 from = place_of(emits, side, s % side, s / side, share);
      vec3 way = from - place;
      float square = dot(way, way);
      vec3 unit = way * inversesqrt(max(square, 1e-12));
      float part = share * area;
      float seen = max(-dot(emits.normal.xyz, unit), 0.0) * part / (kPi * square + part);
      if (seen > 0.0 && sees(place, from)) {
        positive += seen * max(unit, 0.0);
        negative += seen * max(-unit, 0.0);
      }
    }
    uint at = push.patches * push.patch_row + source * push.probe_row + receiver;
    for (uint axis = 0u; axis < 3u; ++axis) {
      forms[at + 2u * axis * push.probes] = positive[axis];
      forms[at + (2u * axis + 1u) * push.probes] = negative[axis];
    }
    return;
  }
  BouncePatchRow receives = patches[receiver];
  vec3 between = receives.center.xyz - emits.center.xyz;
  float longer = max(emits.half_u.w, receives.half_u.w);
  float apart = length(between) / longer;
  uint side = apart > 4.0 ? 1u : apart > 1.8 ? 2u : 4u;
  uint own_side = apart > 1.8 ? 1u : 2u;
  // A corner of each may see the other where the centres do not.
  bool facing = dot(emits.normal.xyz, between) + longer > 0.0 && dot(receives.normal.xyz, -between) + longer > 0.0 &&
                source != receiver && receives.center.w > 0.0;
  float sum = 0.0;
  uint own_count = facing ? own_side * own_side : 0u;
  for (uint r = 0u; r < own_count; ++r) {
    float own_share;
    vec3 place = place_of(receives, own_side, r % own_side, r / own_side, own_share);
    for (uint s = 0u; s < side * side; ++s) {
      float share;
      vec3 from = place_of(emits, side, s % side, s / side, share);
      vec3 way = from - place;
      float square = dot(way, way);
      vec3 unit = way * inversesqrt(max(square, 1e-12));
      float part = share * area;
      float seen = max(-dot(emits.normal.xyz, unit), 0.0) * max(dot(receives.normal.xyz, unit), 0.0) * part /
                   (kPi * square + part);
      seen *= own_share;
      if (seen > 0.0 && sees(place, from)) sum += seen;
    }
  }
  float whole = receives.center.w / max(4.0 * length(cross(receives.half_u.xyz, receives.half_v.xyz)), 1e-12);
  forms[source * push.patch_row + receiver] = whole > 0.0 ? sum / whole : 0.0;
}
