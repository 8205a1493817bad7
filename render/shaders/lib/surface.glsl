// What solid thing a pixel's ray meets, and how far away: the stage box that boxes.comp found, by cutting the ray with
// it, and fixture bodies from the visibility buffer. Boxes are not drawn, since the plane of a face is exact where
// interpolated depth is not (hardware snaps corners to 1/256 of a pixel, centimetres on a floor seen from far away),
// and since fragment work is slow on some GPUs: two boxes over 3840 x 2160 take 3.3 ms to draw on an H200.
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
layout(constant_id = FL_SPEC_SHEEN) const bool kSheen = false;
layout(set = 0, binding = FL_BINDING_SURFACE_ID, rg32ui) uniform readonly uimage2D surface_id;
layout(set = 0, binding = FL_BINDING_DEPTH) uniform sampler2D depth_image;
layout(set = 0, binding = FL_BINDING_BOXES, std430) readonly buffer BoxesBuffer { BoxRow boxes[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_BOXES, std430) readonly buffer PixelBoxesBuffer { uint pixel_boxes[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_DEPTHS, std430) readonly buffer SmallDepthsBuffer { uint pixel_depths[]; };
#include "render/shaders/lib/normal.glsl"
#include "render/shaders/lib/mirror.glsl"

// Where a pixel shows nothing.
const float kNothingM = FL_FAR_M;

const uint kNothing = 0u;
const uint kBox = 1u;
const uint kBody = 2u;
const uint kObject = 3u;

struct Surface {
  uint kind;
  uint which;   // box; head << 3 | part; of an object its albedo, 10 bits each
  vec3 normal;  // unit, outwards
  float t_m;    // along the unit ray
  uint sheen;   // its SheenRow; 0: matt
};

// What the visibility buffer has at a pixel, without its distance.
Surface triangle_of(uvec2 id) {
  bool object = (id.y & FL_OBJECT) != 0u;
  uint sheen = 0u;
  bool marked = kSheen && (id.y & FL_BODY_SHEEN) != 0u;  // the same bit of an object
  vec3 normal = marked ? unpack_sheen_normal(id.x, sheen) : unpack_normal(id.x);
  return Surface(object ? kObject : kBody, object ? id.y & ~FL_OBJECT : (id.y & ~FL_BODY_SHEEN) - 1u, normal, kNothingM,
                 sheen);
}
float triangle_depth(ivec2 pixel) {
  if (FL_NOT_IN_CODE(params.computed_triangles) == 0u) return texelFetch(depth_image, pixel, 0).x;
  return uintBitsToFloat(pixel_depths[uint(pixel.y) * params.width + uint(pixel.x)]);
}
Surface triangle_at(ivec2 pixel) {
  if (!(triangle_depth(pixel) > 0.0)) return Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), kNothingM, 0u);
  return triangle_of(imageLoad(surface_id, pixel).xy);
}

// ray: unit, through the pixel's middle.
Surface surface_at(ivec2 pixel, vec3 ray) {
  Surface hit = Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), kNothingM, 0u);
  if (kBodies) {
    float depth = triangle_depth(pixel);
    if (depth > 0.0) {  // elsewhere nothing has written the identity
      hit = triangle_of(imageLoad(surface_id, pixel).xy);
      hit.t_m = params.right.w / (depth * dot(ray, params.forward.xyz));
    }
  }
  if (kBoxes) {
    uint box = pixel_boxes[uint(pixel.y) * params.width + uint(pixel.x)];
    if (box != FL_NONE) {
      // The face is where the ray comes in last.
      vec3 inverse = 1.0 / mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
      vec3 in_m = min((boxes[box].low.xyz - params.position.xyz) * inverse,
                      (boxes[box].high.xyz - params.position.xyz) * inverse);
      float enter_m = max(in_m.x, max(in_m.y, in_m.z));
      vec3 face = in_m.x >= enter_m ? vec3(1, 0, 0) : in_m.y >= enter_m ? vec3(0, 1, 0) : vec3(0, 0, 1);
      if (enter_m < hit.t_m) {
        hit = Surface(kBox, box, -sign(ray) * face, enter_m, kSheen ? uint(boxes[box].albedo.w) : 0u);
      }
    }
  }
  return hit;
}
