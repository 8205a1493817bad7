// Rows of lasers, and what shared/laser.h makes of them. After frame.glsl and beam.h.
#include "render/shaders/shared/laser.h"
layout(set = 0, binding = FL_BINDING_LASERS, std430) FL_LASERS_ACCESS buffer LasersBuffer { LaserRow lasers[]; };

LaserSheet laser_sheet(LaserRow row) {
  LaserSheet sheet;
  sheet.first = row.first.xyz;
  sheet.second = row.second.xyz;
  sheet.reach = row.first.w;
  sheet.spread = row.second.w;
  sheet.eye = row.eye.xyz;
  sheet.cross_1 = row.cross_1.xyz;
  sheet.cross_2 = row.cross_2.xyz;
  sheet.variance = row.eye.w;
  sheet.slope_square = row.cross_1.w;
  sheet.jump = row.light.w;
  sheet.end = float[4](row.ends.x, row.ends.y, row.ends.z, row.ends.w);
  return sheet;
}

vec3 laser_step_x() { return params.right.xyz * (2.0 / float(params.width)); }
vec3 laser_step_y() { return params.up.xyz * (-2.0 / float(params.height)); }

// Beyond so many deviations a Gaussian counts as 0: 3e-5 of its light is there.
const float kLaserReach = 4.2;

// Whether a sheet may touch the pixels low to high.
bool laser_touches(LaserRow row, vec2 low, vec2 high) {
  if (any(greaterThan(row.box.xy, high)) || any(lessThan(row.box.zw, low))) return false;
  vec2 middle = 0.5 * (low + high);
  vec2 half_size = 0.5 * (high - low);
  vec3 ray = ray_through(middle);
  float at[2];
  float most = FL_FAR_M;
  for (int side = 0; side < 2; ++side) {
    vec3 normal = row.cross_1.xyz + row.cross_2.xyz * (side == 0 ? 0.0 : row.first.w);
    vec2 slope = vec2(dot(laser_step_x(), normal), dot(laser_step_y(), normal));
    at[side] = dot(ray, normal);
    // The line's picture is where `at` is 0.
    float reach = dot(abs(slope), half_size) + row.cross_2.w * length(slope);
    most = min(most, abs(at[side]) - reach);
  }
  return most <= 0.0 || at[0] * at[1] <= 0.0;
}
