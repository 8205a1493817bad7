#version 460
// Cells of displays: pixels from the levels of their slots, and each level that is stored from the one below. One
// thread a cell.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#define FL_CELLS_ACCESS
#include "render/shaders/lib/display_cells.glsl"

layout(local_size_x = FL_GROUP_DISPLAY) in;
layout(push_constant) uniform Push { uint job_first; } push;
layout(set = 0, binding = FL_BINDING_LEVELS, std430) readonly buffer LevelsBuffer { uint levels[]; };
layout(set = 0, binding = FL_BINDING_DISPLAY_JOBS, std430) readonly buffer DisplayJobsBuffer { DisplayJobRow jobs[]; };

float emitter(DisplayRow row, uint slot, uint which) {
  uint offset = row.offsets >> (8u * which) & 255u;
  if (offset == 255u) return 0.0;
  uint at = slot + offset;
  float share = float(levels[at >> 2] >> (8u * (at & 3u)) & 255u) / 255.0;
  return row.gamma == 1.0 ? share : pow(share, row.gamma);
}

// As fixtures::place_of_pixel().
vec3 light_of_levels(DisplayRow row, uvec2 at) {
  if ((row.order & FL_ORDER_FROM_RIGHT) != 0u) at.x = row.columns - 1u - at.x;
  if ((row.order & FL_ORDER_FROM_BOTTOM) != 0u) at.y = row.rows - 1u - at.y;
  bool columns_first = (row.order & FL_ORDER_COLUMNS) != 0u;
  uint line = columns_first ? at.x : at.y;
  uint along = columns_first ? at.y : at.x;
  uint size = columns_first ? row.rows : row.columns;
  if ((row.order & FL_ORDER_SERPENTINE) != 0u && (line & 1u) != 0u) along = size - 1u - along;
  uint pixel = line * size + along;
  uint slot = row.slot_first;
  if (pixel < row.first_pixels) {
    slot += row.slot_start + pixel * row.slots;
  } else {
    uint rest = pixel - row.first_pixels;
    slot += 512u * (1u + rest / row.universe_pixels) + rest % row.universe_pixels * row.slots;
  }
  return vec3(emitter(row, slot, 0u), emitter(row, slot, 1u), emitter(row, slot, 2u)) + emitter(row, slot, 3u);
}

// Pixels from the beginning of a cell to its end, along one axis.
float extent(uint at, uint shift, uint size) { return float(min((at + 1u) << shift, size) - (at << shift)); }

void main() {
  DisplayJobRow job = jobs[push.job_first + gl_WorkGroupID.x];
  DisplayRow row = displays[job.display];
  DisplayLevelRow size = display_levels[row.level_first + job.level];
  uint cell = job.first + gl_LocalInvocationIndex;
  if (cell >= size.columns * size.rows) return;
  uvec2 at = uvec2(cell % size.columns, cell / size.columns);
  if (job.level == 0u) {
    vec3 light = light_of_levels(row, at);
    uint word = word_of_pixel(row, at);
    for (uint c = 0u; c < 3u; ++c) display_pixels[word + c] = light[c];
    return;
  }
  uint below = job.level - 1u;
  uint axis = halves_down(row, uint(FL_DISPLAY_PARTS) + below) ? 1u : 0u;
  uint shift = (halvings(row, uint(FL_DISPLAY_PARTS) + below) - halvings(row, uint(FL_DISPLAY_PARTS)))[axis];
  uint pixels = axis == 1u ? row.rows : row.columns;
  uvec2 first = at;
  first[axis] *= 2u;
  DisplayCell sum = read_cell(row, below, first);
  uvec2 second = first;
  second[axis] += 1u;
  if (second[axis] << shift < pixels) {
    sum = joined(sum, read_cell(row, below, second), axis, extent(first[axis], shift, pixels),
                 extent(second[axis], shift, pixels));
  }
  uvec3 mean = floatBitsToUint(sum.mean);
  uint to = 3u * (size.first + cell);
  cells[to] = mean.xy;
  cells[to + 1u] = uvec2(mean.z, packHalf2x16(sum.moment_x.xy));
  cells[to + 2u] = uvec2(packHalf2x16(vec2(sum.moment_x.z, sum.moment_y.x)), packHalf2x16(sum.moment_y.yz));
}
