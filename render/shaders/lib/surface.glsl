// The visibility buffer: what solid thing a pixel shows, and how far away it is.
layout(set = 0, binding = FL_BINDING_SURFACE_ID, rg32ui) uniform readonly uimage2D surface_id;
layout(set = 0, binding = FL_BINDING_DEPTH) uniform sampler2D depth_image;

layout(set = 0, binding = FL_BINDING_BOXES, std430) readonly buffer BoxesBuffer { BoxRow boxes[]; };
#include "render/shaders/lib/normal.glsl"

// Where a pixel shows nothing, air is seen as far as kAirRangeM of render/image.h; beams end long before.
const float kNothingM = 1000.0;

// Distance along the unit ray to what the pixel shows. On a box the ray is cut with the plane of its face, since depth is
// interpolated from corners that hardware snaps to 1/256 of a pixel, which is centimetres on a floor seen from far away.
float surface_distance(ivec2 pixel, uvec2 id, vec3 unit_ray) {
  uint kind = id.y >> 30;
  if (kind == uint(FL_SURFACE_BOX)) {
    BoxRow box = boxes[id.y & 0x3fffffffu];
    vec3 normal = unpack_normal(id.x);
    vec3 face = mix(box.low.xyz, box.high.xyz, step(0.0, normal));
    return clamp(dot(face - params.position.xyz, normal) / dot(unit_ray, normal), 0.0, kNothingM);
  }
  if (kind == uint(FL_SURFACE_FIXTURE)) {
    return params.right.w / (texelFetch(depth_image, pixel, 0).x * dot(unit_ray, params.forward.xyz));
  }
  return kNothingM;
}

