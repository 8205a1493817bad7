// The pyramid of the glare (render/glare.h says where its levels are). After frame.glsl.
layout(set = 0, binding = FL_BINDING_GLARE, rgba32f) uniform image2D glare;

// One step: from a level to the next coarser one, or back. Places are those of a level's first pixel in the image.
layout(push_constant) uniform Push {
  int fine_x;
  int fine_y;
  int fine_width;
  int fine_height;
  int coarse_x;
  int coarse_y;
  int coarse_width;
  int coarse_height;
  int level;  // the coarse one
  uint is_last;
  float share;  // of the light that is scattered
} push;

vec3 glare_at(ivec2 place, ivec2 p) { return imageLoad(glare, place + p).rgb; }

// A level has a margin for light that has left the picture: what is beyond that has come to nothing.
bool in_level(ivec2 p, ivec2 size) {
  return all(greaterThanEqual(p, ivec2(-FL_GLARE_MARGIN))) && all(lessThan(p, size + FL_GLARE_MARGIN));
}
