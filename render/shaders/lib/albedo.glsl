// The share of light that a surface reflects. After surface.glsl.
// Reflectance of painted housings. Chosen by eye.
const float kBodyAlbedo = 0.04;

vec3 albedo_of(Surface surface) {
  if (surface.kind == kBox) return boxes[surface.which].albedo.rgb;
  if (surface.kind == kBody) return vec3(kBodyAlbedo);
  return vec3((uvec3(surface.which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
}
