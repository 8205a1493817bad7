// Beams with one sharp image, whose whole chords have a table: the tile passes take them together where every chord
// crosses the whole disc. After tile_test.glsl, with FL_USE_BEAMS. Without FL_GOBO_TILES there are none.
#ifdef FL_GOBO_TILES
#include "render/shaders/lib/has_gobo.glsl"
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
bool tile_knows_gobo(BeamRow row) {
  return has_gobo(row) && (row.flags & FL_BEAM_BLADES) == 0u && row.y_axis.w <= kWideSpread &&
         gobo_whole_layer(row, gobo_only_image(row)) != 0u;
}
#else
bool tile_knows_gobo(BeamRow row) { return false; }
#endif
