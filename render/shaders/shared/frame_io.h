// What the passes of a frame share: bindings, buffers' rows, sizes. Included by GLSL and, inside a namespace with GLM
// aliases, by C++ (render/frame_io.h). No include guard.

// Bindings of the one descriptor set.
#define FL_BINDING_PARAMS 0
#define FL_BINDING_LEVELS 1
#define FL_BINDING_TYPES 2
#define FL_BINDING_CHANNELS 3
#define FL_BINDING_FUNCTIONS 4
#define FL_BINDING_FIXTURES 5
#define FL_BINDING_STATES 6
#define FL_BINDING_BEAMS 7
#define FL_BINDING_COUNTS 8
#define FL_BINDING_MASKS 9
#define FL_BINDING_BOXES 10
#define FL_BINDING_SURFACE_ID 11
#define FL_BINDING_DEPTH 12
#define FL_BINDING_RADIANCE 13
#define FL_BINDING_SCREEN 14
#define FL_BINDING_GOBOS 15
#define FL_BINDING_INSTANCES 16
#define FL_BINDING_COUNT 17

// Specialisation constants.
#define FL_SPEC_MOTION 0
#define FL_SPEC_STROBE 1
#define FL_SPEC_GOBO 2
#define FL_SPEC_EXTINCTION 3
#define FL_SPEC_PROFILE 4
#define FL_SPEC_METHOD 5
#define FL_SPEC_NODES 6
#define FL_SPEC_GOBO_TAPS 7
#define FL_SPEC_BOXES 8
#define FL_SPEC_BODIES 9
#define FL_SPEC_COUNT 10

#define FL_METHOD_GAUSS 0
#define FL_METHOD_MARCH 1

#define FL_GROUP_FIXTURES 64  // fixtures a workgroup
#define FL_TILE_PX 16         // a workgroup shades one tile
#define FL_SUPERTILE_PX 64    // beams are listed per supertile, one bit a live beam
#define FL_GROUP_MASK 64      // beams a workgroup of the tile pass tests

// Camera, medium and sizes of one frame; 112 bytes, uploaded each frame.
struct FrameParams {
  vec4 right;     // xyz: unit right x tan(fov / 2) x width / height; w: near plane, m
  vec4 up;        // xyz: unit up x tan(fov / 2); w: range of light, m
  vec4 forward;   // xyz: unit; w: sigma_s, 1/m
  vec4 position;  // xyz: camera, m; w: sigma_t, 1/m
  uint width;
  uint height;
  uint fixture_count;
  uint box_count;
  uint supertiles_x;
  uint mask_words;    // 32-bit words a supertile
  float anisotropy;   // g of Henyey-Greenstein
  float ambient_lx;
  float exposure;     // from cd/m^2 to the tone map's 1.0
  float dark_lm;      // a beam with less flux is not drawn
  uint pad;
  uint pad_1;
};

// One lit beam, 96 bytes. Light space is camera-relative: eye = camera in it.
struct BeamRow {
  vec4 x_axis;  // xyz in stage space; w: lens radius R0, m
  vec4 y_axis;  // w: spread k
  vec4 axis;    // w: range, m
  vec4 eye;     // xyz: camera in light space, m; w: profile m
  vec4 j0;      // rgb: J0 per channel, lm; w: unused
  uint gobo;    // 0: open
  float gobo_cos;
  float gobo_sin;
  uint fixture;
};

// Counts of a frame. live_count and the indirect arguments are written by the last workgroup of the gather pass.
struct CountsRow {
  uint live_count;
  uint dark_count;
  uint pad;
  uint pad_1;
  uint tiles_groups[4];    // indirect arguments of the tile pass: x = live / FL_GROUP_MASK, y = supertiles, z = 1
  uint beams_groups[4];    // of the beam pass: 0 x 0 x 0 when nothing is lit
};

// A solid box, 48 bytes.
struct BoxRow {
  vec4 low;     // m
  vec4 high;    // m
  vec4 albedo;  // linear
};

// The visibility buffer of fixture bodies, two words a pixel: packed normal; 0 for nothing, else 1 + (fixture << 3 |
// part).
