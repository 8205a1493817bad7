// Materials with sheen (shared/sheen.h): the light of a beam that they reflect to the eye. After surface_light.glsl and
// sheen.h.
layout(set = 0, binding = FL_BINDING_SHEENS, std430) readonly buffer SheensBuffer { SheenRow sheens[]; };

// How much the normals of triangles turn from a pixel to its neighbours on the same material, squared: to the right and
// down, or where another thing is there to the left and up.
float normal_turn(ivec2 pixel, Surface surface) {
  float turn = 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    float own = 0.0;
    for (int side = 1; side >= -1 && own == 0.0; side -= 2) {
      ivec2 beside = pixel + (axis == 0 ? ivec2(side, 0) : ivec2(0, side));
      if (any(lessThan(beside, ivec2(0))) || beside.x >= int(params.width) || beside.y >= int(params.height)) continue;
      Surface other = triangle_at(beside);
      vec3 apart = other.normal - surface.normal;
      if (other.kind == surface.kind && other.sheen == surface.sheen) own = dot(apart, apart);
    }
    turn += own;
  }
  return turn;
}

// Of a surface with sheen; albedo: of its matt part, as other light is reflected. On curved things normals turn within
// a pixel; their spread counts as roughness, so that highlights that are narrower than a pixel are not lost between
// pixels (Tokuyoshi, Kaplanyan 2019, "Improved Geometric Specular Antialiasing"; the numbers are theirs).
Sheen surface_sheen(ivec2 pixel, Surface surface, vec3 albedo) {
  SheenRow row = sheens[surface.sheen];
  Sheen sheen = sheen_of(surface.kind == kBody ? row.color.rgb : albedo, albedo, row.roughness, row.metal);
  if (kBodies && surface.kind != kBox) {
    float spread = min(0.5 * normal_turn(pixel, surface), 0.18);
    sheen.alpha = min(sqrt(sheen.alpha * sheen.alpha + spread), 1.0);
  }
  return sheen;
}

// Reflected light over the illuminance across the surface, 1/sr. way: along which the light travels; lens_rad: half the
// angle under which its lens is seen. offset_m: of the place from the camera.
vec3 sheen_share(Sheen sheen, Surface surface, vec3 offset_m, vec3 way, float lens_rad) {
  return sheen_reflected(sheen, lens_rad, surface.normal, -normalize(offset_m), -way);
}

// The direction of a beam's light on the stage, from that in its light space (beam_direction()).
vec3 way_on_stage(BeamRow row, vec3 way) {
  return row.x_axis.xyz * way.x + row.y_axis.xyz * way.y + row.axis.xyz * way.z;
}
// The way of a plain beam's light at a place in its light space, with z = 1.
vec3 plain_way(BeamRow row, vec3 p) {
  return vec3(p.xy * (row.y_axis.w / (row.x_axis.w + row.y_axis.w * p.z)), 1.0);
}
// Half the angle under which a beam's lens is seen from r_m, of a rectangle across its width.
float lens_angle(BeamRow row, float r_m) {
  float radius_m = kRectangle && row.squeeze > 0.0 ? 0.70710678 * row.x_axis.w : row.x_axis.w;
  return radius_m / max(r_m, 1e-3);
}
