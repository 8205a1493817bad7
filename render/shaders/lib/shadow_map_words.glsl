// The words of a beam's shadow map: FL_MAP_CELLS x FL_MAP_CELLS cells, then the texels. After kMapPx.
const uint kMapCells = uint(FL_MAP_CELLS);
const uint kMapWords = kMapPx * kMapPx + kMapCells * kMapCells;
