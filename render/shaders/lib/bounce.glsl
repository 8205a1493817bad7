// Illuminance of surfaces by light that other surfaces reflect (render/bounce_tables.h): of a stage box between the
// patches of its face, of everything else between probes. After surface.glsl.
layout(constant_id = FL_SPEC_BOUNCE) const bool kBounce = false;
layout(set = 0, binding = FL_BINDING_BOUNCE_SOLIDS, std430) readonly buffer BounceSolidsBuffer {
  BounceSolidRow bounce_solids[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_GRID, std430) readonly buffer BounceGridBuffer {
  BounceGrid bounce_grid;
  BounceProbeRow bounce_probes[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_LIGHT, std430) readonly buffer BounceLightBuffer { vec4 bounce_light[]; };

const float kBounceSlackM = 0.01;  // a place may be this far behind what a probe sees

// Between the nearest four patches of a face; what is covered does not count.
vec3 bounced_on_face(uint first, uint counts, vec2 at) {
  uvec2 count = uvec2(counts & 0xffffu, counts >> 16);
  vec2 place = clamp(at * vec2(count) - 0.5, vec2(0.0), vec2(count) - 1.0);
  uvec2 low = min(uvec2(place), count - 1u);
  vec2 share = place - vec2(low);
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < 4u; ++i) {
    uvec2 side = uvec2(i & 1u, i >> 1);
    uvec2 own = min(low + side, count - 1u);
    vec2 weight = mix(1.0 - share, share, vec2(side));
    vec4 light = bounce_light[first + own.y * count.x + own.x];
    sum += weight.x * weight.y * light.w * vec4(light.rgb, 1.0);
  }
  return sum.rgb / max(sum.w, 1e-6);
}

// Between the nearest eight probes, a quarter of a cell in front of the surface. A probe that does not see as far as
// the place along an axis is behind a wall or below a floor.
vec3 bounced_on_body(vec3 normal, vec3 place) {
  uvec3 count = uvec3(bounce_grid.probes_x, bounce_grid.probes_y, bounce_grid.probes_z);
  vec3 cell = (place - bounce_grid.low.xyz) / bounce_grid.low.w + 0.25 * normal;
  cell = clamp(cell, vec3(0.0), vec3(count) - 1.0);
  uvec3 low = min(uvec3(cell), count - 1u);
  vec3 share = cell - vec3(low);
  vec3 square = normal * normal;
  uvec3 face = uvec3(0u, 2u, 4u) + uvec3(lessThan(normal, vec3(0.0)));
  uint probes = count.x * count.y * count.z;
  uint first = uint(FL_BOUNCE_LISTS) * bounce_grid.patches;
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < 8u; ++i) {
    uvec3 side = uvec3(i & 1u, i >> 1 & 1u, i >> 2);
    uvec3 own = min(low + side, count - 1u);
    uint probe = (own.z * count.y + own.y) * count.x + own.x;
    vec3 away = place - (bounce_grid.low.xyz + bounce_grid.low.w * vec3(own));
    vec3 weights = mix(1.0 - share, share, vec3(side));
    float weight = weights.x * weights.y * weights.z * float(bounce_probes[probe].usable);
    bool clear = true;
    [[unroll]] for (uint a = 0u; a < 3u; ++a) {
      clear = clear && abs(away[a]) <= bounce_probes[probe].clear_m[2u * a + (away[a] < 0.0 ? 1u : 0u)] + kBounceSlackM;
    }
    weight *= clear ? 1.0 : 1e-4;  // where all are hidden, they are better than nothing
    vec3 lx = square.x * bounce_light[first + face.x * probes + probe].rgb +
              square.y * bounce_light[first + face.y * probes + probe].rgb +
              square.z * bounce_light[first + face.z * probes + probe].rgb;
    sum += weight * vec4(lx, 1.0);
  }
  return sum.rgb / max(sum.w, 1e-12);
}

// place: on the stage.
vec3 bounced_lx(Surface surface, vec3 place) {
  vec3 lx = vec3(0.0);
  uint first = FL_NONE;
  if (bounce_grid.patches == 0u) return lx;
  if (surface.kind == kBox) {
    vec3 size = abs(surface.normal);
    uint axis = size.x > 0.5 ? 0u : size.y > 0.5 ? 1u : 2u;
    uint face = 2u * axis + (surface.normal[axis] > 0.0 ? 1u : 0u);
    first = bounce_solids[surface.which].first[face];
    if (first != FL_NONE) {
      vec3 low = boxes[surface.which].low.xyz;
      vec3 at = (place - low) / max(boxes[surface.which].high.xyz - low, vec3(1e-6));
      vec2 on_face = vec2(at[(axis + 1u) % 3u], at[(axis + 2u) % 3u]);
      lx = bounced_on_face(first, bounce_solids[surface.which].count[face], on_face);
    }
  }
  if (surface.kind != kNothing && first == FL_NONE) lx = bounced_on_body(surface.normal, place);
  return lx;
}
