// The words of a beam's shadow map: FL_MAP_CELLS x FL_MAP_CELLS cells, then the texels, then the rows. After kMapPx.
#include "render/shaders/shared/shadow_map.h"
const uint kMapCells = uint(FL_MAP_CELLS);
const bool kMapRows = kMapPx == uint(FL_MAP_ROWS);
const uint kMapRowsAt = kMapPx * kMapPx + kMapCells * kMapCells;
const uint kMapWords = kMapRowsAt + (kMapRows ? uint(FL_MAP_ROWS * FL_MAP_ROW_WORDS) : 0u);
uint occluder_groups(uint bodies) { return (bodies + uint(FL_OCCLUDER_GROUP) - 1u) / uint(FL_OCCLUDER_GROUP); }
