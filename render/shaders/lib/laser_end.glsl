// Where the beams of a sheet end: at the first thing that hides light, or at the end of their range. After
// laser_row.glsl, kShadows and kBodies.
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };

// Length of a beam that leaves within a thing, m. A thing that ends within it is behind the place: that stands on a
// face.
const float kInside = 1e-4;
struct BeamEnd {
  float length_m;
  uint which;  // occluder; FL_NONE: none
};

// The first thing that a beam enters. What holds the place where it leaves hides all of it.
BeamEnd beam_end(vec3 lens_m, vec3 way, uint own, float range_m) {
  BeamEnd end = BeamEnd(range_m, FL_NONE);
  uint all = uint(occluders.length());
  if (!kBodies) all = min(all, params.box_count);
  for (uint i = 0u; i < all; ++i) {
    OccluderRow solid = occluders[i];
    if (solid.half_edge_0.w < 0.0 || solid.fixture == own) continue;
    vec3 to_center = vec3(solid.center_x, solid.center_y, solid.center_z) - lens_m;
    float along_m = dot(to_center, way);
    float square = dot(to_center, to_center) - along_m * along_m;
    if (square > solid.half_edge_0.w * solid.half_edge_0.w * 1.0001) continue;
    vec3 half_edge[3] = vec3[3](solid.half_edge_0.xyz, solid.half_edge_1.xyz, solid.half_edge_2.xyz);
    float enter_m = -FL_FAR_M;
    float leave_m = FL_FAR_M;
    for (int e = 0; e < 3; ++e) {
      vec3 normal = cross(half_edge[(e + 1) % 3], half_edge[(e + 2) % 3]);
      float reach = abs(dot(normal, half_edge[e]));
      float at = dot(normal, to_center);
      float speed = dot(normal, way);
      // Places between -reach and reach are inside.
      if (abs(speed) < 1e-12 * reach || speed == 0.0) {
        if (abs(at) > reach) enter_m = FL_FAR_M;
        continue;
      }
      float first = (at - reach) / speed;
      float second = (at + reach) / speed;
      enter_m = max(enter_m, min(first, second));
      leave_m = min(leave_m, max(first, second));
    }
    if (enter_m > leave_m || leave_m < kInside) continue;
    float length_m = max(enter_m, kInside);
    if (length_m < end.length_m) end = BeamEnd(length_m, i);
  }
  return end;
}

struct SheetEnd {
  vec4 ends;
  float jump;
  uint fixture_1;
  uint fixture_2;
  float slack_m;
};

// Two beams end at different things: where between them that changes is found by halving. What is narrower than the
// sheet is missed.
SheetEnd sheet_end(LaserRow row, vec3 lens_m, uint own, float range_m) {
  SheetEnd sheet;
  float reach = row.first.w;
  float side = sqrt(1.0 + reach * reach);
  sheet.ends = vec4(1.0, 1.0, side, side) / range_m;
  sheet.jump = reach;
  sheet.fixture_1 = FL_NONE;
  sheet.fixture_2 = FL_NONE;
  sheet.slack_m = 0.0;
  if (!kShadows) return sheet;
  BeamEnd first = beam_end(lens_m, row.first.xyz, own, range_m);
  BeamEnd last = first;
  if (reach > 0.0) last = beam_end(lens_m, normalize(row.first.xyz + row.second.xyz * reach), own, range_m);
  BeamEnd before = last;
  BeamEnd after = last;
  float low = 0.0;
  float high = reach;
  if (first.which != last.which) {
    before = first;
    for (int i = 0; i < 12; ++i) {
      float middle = 0.5 * (low + high);
      BeamEnd there = beam_end(lens_m, normalize(row.first.xyz + row.second.xyz * middle), own, range_m);
      if (there.which == first.which) {
        low = middle;
        before = there;
      } else {
        high = middle;
        after = there;
      }
    }
    sheet.jump = 0.5 * (low + high);
  }
  float at_low = sqrt(1.0 + low * low);
  float at_high = sqrt(1.0 + high * high);
  if (first.which == last.which) at_low = side;
  sheet.ends = vec4(1.0 / first.length_m, at_low / before.length_m, at_high / after.length_m, side / last.length_m);
  uint first_one = first.which;
  uint last_one = last.which;
  if (first_one != FL_NONE) {
    sheet.fixture_1 = occluders[first_one].fixture;
    sheet.slack_m = occluders[first_one].half_edge_1.w;
  }
  if (last_one != FL_NONE) {
    sheet.fixture_2 = occluders[last_one].fixture;
    sheet.slack_m = max(sheet.slack_m, occluders[last_one].half_edge_1.w);
  }
  return sheet;
}
