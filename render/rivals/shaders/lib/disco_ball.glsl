// A disco ball: DiscoBall in render/resources.h.
layout(push_constant) uniform Push {
  uint head_first;
  uint head_count;
  float spot_cd;
} ball;
