// Sizes of shadow maps, which C++ and shaders share.
// Maps of this many texels a side have rows, too (lib/shadow_rows.glsl): as many, of as many places in groups.
#define FL_MAP_ROWS 64
#define FL_ROW_NODES_MAX 5  // Gauss nodes of a beam up to which its light is read with rows
#define FL_CUT_NODES 3  // with which light of a chord with exact shadows is one polynomial (plainbeams.comp)
#define FL_MAP_ROW_GROUPS 8
#define FL_MAP_GROUP_WORDS 4  // two places a word
// Two groups a word: their least numbers, then their largest ones. Then the groups.
#define FL_MAP_ROW_WORDS (2 * (FL_MAP_ROW_GROUPS / 2) + FL_MAP_ROW_GROUPS * FL_MAP_GROUP_WORDS)
// Bodies that hide light, in the order of their table, have a sphere around each so many: four floats a sphere, which
// stand behind all maps at the end of their table.
#define FL_OCCLUDER_GROUP 32
