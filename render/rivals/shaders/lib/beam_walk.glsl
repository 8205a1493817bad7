// The walk over the beams of a tile, with the test of the beam pass. After rival_light.glsl.
bool tile_takes(uint beam, uint number) {
  BeamRow row = beams[beam];
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  return beam_touches(row, beam_bound(row, 1.0), low, high);
}
#include "render/shaders/lib/tile_walk.glsl"
