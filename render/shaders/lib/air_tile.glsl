// Light in the haze for a tile of 16 x 16 pixels, a workgroup: the walk over beams that reach it, with those of their
// shadows that do, and its pixels. The including pass has tile_takes() (tile_walk.glsl) and add_beams(). After beam.h,
// tile_test.glsl, shadow.glsl, mirror.glsl, with FL_USE_FINE_MASKS and FL_DEPTHS_ACCESS.
layout(constant_id = FL_SPEC_TILES) const bool kTiles = false;
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
// Whether plainbeams.comp says of tiles that there are other beams: where tiles have rows.
bool marks_tiles() { return kSolids && (kTiles || kShadows); }
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/shadow_rect.glsl"
layout(set = 0, binding = FL_BINDING_SHADE_WORDS, std430) readonly buffer ShadeWordsBuffer {
  ShadowWordRow shade_words[];
};
#define FL_PICKS_ACCESS readonly
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"

uint supertile() {
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  return cell.y * params.supertiles_x + cell.x;
}

// Beams with shadows, of which the passes before have added all of their light: what is in the shadows is subtracted.
#define FL_WALK_FINE (kTiles && counts.fine_groups[0] > 0u)
// Whether shade.comp has run: it does for pictures alone.
#define FL_WALK_LISTS (kShadows && FL_WALK_FINE && kView == uint(FL_VIEW_PICTURE))
#define FL_WALK_ALSO(word) (FL_WALK_LISTS ? shade_words[walk_word(word)].beams : 0u)
uint walk_word(uint word);
bool tile_takes(uint beam, uint number);
#include "render/shaders/lib/tile_walk.glsl"
#include "render/shaders/lib/shadow_walk.glsl"
#include "render/shaders/lib/plain_beams.glsl"

// Words of bits of the listed beams: without shadows in the tile, and with them.
uint walk_lit(uint word) { return kShadows ? walk_now[word] & ~walk_shaded[word] : walk_bits[word]; }
uint walk_cut(uint word) { return kShadows ? walk_shaded[word] : 0u; }

layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

bool touches_tile(BeamRow row) {
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  return beam_touches(row, beam_bound(row, 1.0), low, high);
}

// The ray of one of the thread's pixels: its unit direction, and where it ends.
struct AirRay {
  vec3 d;
  float t_max_m;
};
AirRay air_ray(int i) {
  ivec2 pixel = tile_pixel(i);
  bool inside = in_picture(pixel);
  vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
  float t_max_m = inside ? FL_FAR_M : 0.0;
  if (kSolids && inside) t_max_m = imageLoad(radiance, pixel).a;  // the surface pass left it there
  if (kGloss && ray_begin(d) >= FL_FAR_M) t_max_m = 0.0;
  return AirRay(d, t_max_m);
}
void air_store(int i, vec3 total) {
  ivec2 pixel = tile_pixel(i);
  if (!in_picture(pixel)) return;
  vec4 behind = kSolids || kTiles || kPlainBeams ? imageLoad(radiance, pixel) : vec4(0.0, 0.0, 0.0, 1.0);
  vec3 light = behind.rgb + light_scale() * total;
  // What is subtracted may be more than what was added, by their errors.
  if (kShadows && kTiles) light = max(light, vec3(0.0));
  imageStore(radiance, pixel, vec4(light, behind.a));  // the distance stays for depth of field
}

// Adds the light of the listed beams. begin: of those whose shadows were tested together.
void add_beams(uint begin, AirRay rays[FL_ROWS], inout vec3 total[FL_ROWS]);

// All of it, but for what is before and after. Arrays go through one call alone: NVIDIA's compiler keeps them in memory
// where they go through several, or in a structure.
#define FL_AIR_WALK                                                        \
  AirRay rays[FL_ROWS];                                                    \
  vec3 total[FL_ROWS];                                                     \
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {                           \
    rays[i] = air_ray(i);                                                  \
    total[i] = vec3(0.0);                                                  \
  }                                                                        \
  RectDepth depth;                                                         \
  if (kShadows) depth = rect_depth(gl_WorkGroupID.xy, 1u);                 \
  for (uint word = 0u; word < walk_words();) {                             \
    word = tile_walk(word);                                                \
    if (walk_count == 0u) continue;                                        \
    if (kShadows) walk_number_pairs();                                     \
    for (uint begin = 0u; begin < FL_WALK_BEAMS;) {                        \
      uint end = kShadows ? walk_test_shadows(begin, depth) : FL_WALK_BEAMS; \
      add_beams(begin, rays, total);                                       \
      begin = end;                                                         \
    }                                                                      \
  }                                                                        \
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) air_store(i, total[i]);
