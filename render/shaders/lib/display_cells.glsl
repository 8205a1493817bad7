// Cells of displays: how they lie in their levels, and a walk over those that are small as they are seen from a place.
// After frame.glsl.
layout(set = 0, binding = FL_BINDING_DISPLAYS, std430) readonly buffer DisplaysBuffer { DisplayRow displays[]; };
layout(set = 0, binding = FL_BINDING_DISPLAY_LEVELS, std430) readonly buffer DisplayLevelsBuffer {
  DisplayLevelRow display_levels[];
};
layout(set = 0, binding = FL_BINDING_DISPLAY_CELLS, std430) FL_CELLS_ACCESS buffer DisplayCellsBuffer {
  uvec2 cells[];  // three each
};
layout(set = 0, binding = FL_BINDING_DISPLAY_PIXELS, std430) FL_CELLS_ACCESS buffer DisplayPixelsBuffer {
  float display_pixels[];
};

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

// Two cells beside each other, or above each other where axis is 1, with a and b pixels along it.
DisplayCell joined(DisplayCell first, DisplayCell second, uint axis, float a, float b) {
  float share = b / (a + b);
  vec3 apart = (second.mean - first.mean) * (0.5 * share * a);  // the middles are (a + b) / 2 apart
  DisplayCell cell = DisplayCell(mix(first.mean, second.mean, share), mix(first.moment_x, second.moment_x, share),
                                 mix(first.moment_y, second.moment_y, share));
  if (axis == 0u) {
    cell.moment_x += apart;
  } else {
    cell.moment_y += apart;
  }
  return cell;
}

uint word_of_pixel(DisplayRow row, uvec2 at) { return 3u * (row.pixel_first + at.y * row.columns + at.x); }
vec3 pixel_of_word(uint word) {
  return vec3(display_pixels[word], display_pixels[word + 1u], display_pixels[word + 2u]);
}
vec3 read_pixel(DisplayRow row, uvec2 at) { return pixel_of_word(word_of_pixel(row, at)); }
DisplayCell read_stored(DisplayRow row, uint level, uvec2 at) {
  DisplayLevelRow size = display_levels[row.level_first + level];
  uint first = 3u * (size.first + at.y * size.columns + at.x);
  uvec2 a = cells[first];
  uvec2 b = cells[first + 1u];
  uvec2 c = cells[first + 2u];
  vec2 down = unpackHalf2x16(c.x);
  return DisplayCell(uintBitsToFloat(uvec3(a, b.x)), vec3(unpackHalf2x16(b.y), down.x),
                     vec3(down.y, unpackHalf2x16(c.y)));
}
// A pixel is two that are one, as is a cell of level 1 that has only one.
DisplayCell read_cell(DisplayRow row, uint level, uvec2 at) {
  if (level >= uint(FL_DISPLAY_STORED)) return read_stored(row, level, at);
  uint axis = row.axes & 1u;
  uvec2 first = at << (axis == 0u ? uvec2(level, 0u) : uvec2(0u, level));
  bool is_two = level != 0u && (axis == 0u ? first.x + 1u < row.columns : first.y + 1u < row.rows);
  uint word = word_of_pixel(row, first);
  DisplayCell one = DisplayCell(pixel_of_word(word), vec3(0.0), vec3(0.0));
  word += is_two ? 3u * (axis == 0u ? 1u : row.columns) : 0u;
  return joined(one, DisplayCell(pixel_of_word(word), vec3(0.0), vec3(0.0)), axis, 1.0, 1.0);
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
