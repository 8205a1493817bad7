#version 460
// Finds room for the samples of pixels with an edge (edges.comp): those of one row of tiles after the other, in parts
// that fit into the buffer of samples. One workgroup. FL_DRAWS_BODIES: the rig has bodies.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
layout(local_size_x = FL_GROUP_PARTS) in;
layout(set = 0, binding = FL_BINDING_EDGE_PARTS, std430) coherent buffer EdgePartsBuffer { EdgePartRow edge_parts[]; };
#ifdef FL_DRAWS_BODIES
layout(set = 0, binding = FL_BINDING_BODY_ROUNDS, std430) readonly buffer RoundsBuffer { BodyRoundsHead rounds_head; };
uvec2 body_groups() { return uvec2(rounds_head.groups_x, rounds_head.groups_y); }
#else
uvec2 body_groups() { return uvec2(0u); }
#endif
// Pixels with room for samples, of which a row of tiles needs no more; workgroups of objects.
layout(push_constant) uniform PartsPush {
  uint room;
  uint objects_x;
  uint objects_y;
} push;

shared uint counts[FL_GROUP_PARTS];  // of rows of a round
shared uint firsts[FL_GROUP_PARTS];  // of these, the number of the first pixel in its part
shared int begins[FL_GROUP_PARTS];   // the first rows of parts that begin in the round
shared uint begin_count;

void main() {
  uint own = gl_LocalInvocationIndex;
  uint tiles_x = (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX);
  uint tile_rows = (FL_NOT_IN_CODE(params.height) + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX);
  uint part_count = 0u;
  uint used = push.room;  // so a part begins with the first row
  for (uint first = 0u; first < tile_rows; first += FL_GROUP_PARTS) {
    counts[own] = first + own < tile_rows ? edge_parts[first + own].count : 0u;
    barrier();
    if (own == 0u) {
      begin_count = 0u;
      for (uint i = 0u; i < min(tile_rows - first, uint(FL_GROUP_PARTS)); ++i) {
        if (used + counts[i] > push.room || first + i == 0u) {
          begins[begin_count++] = int(first + i);
          used = 0u;
        }
        firsts[i] = used;
        used += counts[i];
      }
    }
    barrier();
    if (first + own < tile_rows) edge_parts[first + own].next = firsts[own];
    if (own < begin_count) edge_parts[part_count + own].first = begins[own] * FL_TILE_PX;
    part_count += begin_count;
    barrier();
  }
  memoryBarrierBuffer();
  barrier();
  for (uint part = own; part < tile_rows; part += FL_GROUP_PARTS) {
    bool is_used = part < part_count;
    int first = is_used ? edge_parts[part].first : 0;
    int end = !is_used ? 0 : part + 1u < part_count ? edge_parts[part + 1u].first : int(tile_rows) * FL_TILE_PX;
    edge_parts[part].end = min(end, int(params.height));
    edge_parts[part].tiles_x = tiles_x;
    edge_parts[part].tiles_y = uint(end - first) / uint(FL_TILE_PX);
    edge_parts[part].tiles_z = 1u;
    edge_parts[part].bodies_x = is_used ? body_groups().x : 0u;
    edge_parts[part].bodies_y = is_used ? body_groups().y : 0u;
    edge_parts[part].bodies_z = 1u;
    edge_parts[part].objects_x = is_used ? push.objects_x : 0u;
    edge_parts[part].objects_y = is_used ? push.objects_y : 0u;
    edge_parts[part].objects_z = 1u;
    edge_parts[part].blocks_y = 1u;  // blocks_x and blocks_asked are 0
    edge_parts[part].blocks_z = 1u;
  }
}
