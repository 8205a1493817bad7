// The image of a pane: its texels on each level of detail.
layout(set = 0, binding = FL_BINDING_PANES, std430) readonly buffer PanesBuffer { PaneRow panes[]; };
layout(set = 0, binding = FL_BINDING_PANE_TEXELS, std430) readonly buffer PaneTexelsBuffer { uvec2 pane_texels[]; };

struct PaneImage {
  uint first;
  ivec2 size;
  uint levels;
};
PaneImage pane_image(PaneRow row) { return PaneImage(row.texel_first, ivec2(row.width, row.height), row.levels); }

struct PaneLevel {
  uint first;
  ivec2 size;
};
PaneLevel pane_level(PaneImage image, uint level) {
  PaneLevel at = PaneLevel(image.first, image.size);
  for (uint i = 0u; i < level; ++i) {
    at.first += uint(at.size.x * at.size.y);
    at.size = (at.size + 1) / 2;
  }
  return at;
}
vec3 pane_texel(PaneLevel level, ivec2 at) {
  at = clamp(at, ivec2(0), level.size - 1);
  uvec2 words = pane_texels[level.first + uint(at.y * level.size.x + at.x)];
  return vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
}
// From u and v on the glass to places among the middles of texels.
vec2 pane_place(PaneLevel level, vec2 uv) { return (vec2(uv.x, -uv.y) * 0.5 + 0.5) * vec2(level.size) - 0.5; }

// The middles of four texels, and the glass between them.
struct PaneCell {
  vec3 corner[4];  // to the right, then down
};
PaneCell pane_cell(PaneLevel level, ivec2 at) {
  PaneCell cell;
  for (int i = 0; i < 4; ++i) cell.corner[i] = pane_texel(level, at + ivec2(i & 1, i >> 1));
  return cell;
}
vec3 pane_value(PaneCell cell, vec2 f) {
  f = clamp(f, 0.0, 1.0);
  return mix(mix(cell.corner[0], cell.corner[1], f.x), mix(cell.corner[2], cell.corner[3], f.x), f.y);
}
vec3 pane_at(PaneImage image, uint level, vec2 uv) {
  PaneLevel of = pane_level(image, level);
  vec2 place = pane_place(of, uv);
  vec2 low = floor(place);
  return pane_value(pane_cell(of, ivec2(low)), place - low);
}
// Of a pixel that covers so many texels a side.
vec3 pane_mean(PaneImage image, vec2 uv, float texels) {
  float level = clamp(log2(max(texels, 1.0)), 0.0, float(image.levels - 1u));
  uint low = uint(level);
  vec3 value = pane_at(image, low, uv);
  if (level > float(low)) value = mix(value, pane_at(image, low + 1u, uv), level - float(low));
  return value;
}
