// Chords across the whole disc of an image: a texel of a table for each, four weights of the nodes of W (gobo_chord.h).
layout(set = 0, binding = FL_BINDING_GOBO_WHOLE) uniform sampler2DArray gobo_whole;

// The angle of a straight line, in half turns, 0 to 1, within 3e-6. Polynomial 4.4.49 of Abramowitz and Stegun.
float half_turns(vec2 way) {
  vec2 size = abs(way);
  float r = min(size.x, size.y) / max(max(size.x, size.y), 1e-30);
  float q = r * r;
  float angle = r * (0.9998660 + q * (-0.3302995 + q * (0.1801410 + q * (-0.0851330 + q * 0.0208351))));
  if (size.y > size.x) angle = 1.5707963267948966 - angle;
  if ((way.x < 0.0) != (way.y < 0.0)) angle = 3.141592653589793 - angle;
  return angle * 0.3183098861837907;
}

// Where entry `at` of `count` lies in a texture of `size` texels of which the table begins at `first`.
float gobo_texel(float at, float first, float size) { return (first + at + 0.5) / size; }
float gobo_offset_texel(float offset, float count) {
  return gobo_texel((0.5 * offset + 0.5) * (count - 1.0), 0.0, count);
}

// The image times the profile times W, a mean over the chord. way: its direction in the image. w: W at the four nodes.
vec3 gobo_whole_mean(uint layer, uint planes, float offset, vec2 way, vec4 w) {
  bool back = way.y < 0.0;  // the last row of the table has the direction (-1, 0)
  if (back) w = w.wzyx;
  vec2 at = vec2(gobo_offset_texel(back ? -offset : offset, float(FL_GOBO_CHORDS)),
                 gobo_texel(half_turns(way) * float(FL_GOBO_ANGLES), 0.0, float(FL_GOBO_ANGLES + 1)));
  vec3 light = vec3(dot(textureLod(gobo_whole, vec3(at, float(layer - 1u)), 0.0), w));
  if (planes > 1u) {
    light.g = dot(textureLod(gobo_whole, vec3(at, float(layer)), 0.0), w);
    light.b = dot(textureLod(gobo_whole, vec3(at, float(layer + 1u)), 0.0), w);
  }
  return max(light, vec3(0.0));
}
