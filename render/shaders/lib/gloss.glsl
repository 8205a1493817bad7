// Floors that mirror. After frame.glsl.
layout(set = 0, binding = FL_BINDING_GLOSS, std430) readonly buffer GlossBuffer { GlossRow glosses[]; };

const float kHeightM = 1e-3;  // places so near the plane of a floor are on it

// The floor, of `count`, that a pixel shows, t_m along its unit ray; FL_NONE: something else.
uint floor_at(vec3 ray, float t_m, uint count) {
  uint found = FL_NONE;
  if (!(t_m < 0.5 * FL_FAR_M && ray.z < -1e-6)) return found;
  for (uint i = 0u; i < count && found == FL_NONE; ++i) {
    vec3 from = params.position.xyz - glosses[i].center.xyz + ray * t_m;
    vec3 half_x = glosses[i].half_x.xyz;
    vec3 half_y = glosses[i].half_y.xyz;
    bool inside = abs(from.z) < kHeightM + 2e-6 * t_m && abs(dot(from, half_x)) <= dot(half_x, half_x) &&
                  abs(dot(from, half_y)) <= dot(half_y, half_y);
    if (inside) found = i;
  }
  return found;
}
