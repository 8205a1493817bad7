// Rays through the solids that light ends at (BounceSolidRow), by the tree over them.
layout(set = 0, binding = FL_BINDING_BOUNCE_SOLIDS, std430) readonly buffer BounceSolidsBuffer {
  BounceSolidRow solids[];  // the stage boxes, then all in the order of the tree
};
layout(set = 0, binding = FL_BINDING_BOUNCE_TREE, std430) readonly buffer BounceTreeBuffer { TreeRow bounce_tree[]; };

vec3 bounce_divisor(vec3 d, float least) { return mix(d, vec3(least), lessThan(abs(d), vec3(least))); }

// The first solid between t_min and t_max that a ray enters, and where; any: whichever is found first. It is FL_NONE
// if there is none. A ray that begins in a solid enters it at t_min. face: as BounceSolidRow.
uint bounce_hit(vec3 from, vec3 way, float t_min, float t_max, bool any_one, out float t, out uint face) {
  uint found = FL_NONE;
  t = t_max;
  face = 0u;
  vec3 inverse = 1.0 / bounce_divisor(way, 1e-12);
  uint end = bounce_tree[0].skip;
  for (uint n = 0u; n < end;) {
    TreeRow node = bounce_tree[n];
    vec3 to_low = (vec3(node.low_x, node.low_y, node.low_z) - from) * inverse;
    vec3 to_high = (vec3(node.high_x, node.high_y, node.high_z) - from) * inverse;
    vec3 in_t = min(to_low, to_high);
    vec3 out_t = max(to_low, to_high);
    bool touches = max(max(in_t.x, in_t.y), max(in_t.z, t_min)) <= min(min(out_t.x, out_t.y), min(out_t.z, t));
    uint first = params.box_count + (node.leaf >> FL_TREE_COUNT_BITS);
    uint count = touches ? node.leaf & ((1u << FL_TREE_COUNT_BITS) - 1u) : 0u;
    for (uint s = first; s < first + count; ++s) {
      vec3 at = vec3(dot(solids[s].dual[0].xyz, from) + solids[s].dual[0].w,
                     dot(solids[s].dual[1].xyz, from) + solids[s].dual[1].w,
                     dot(solids[s].dual[2].xyz, from) + solids[s].dual[2].w);
      vec3 d = bounce_divisor(vec3(dot(solids[s].dual[0].xyz, way), dot(solids[s].dual[1].xyz, way),
                                   dot(solids[s].dual[2].xyz, way)), 1e-9);
      vec3 in_solid = -(sign(d) + at) / d;
      vec3 out_solid = (sign(d) - at) / d;
      float enter = max(in_solid.x, max(in_solid.y, in_solid.z));
      float leave = min(out_solid.x, min(out_solid.y, out_solid.z));
      bool hit = max(enter, t_min) < min(leave, t);
      if (hit) {
        found = s;
        t = max(enter, t_min);
        uint axis = in_solid.x >= enter ? 0u : in_solid.y >= enter ? 1u : 2u;
        float along = axis == 0u ? d.x : axis == 1u ? d.y : d.z;
        face = 2u * axis + (along < 0.0 ? 1u : 0u);
      }
    }
    n = any_one && found != FL_NONE ? end : touches ? n + 1u : node.skip;
  }
  return found;
}
