#version 460
// Lists the bodies of a mesh that the raster draws, by level, and in the order of the slots, so that bodies at the same
// depth are always drawn in the same order. One workgroup a mesh; each thread has a run of neighbouring slots.
#extension GL_GOOGLE_include_directive : require
#include "sim/shared/real.h"
#include "fixtures/shared/tables.h"
#include "render/shaders/shared/frame_io.h"

layout(local_size_x = FL_GROUP_LIST) in;
layout(set = 0, binding = FL_BINDING_INSTANCES, std430) readonly buffer SlotsBuffer { BodySlotRow slots[]; };
layout(set = 0, binding = FL_BINDING_BODY_MESHES, std430) readonly buffer MeshesBuffer { BodyMeshRow meshes[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_BODY_DRAWN, std430) writeonly buffer DrawnBuffer { uint drawn[]; };
struct Draw {  // VkDrawIndexedIndirectCommand
  uint index_count;
  uint instance_count;
  uint first_index;
  int vertex_offset;
  uint first_instance;
};
layout(set = 0, binding = FL_BINDING_BODY_DRAWS, std430) buffer DrawsBuffer { Draw draws[]; };

shared uint counts[FL_BODY_LEVELS][FL_GROUP_LIST];  // of each thread's run; then where they go
shared uint totals[FL_BODY_LEVELS];

void main() {
  BodyMeshRow mesh = meshes[gl_WorkGroupID.x];
  uint thread = gl_LocalInvocationIndex;
  uint run = (mesh.slot_count + FL_GROUP_LIST - 1u) / FL_GROUP_LIST;
  uint first = mesh.slot_first + min(thread * run, mesh.slot_count);
  uint end = mesh.slot_first + min((thread + 1u) * run, mesh.slot_count);
  for (uint level = 0u; level < FL_BODY_LEVELS; ++level) counts[level][thread] = 0u;
  for (uint slot = first; slot < end; ++slot) {
    uint choice = choices[slot];
    if (choice != FL_CHOICE_NONE) ++counts[(choice & FL_CHOICE_LEVEL) - mesh.level_first][thread];
  }
  barrier();
  if (thread < mesh.level_count) {
    uint sum = 0u;
    for (uint i = 0u; i < FL_GROUP_LIST; ++i) {
      uint count = counts[thread][i];
      counts[thread][i] = sum;
      sum += count;
    }
    totals[thread] = sum;
  }
  barrier();
  if (thread < mesh.level_count) {
    uint at = mesh.slot_first;
    for (uint level = 0u; level < thread; ++level) at += totals[level];
    draws[mesh.level_first + thread].instance_count = totals[thread];
    draws[mesh.level_first + thread].first_instance = at;
  }
  for (uint slot = first; slot < end; ++slot) {
    uint choice = choices[slot];
    if (choice == FL_CHOICE_NONE) continue;
    uint own = (choice & FL_CHOICE_LEVEL) - mesh.level_first;
    uint at = mesh.slot_first;
    for (uint level = 0u; level < own; ++level) at += totals[level];
    drawn[at + counts[own][thread]++] = slots[slot].head;
  }
}
