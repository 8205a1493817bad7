// Cells of displays: how they lie in their levels, and a walk over those that are small as they are seen from a place.
// After frame.glsl.
layout(set = 0, binding = FL_BINDING_DISPLAYS, std430) readonly buffer DisplaysBuffer { DisplayRow displays[]; };
layout(set = 0, binding = FL_BINDING_DISPLAY_LEVELS, std430) readonly buffer DisplayLevelsBuffer {
  DisplayLevelRow display_levels[];
};
layout(set = 0, binding = FL_BINDING_DISPLAY_CELLS, std430) FL_CELLS_ACCESS buffer DisplayCellsBuffer { uint cells[]; };

// A level counts from the smallest parts of pixels: FL_DISPLAY_PARTS is that of pixels.
uvec2 halvings(DisplayRow row, uint level) {
  int parts = min(int(level), FL_DISPLAY_PARTS);
  int down = bitCount(bitfieldExtract(row.part_axes, 0, parts));
  down += bitCount(bitfieldExtract(row.axes, 0, int(level) - parts));
  return uvec2(level - uint(down), down);
}
bool halves_down(DisplayRow row, uint level) {
  bool part = level < uint(FL_DISPLAY_PARTS);
  return ((part ? row.part_axes >> level : row.axes >> (level - uint(FL_DISPLAY_PARTS))) & 1u) != 0u;
}

struct DisplayCell {
  vec3 mean;
  vec3 moment_x;  // of the distance to the right, pixels
  vec3 moment_y;
};

vec3 read_pixel(DisplayRow row, uvec2 at) {
  uint word = display_levels[row.level_first].first + 3u * (at.y * row.columns + at.x);
  return uintBitsToFloat(uvec3(cells[word], cells[word + 1u], cells[word + 2u]));
}
DisplayCell read_cell(DisplayRow row, uint level, uvec2 at) {
  if (level == 0u) return DisplayCell(read_pixel(row, at), vec3(0.0), vec3(0.0));
  DisplayLevelRow size = display_levels[row.level_first + level];
  uint word = size.first + 6u * (at.y * size.columns + at.x);
  vec2 a = unpackHalf2x16(cells[word + 3u]);
  vec2 b = unpackHalf2x16(cells[word + 4u]);
  vec2 c = unpackHalf2x16(cells[word + 5u]);
  return DisplayCell(uintBitsToFloat(uvec3(cells[word], cells[word + 1u], cells[word + 2u])), vec3(a, b.x),
                     vec3(b.y, c));
}

vec3 in_display(DisplayRow row, vec3 v) {
  return vec3(dot(row.right.xyz, v), dot(row.down.xyz, v), dot(row.front.xyz, v));
}

const uint kCellsMost = 32u;  // that a pixel of the picture averages
// The sum of the light of the cells that a rectangle covers, in pixels of the display.
vec3 covered(DisplayRow row, vec2 low, vec2 high) {
  uint level = 0u;
  vec2 cell = vec2(1.0);
  for (; level + 1u < row.levels; ++level) {
    uvec2 shift = halvings(row, uint(FL_DISPLAY_PARTS) + level) - halvings(row, FL_DISPLAY_PARTS);
    cell = vec2(uvec2(1u) << shift);
    vec2 count = (high - low) / cell + 1.0;
    if (count.x * count.y <= float(kCellsMost)) break;
  }
  uvec2 shift = halvings(row, uint(FL_DISPLAY_PARTS) + level) - halvings(row, FL_DISPLAY_PARTS);
  cell = vec2(uvec2(1u) << shift);
  vec2 size = vec2(row.columns, row.rows);
  uvec2 first = uvec2(low / cell);
  uvec2 last = uvec2(min(high, size - 0.001) / cell);
  vec3 sum = vec3(0.0);
  for (uint y = first.y; y <= last.y; ++y) {
    for (uint x = first.x; x <= last.x; ++x) {
      vec2 begin = max(vec2(x, y) * cell, low);
      vec2 end = min(min(vec2(x + 1u, y + 1u) * cell, size), high);
      vec2 area = max(end - begin, 0.0);
      sum += read_cell(row, level, uvec2(x, y)).mean * (area.x * area.y);
    }
  }
  return sum;
}
