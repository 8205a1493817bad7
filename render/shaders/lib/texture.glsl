// Textures of objects: the mean of an image over what a pixel covers of it. That is a parallelogram; means along its
// longer side of up to FL_TEXTURE_PROBES places, each bilinear in two levels of the image as wide as the shorter side.
layout(set = 0, binding = FL_BINDING_TEXTURES, std430) readonly buffer TexturesBuffer { TextureRow textures[]; };
layout(set = 0, binding = FL_BINDING_TEXTURE_TEXELS, std430) readonly buffer TexelsBuffer { uint texture_texels[]; };

#define FL_TEXTURE_PROBES 8.0

int texture_wrapped(int at, int size, uint mode) {
  if (mode == 2u) return clamp(at, 0, size - 1);
  int period = mode == 1u ? 2 * size : size;
  int rest = at - period * int(floor(float(at) / float(period)));
  rest = clamp(rest, 0, period - 1);  // of places that a float rounds
  return rest < size ? rest : period - 1 - rest;
}

vec3 texture_texel(TextureRow row, uint first, ivec2 size, ivec2 at) {
  int x = texture_wrapped(at.x, size.x, row.modes >> FL_TEXTURE_WRAP_U & 3u);
  int y = texture_wrapped(at.y, size.y, row.modes >> FL_TEXTURE_WRAP_V & 3u);
  uint word = texture_texels[first + uint(y * size.x + x)];
  vec3 root = vec3((uvec3(word) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
  return root * root;
}

vec3 texture_at(TextureRow row, uint level, vec2 uv) {
  uint first = row.texel_first;
  ivec2 size = ivec2(row.width, row.height);
  for (uint i = 0u; i < level; ++i) {
    first += uint(size.x * size.y);
    size = (size + 1) / 2;
  }
  vec2 place = uv * vec2(size) - 0.5;
  vec2 low = floor(place);
  vec2 f = place - low;
  ivec2 at = ivec2(low);
  return mix(mix(texture_texel(row, first, size, at), texture_texel(row, first, size, at + ivec2(1, 0)), f.x),
             mix(texture_texel(row, first, size, at + ivec2(0, 1)), texture_texel(row, first, size, at + ivec2(1, 1)),
                 f.x),
             f.y);
}

// dx, dy: how the place changes by a pixel.
vec3 texture_mean(TextureRow row, vec2 uv, vec2 dx, vec2 dy) {
  vec2 size = vec2(row.width, row.height);
  vec2 a = dx * size;
  vec2 b = dy * size;
  bool is_x = dot(a, a) >= dot(b, b);
  float longer = length(is_x ? a : b);
  float shorter = abs(a.x * b.y - a.y * b.x) / max(longer, 1e-12);
  float probes = clamp(ceil(longer / max(shorter, 1.0)), 1.0, FL_TEXTURE_PROBES);
  float level = clamp(log2(max(max(longer / probes, shorter), 1.0)), 0.0, float((row.modes & 31u) - 1u));
  uint low = uint(level);
  float share = level - float(low);
  vec2 along = is_x ? dx : dy;
  vec3 sum = vec3(0.0);
  for (float i = 0.5; i < probes; i += 1.0) {
    vec2 at = uv + along * (i / probes - 0.5);
    vec3 value = texture_at(row, low, at);
    if (share > 0.0) value = mix(value, texture_at(row, low + 1u, at), share);
    sum += value;
  }
  return sum / probes;
}

// The identity of a textured object at a pixel: its reflectance, rounded up or down so that the mean over pixels is
// right. sheen: its SheenRow.
#ifdef FL_SHEEN
uint textured_identity(uint texture_number, vec2 uv, vec2 dx, vec2 dy, vec2 pixel, out uint sheen) {
#else
uint textured_identity(uint texture_number, vec2 uv, vec2 dx, vec2 dy, vec2 pixel) {
#endif
  TextureRow row = textures[texture_number];
#ifdef FL_SHEEN
  sheen = uint(row.albedo.w);
  if (row.width == 0u) {
    uvec3 plain = uvec3(row.albedo.rgb * 1023.0 + 0.5);
    return FL_OBJECT | FL_OBJECT_TEXTURED | plain.r << 20 | plain.g << 10 | plain.b;
  }
#endif
  vec3 albedo = clamp(row.albedo.rgb * texture_mean(row, uv, dx, dy), 0.0, 1.0);
  vec3 rounding = fract(vec3(0.0, 0.33, 0.67) + fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))));
  uvec3 bits = uvec3(clamp(albedo * 1023.0 + rounding, 0.0, 1023.0));
  return FL_OBJECT | FL_OBJECT_TEXTURED | bits.r << 20 | bits.g << 10 | bits.b;
}
