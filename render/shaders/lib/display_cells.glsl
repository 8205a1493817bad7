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
