// What the passes of a frame share: bindings, buffers' rows, sizes. Included by GLSL and, inside a namespace with GLM
// aliases, by C++ (render/frame_io.h). No include guard.

// Bindings of the one descriptor set.
#define FL_BINDING_PARAMS 0
#define FL_BINDING_LEVELS 1
// Tables of the rig (fixtures/shared/tables.h).
#define FL_BINDING_TYPES 2
#define FL_BINDING_CHANNELS 3
#define FL_BINDING_FUNCTIONS 4
#define FL_BINDING_MASTERS 5
#define FL_BINDING_MOTORS 6
#define FL_BINDING_SPINS 7
#define FL_BINDING_JOINTS 8
#define FL_BINDING_WHEEL_SLOTS 9
#define FL_BINDING_DEFAULTS 10
#define FL_BINDING_COLORS 11
#define FL_BINDING_HEADS 12
// States of the heads (fixtures/shared/state.h).
#define FL_BINDING_STATES 13
#define FL_BINDING_MOTOR_STATES 14
#define FL_BINDING_SPIN_STATES 15
#define FL_BINDING_SHUTTER_STATES 16
// What passes hand on.
#define FL_BINDING_BEAMS 17
#define FL_BINDING_COUNTS 18
#define FL_BINDING_MASKS 19
#define FL_BINDING_BOXES 20
#define FL_BINDING_SURFACE_ID 21
#define FL_BINDING_DEPTH 22
#define FL_BINDING_RADIANCE 23
#define FL_BINDING_SCREEN 24
#define FL_BINDING_GOBOS 25
#define FL_BINDING_INSTANCES 26
#define FL_BINDING_WHEELS 27
#define FL_BINDING_FACETS 28
#define FL_BINDING_OPTICS_STATES 29
#define FL_BINDING_BLADES 30  // BladesRow, one a beam
// Lamps, dimmers that move and levels that are smoothed: a table of the rig and states of heads.
#define FL_BINDING_LIGHTS 31
#define FL_BINDING_DOWSER_STATES 32
#define FL_BINDING_SMOOTH_STATES 33
// States of each kind of lamp, by its number in FL_LAMPS (fixtures/shared/tables.h).
#define FL_BINDING_LAMP(number) (33 + number)
// What the beam passes hand on: TileDepthRow, one a tile; CoarseRow, one a supertile; masks of FL_FINE_PX.
#define FL_BINDING_TILE_DEPTHS (34 + FL_LAMP_COUNT)
#define FL_BINDING_COARSE (35 + FL_LAMP_COUNT)
#define FL_BINDING_FINE_MASKS (36 + FL_LAMP_COUNT)
// Bodies: their meshes (BodyMeshRow, BodyLevelRow, BodyVertexRow, indices), what is drawn of each this frame, and the
// picture of small ones. FL_BINDING_INSTANCES has one BodySlotRow a body.
#define FL_BINDING_BODY_MESHES (37 + FL_LAMP_COUNT)
#define FL_BINDING_BODY_LEVELS (38 + FL_LAMP_COUNT)
#define FL_BINDING_BODY_VERTICES (39 + FL_LAMP_COUNT)
#define FL_BINDING_BODY_INDICES (40 + FL_LAMP_COUNT)
#define FL_BINDING_BODY_CHOICES (41 + FL_LAMP_COUNT)  // one word a body: FL_CHOICE_...
#define FL_BINDING_BODY_DRAWN (42 + FL_LAMP_COUNT)    // heads, by mesh and level: the instances of the raster
#define FL_BINDING_BODY_DRAWS (43 + FL_LAMP_COUNT)    // indirect draw commands, one a level
#define FL_BINDING_PIXEL_DEPTHS (44 + FL_LAMP_COUNT)  // of triangles, one word a pixel: bits of the reversed depth
#define FL_BINDING_PIXEL_KEYS (45 + FL_LAMP_COUNT)    // one word a pixel: ~ the number of the triangle; 0: none.
// Where depths and keys are joined: 64 bits a pixel, the bits of the depth above its key.
// Tables of gobos in haze (render/passes/gobos.h): GoboTableRow, one an image; those that a frame builds; the images
// that hold them, as they are read and as they are written.
#define FL_BINDING_GOBO_TABLES (46 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_QUEUE (47 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_WHOLE (48 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_LINES (49 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_WHOLE_OUT (50 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_LINES_OUT (51 + FL_LAMP_COUNT)
#define FL_BINDING_RIMS (52 + FL_LAMP_COUNT)  // RimRow, FrameParams::rims_max a supertile
#define FL_BINDING_CUTS (53 + FL_LAMP_COUNT)  // CutRow, FrameParams::cuts_max a supertile
// Smooth edges: for each pixel which surface it shows (lib/edge_surfaces.glsl), then for each of those with an edge a
// depth, behind which is nothing that it and its neighbours show; the samples of pixels with edges
// (lib/edge_samples.glsl), and their colours;
// FL_EDGE_WORDS a tile: which pixels have an edge, and where their samples are.
#define FL_BINDING_EDGE_IDS (54 + FL_LAMP_COUNT)
#define FL_BINDING_EDGE_SAMPLES (55 + FL_LAMP_COUNT)
#define FL_BINDING_EDGES (56 + FL_LAMP_COUNT)
#define FL_BINDING_EDGE_MASKS (57 + FL_LAMP_COUNT)
#define FL_BINDING_RECHECKED (58 + FL_LAMP_COUNT)  // RecheckRow, one a cell (render/live_error.h)
// Gates with more than one thing in them (render/shaders/gates.comp): GatesHead with GateRow, and the images that are
// drawn of them, as they are read and as they are written.
#define FL_BINDING_GATES (59 + FL_LAMP_COUNT)
#define FL_BINDING_GATE_IMAGES (60 + FL_LAMP_COUNT)
#define FL_BINDING_GATE_IMAGES_OUT (61 + FL_LAMP_COUNT)
// Shadows (render/shaders/shadows.comp): OccluderRow, BodyBoxRow, ShadowListRow and ShadowRow.
#define FL_BINDING_OCCLUDERS (62 + FL_LAMP_COUNT)
#define FL_BINDING_BODY_BOXES (63 + FL_LAMP_COUNT)
#define FL_BINDING_SHADOW_LISTS (64 + FL_LAMP_COUNT)
#define FL_BINDING_SHADOWS (65 + FL_LAMP_COUNT)
#define FL_BINDING_GLARE (66 + FL_LAMP_COUNT)  // the pyramid of the camera's glare, in one image (render/glare.h)
#define FL_BINDING_METER (67 + FL_LAMP_COUNT)  // MeterRow
// Light that surfaces reflect to others (render/bounce_tables.h): BounceSolidRow; TreeRow over them; BouncePatchRow;
// BounceGrid with BounceProbeRow. What of the light of a patch reaches a patch, and a probe. Of a frame: the flux that
// beams bring to each patch, in units of 1 / FL_BOUNCE_FLUX lm, 64 bits a channel; the light of patches and of probes.
#define FL_BINDING_BOUNCE_SOLIDS (68 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_TREE (69 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_PATCHES (70 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_GRID (71 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_FORMS (72 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_FLUX (73 + FL_LAMP_COUNT)
#define FL_BINDING_BOUNCE_LIGHT (74 + FL_LAMP_COUNT)
#define FL_BINDING_LENSES (75 + FL_LAMP_COUNT)  // LensesHead, then LensRow, one a head (render/shaders/lenses.comp)
// Haze that is not even (lib/haze.glsl): HazeField, and the table, as it is read and as it is written.
#define FL_BINDING_HAZE (76 + FL_LAMP_COUNT)
#define FL_BINDING_HAZE_TABLE (77 + FL_LAMP_COUNT)
#define FL_BINDING_HAZE_TABLE_OUT (78 + FL_LAMP_COUNT)
// Scanned lasers (laserrows.comp): LaserState, LaserSegmentRow, LaserRow, and bits of those in a supertile.
#define FL_BINDING_LASER_STATES (79 + FL_LAMP_COUNT)
#define FL_BINDING_LASER_SEGMENTS (80 + FL_LAMP_COUNT)
#define FL_BINDING_LASERS (81 + FL_LAMP_COUNT)
#define FL_BINDING_LASER_MASKS (82 + FL_LAMP_COUNT)
// Shadows in the haze by supertile (lib/shadow_picks.glsl): ShadowWordRow, one a word of the masks, and the numbers of
// rows of the ShadowRow table; the first word is the number of words in use.
#define FL_BINDING_SHADOW_WORDS (83 + FL_LAMP_COUNT)
#define FL_BINDING_SHADOW_PICKS (84 + FL_LAMP_COUNT)
#define FL_BINDING_SHADE_WORDS (85 + FL_LAMP_COUNT)  // ShadowWordRow, one a word of the fine masks
// Panes that the sun shines through (shafts.comp): PaneRow; their images with all levels of detail, two words a texel
// of half floats; bits of the occluders that reach into each shaft.
#define FL_BINDING_PANES (86 + FL_LAMP_COUNT)
#define FL_BINDING_PANE_TEXELS (87 + FL_LAMP_COUNT)
#define FL_BINDING_PANE_MASKS (88 + FL_LAMP_COUNT)
// Displays (displays.comp): DisplayRow; DisplayLevelRow; the words of their cells from level 2 on; DisplayJobRow; the
// pixels of all, three floats each.
#define FL_BINDING_DISPLAYS (89 + FL_LAMP_COUNT)
#define FL_BINDING_DISPLAY_LEVELS (90 + FL_LAMP_COUNT)
#define FL_BINDING_DISPLAY_CELLS (91 + FL_LAMP_COUNT)
#define FL_BINDING_DISPLAY_JOBS (92 + FL_LAMP_COUNT)
// Shadow maps (lib/shadow_map.glsl), one a beam: FL_MAP_CELLS x FL_MAP_CELLS words of cells, then the texels, then
// the rows. Behind all maps the spheres around groups of what hides light (shared/shadow_map.h).
#define FL_BINDING_BEAM_MAPS (93 + FL_LAMP_COUNT)
// Floors that mirror (gloss.comp): GlossRow, and the pyramid of the mirrored camera's picture (render/mirror.h).
#define FL_BINDING_GLOSS (94 + FL_LAMP_COUNT)
#define FL_BINDING_MIRROR (95 + FL_LAMP_COUNT)
#define FL_BINDING_OWN_RADIANCE (96 + FL_LAMP_COUNT)  // for mirrordown.comp: the picture that is not mirrored
// Mirror balls (mirrors.comp): MirrorBallRow, MirrorPairRow, normals of mirrors, and what is lit: the number of beams
// of lamps, then that of lit mirrors of each pair, then for each pair the numbers of these (FL_MIRROR_...).
#define FL_BINDING_MIRROR_BALLS (97 + FL_LAMP_COUNT)
#define FL_BINDING_MIRROR_PAIRS (98 + FL_LAMP_COUNT)
#define FL_BINDING_MIRROR_NORMALS (99 + FL_LAMP_COUNT)
#define FL_BINDING_MIRROR_PICKS (100 + FL_LAMP_COUNT)
// Strips of lasers in supertiles (laserstrips.comp): LaserStripRow, and LaserListRow, one a supertile.
#define FL_BINDING_LASER_STRIPS (101 + FL_LAMP_COUNT)
#define FL_BINDING_LASER_LISTS (102 + FL_LAMP_COUNT)
// Textures of objects of the scene (lib/texture.glsl): TextureRow, one a textured material; the texels of their images;
// places in them, one a vertex of the objects.
#define FL_BINDING_TEXTURES (103 + FL_LAMP_COUNT)
#define FL_BINDING_TEXTURE_TEXELS (104 + FL_LAMP_COUNT)
#define FL_BINDING_OBJECT_UVS (105 + FL_LAMP_COUNT)
// Panes in one plane (shaftlines.comp): PaneGroupRow; GroupPaneRow; words of their grids; PaneFansRow; the sums
// along the lines of fans, three pairs of floats an entry.
#define FL_BINDING_PANE_GROUPS (106 + FL_LAMP_COUNT)
#define FL_BINDING_GROUP_PANES (107 + FL_LAMP_COUNT)
#define FL_BINDING_PANE_GRIDS (108 + FL_LAMP_COUNT)
#define FL_BINDING_PANE_FANS (109 + FL_LAMP_COUNT)
#define FL_BINDING_PANE_LINES (110 + FL_LAMP_COUNT)
// Light of displays by records (displaynodes.comp): DisplayTileRow, one a tile; DisplayListsHead with DisplayRecordRow.
#define FL_BINDING_DISPLAY_TILES (111 + FL_LAMP_COUNT)
#define FL_BINDING_DISPLAY_RECORDS (112 + FL_LAMP_COUNT)
#define FL_BINDING_SHEENS (113 + FL_LAMP_COUNT)  // SheenRow; the first one is that of matt surfaces
#define FL_BINDING_DRAW_BLOCKS (114 + FL_LAMP_COUNT)  // DrawBlocksHead, then DrawBlockRow, FL_BLOCKS_MAX
#define FL_BINDING_BODY_SPACES (115 + FL_LAMP_COUNT)  // BodySpaceRow, one a body
#define FL_BINDING_BODY_ROUNDS (116 + FL_LAMP_COUNT)  // BodyRoundsHead, then BodyRoundRow
// Depth of field: the blurred picture; the widest blur of each FL_TILE_PX x FL_TILE_PX pixels, in pixels, as floats.
#define FL_BINDING_BLURRED (117 + FL_LAMP_COUNT)
#define FL_BINDING_BLURS (118 + FL_LAMP_COUNT)
#define FL_BINDING_EDGE_PARTS (119 + FL_LAMP_COUNT)  // EdgePartRow, one a row of tiles
// Reflection probes (lib/probes.glsl): ProbeRow, one a probe; FL_PROBE_SHARES x FL_PROBE_SHARES shares of light, then
// the texels of each probe, level after level (shared/probe.h).
#define FL_BINDING_PROBES (120 + FL_LAMP_COUNT)
#define FL_BINDING_PROBE_LIGHT (121 + FL_LAMP_COUNT)
#define FL_BINDING_OBJECT_SHELLS (122 + FL_LAMP_COUNT)  // ObjectShellsRow, one for each FL_OBJECT_TRIANGLES triangles
// Blurred gobos of beams with a focus (lib/gobo_blurs.glsl).
#define FL_BINDING_GOBO_BLURS (123 + FL_LAMP_COUNT)
#define FL_BINDING_GOBO_BLURS_OUT (124 + FL_LAMP_COUNT)
#define FL_BINDING_PIXEL_BOXES (125 + FL_LAMP_COUNT)  // numbers of stage boxes, one word a pixel; FL_NONE: none
#define FL_BINDING_DISPLAY_PIXELS (126 + FL_LAMP_COUNT)
#define FL_BINDING_COUNT (127 + FL_LAMP_COUNT)

// Specialisation constants: what the rig needs, and the settings of the frame.
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
#define FL_SPEC_SPIN 10
#define FL_SPEC_COLOR 11
#define FL_SPEC_OPTICS 12
#define FL_SPEC_BLADES 13
#define FL_SPEC_DOWSER 14
#define FL_SPEC_FOCUS 15
#define FL_SPEC_ANIMATION 16
#define FL_SPEC_FLEX 17
#define FL_SPEC_SMOOTH 18
#define FL_SPEC_MEASURED 19
#define FL_SPEC_RECTANGLE 20
#define FL_SPEC_STACKED 21
#define FL_SPEC_SHAKE 22
#define FL_SPEC_PULSES 23
#define FL_SPEC_MACRO 24
#define FL_SPEC_DECODED_COUNT 25
#define FL_SPEC_IRIS 26
#define FL_SPEC_WIDE 27
// Whether the rig has a kind of lamp, by its number in FL_LAMPS.
#define FL_SPEC_LAMP(number) (27 + number)
#define FL_SPEC_TILES (28 + FL_LAMP_COUNT)
#define FL_SPEC_TEAM (29 + FL_LAMP_COUNT)
#define FL_SPEC_VIEW (30 + FL_LAMP_COUNT)
#define FL_SPEC_GROUP (31 + FL_LAMP_COUNT)  // threads of a workgroup of the surface pass
#define FL_SPEC_KEYS (32 + FL_LAMP_COUNT)  // the second round over triangles
#define FL_SPEC_GOBO_METHOD (33 + FL_LAMP_COUNT)
#define FL_SPEC_EDGE_SAMPLES (34 + FL_LAMP_COUNT)
#define FL_SPEC_EDGES (35 + FL_LAMP_COUNT)  // edges of solid things are smooth
#define FL_SPEC_SHADOWS (36 + FL_LAMP_COUNT)
#define FL_SPEC_WRITE (37 + FL_LAMP_COUNT)  // shadows are written, not counted
#define FL_SPEC_GLARE_FIRST (38 + FL_LAMP_COUNT)  // the first level of the glare's pyramid
#define FL_SPEC_TONE (39 + FL_LAMP_COUNT)   // FL_TONE_...
#define FL_SPEC_WHITE (40 + FL_LAMP_COUNT)  // white is balanced
#define FL_SPEC_METER (41 + FL_LAMP_COUNT)  // the exposure is that of the meter
#define FL_SPEC_BOUNCE (42 + FL_LAMP_COUNT)  // surfaces get the light that others reflect
#define FL_SPEC_LENSES (43 + FL_LAMP_COUNT)  // small lenses are splats
#define FL_SPEC_HAZE (44 + FL_LAMP_COUNT)  // haze is not even: selects another shader
#define FL_SPEC_LASER (45 + FL_LAMP_COUNT)
#define FL_SPEC_AIR (46 + FL_LAMP_COUNT)  // light in the air is drawn
#define FL_SPEC_DETAIL (47 + FL_LAMP_COUNT)  // images of panes and displays as fine as pixels, not whole
#define FL_SPEC_MAP_PX (48 + FL_LAMP_COUNT)  // texels a side of shadow maps; 0: shadows are cut exactly
#define FL_SPEC_GLOSS (49 + FL_LAMP_COUNT)  // there are floors that mirror
#define FL_SPEC_PENUMBRA (50 + FL_LAMP_COUNT)  // points of a lens from which shadows are cast: 1, 4 or 7
#define FL_SPEC_SHEEN (51 + FL_LAMP_COUNT)  // there are surfaces with sheen
#define FL_SPEC_PLUMES (52 + FL_LAMP_COUNT)  // machines have plumes: selects another shader
#define FL_SPEC_PROBES (53 + FL_LAMP_COUNT)  // probes show what surfaces with sheen mirror
#define FL_SPEC_JOINED (54 + FL_LAMP_COUNT)  // a pixel's depth and key are one word of 64 bits
#define FL_SPEC_PLAIN_BEAMS (55 + FL_LAMP_COUNT)  // plain beams have a shader of their own in the air
#define FL_SPEC_ALIKE_READS (56 + FL_LAMP_COUNT)  // how a device reads (lib/alike.glsl): of all compute passes
#define FL_SPEC_COUNT (57 + FL_LAMP_COUNT)

#define FL_METHOD_GAUSS 0
#define FL_METHOD_MARCH 1

#define FL_GOBO_MIDPOINTS 0
#define FL_GOBO_TAPS 1
#define FL_GOBO_TABLES 2

// What a frame shows (FrameView).
#define FL_VIEW_PICTURE 0
#define FL_VIEW_CLASSES 1
#define FL_VIEW_LUX 2
#define FL_VIEW_STEPS 3

// Tone curves (ToneCurve, shared/tone.h).
#define FL_TONE_AGX 0
#define FL_TONE_FILMIC 1
#define FL_TONE_REINHARD 2
#define FL_TONE_LINEAR 3

#define FL_GROUP_HEADS 64   // heads a workgroup
#define FL_TILE_PX 16       // a workgroup shades one tile
#define FL_FINE_PX 32       // a workgroup of the fine pass takes beams together for so many pixels
#define FL_SUPERTILE_PX 64  // beams are listed per supertile, one bit a live beam
#define FL_GROUP_MASK 64    // beams a workgroup of the tile pass tests
#define FL_BLOCK_SUPERTILES 4  // a workgroup of the tile pass tests them against so many supertiles a side
#define FL_GROUP_RECORDS 128  // threads of a workgroup that draws records
#define FL_GROUP_TILE 256   // threads of a workgroup of the coarse and the fine pass
#define FL_SURFACE_PX 32    // a workgroup of the surface pass has so many pixels a side
#define FL_FEW_BEAMS 12      // in a supertile: so few are computed pixel by pixel, which takes less time
// Tables of a gobo. Whole chords: straight lines of FL_GOBO_CHORDS offsets from the middle and FL_GOBO_ANGLES angles
// over half a turn. Sums along lines: FL_GOBO_LINES offsets and FL_GOBO_DIRECTIONS directions, at FL_GOBO_NODES places.
#define FL_GOBO_CHORDS 1024
#define FL_GOBO_ANGLES 256
#define FL_GOBO_CHORD_SAMPLES 256  // of the image along a chord through the middle
#define FL_GOBO_LINES 512
#define FL_GOBO_DIRECTIONS 64
#define FL_GOBO_NODES 65
#define FL_GOBO_LINE_SAMPLES 512
// Blurred gobos: FL_GOBO_BLUR_LEVELS squares of an octave of radii each, from 1 / FL_GOBO_BLUR_LEAST of the image's.
// The first two have FL_GOBO_BLUR_PX texels a side, each next one half as many. All lie in one image,
// FL_GOBO_BLUR_COLUMNS wide.
#define FL_GOBO_BLUR_PX 512
#define FL_GOBO_BLUR_COLUMNS 1280
#define FL_GOBO_BLUR_LEAST 64
#define FL_GOBO_BLUR_LEVELS 8
#define FL_GOBO_PROFILES 8  // numbers of profiles (lib/profile_index.glsl), and one that none has
#define FL_GROUP_GOBOS 64   // lines, and beams, a workgroup
#define FL_GROUP_GLARE 8     // threads a side of a workgroup of the glare pass, up the pyramid
#define FL_GROUP_GLARE_DOWN 16  // and down
#define FL_GLARE_MARGIN 2    // pixels beyond the picture that each level has, on each side
#define FL_GLARE_WEIGHTS 25  // 1 + levels that have a weight; the first row of the image has them, behind what stays
#define FL_GROUP_LASERS 64  // rows a workgroup
#define FL_GROUP_MIRRORS 64  // mirrors that a workgroup tests at once
#define FL_SHAFT_ROWS 8     // pixels down of a workgroup of the pass of shafts, FL_TILE_PX across
#define FL_GROUP_SHAFTS 64  // words of occluders a workgroup
#define FL_PANES_MAX 256  // of a rig; a multiple of 32
#define FL_GROUP_PANE_FANS 64       // groups of panes a workgroup
#define FL_GROUP_PANE_LINES 128     // threads that a line has
#define FL_PANE_STATIONS_MAX 512    // places on a line that have sums
#define FL_PANE_GRID_COUNT_BITS 9   // of a word of a grid: panes of its cell; above them where its list begins
#define FL_SPLAT_PX 32  // a workgroup that adds the splats of lenses has so many pixels a side
// The meter of the automatic exposure counts pixels by their luminance: FL_METER_STEPS bins an octave, from
// 2^FL_METER_LOW cd/m^2.
#define FL_METER_STEPS_LOG2 5
#define FL_METER_LOW -20
#define FL_METER_BINS 1536
#define FL_GROUP_METER 16  // threads a side of a workgroup that counts, each with 4 x 4 pixels
#define FL_GROUP_EXPOSE 256
#define FL_RECHECK_X 16     // cells of the picture, of each of which one pixel is computed once more
#define FL_RECHECK_Y 8
#define FL_GROUP_RECHECK 64  // threads of a cell
// Gates: what stands in a beam, if that is more than one still image. Their states are told apart by steps of a turn
// and of the beam's radius: half a step moves the rim by 0.2 texels of an image, and an offset by 0.13.
#define FL_GATE_TURN_STEPS 8192
#define FL_GATE_OFFSET_STEPS 2048
#define FL_GATE_PX 1024     // texels a side of the image of a gate
#define FL_GATES_MAX 64     // states that may have images
#define FL_GATE_WORDS 6     // of the number of a state
#define FL_GROUP_GATES 256  // threads of the workgroup that numbers them
#define FL_GROUP_GATE_PX 16 // threads a side of a workgroup that draws a gate
#define FL_GROUP_SHADOWS 64 // threads of a workgroup that finds the shadows in a beam
#define FL_GROUP_PLACES 256 // threads of the workgroup that gives them their places
#define FL_BEAM_SHADOWS_MAX 4096  // in one beam
#define FL_MAP_CELLS 8      // a side of a shadow map: cells with the nearest and the farthest of their texels
#define FL_MAP_BYTES_MAX 536870912  // of all shadow maps
#define FL_GROUP_BEAM_MAPS 256   // threads of a workgroup that draws a shadow map
#define FL_SHADOWS_X 32768  // workgroups side by side, one a beam
#define FL_GROUP_HAZE 64    // rays a workgroup
// The table of haze that is not even: rays across and down, and values of each.
#define FL_HAZE_X 160
#define FL_HAZE_Y 90
#define FL_HAZE_SLICES 160
#define FL_PUFFS_MAX 160   // of plumes of haze: 16 plumes of 10
#define FL_BLUR_PX_MAX 32  // radius of what a point becomes by depth of field
#define FL_TILE_LIGHT 48    // 4 x 4 coefficients of three channels
// Nodes of a rectangle lie on a square that is this much larger, so that their hull holds every pixel's centre: the
// outermost node is at cos(pi / 8) = 0.924 of the square, the outermost centre at 63 / 64 of the rectangle.
#define FL_HULL 1.07

// Where nothing ends a ray: farther than anything in a rig, m.
#define FL_FAR_M 1e30
#define FL_NONE 0xffffffffu
// Thinner beams are drawn with this radius, in pixels (lib/thin.glsl).
#define FL_THIN_RADIUS_PX 1.74
// On a surface that is seen edge on, at most so many times as wide.
#define FL_THIN_ON_SURFACE 8.6

// Camera, medium and sizes of one frame; 160 bytes, uploaded each frame.
struct FrameParams {
  vec4 right;     // xyz: unit right x tan(fov / 2) x width / height; w: near plane, m
  vec4 up;        // xyz: unit up x tan(fov / 2); w: range of light, m
  vec4 forward;   // xyz: unit; w: sigma_s, 1/m
  vec4 position;  // xyz: camera, m; w: sigma_t, 1/m
  uint width;
  uint height;
  uint head_count;
  uint box_count;
  uint supertiles_x;
  uint mask_words;   // 32-bit words a supertile
  float anisotropy;  // g of Henyey-Greenstein
  float ambient_lx;
  float exposure;    // from cd/m^2 to the tone map's 1.0
  float dark_lm;     // a beam with no more flux than this is not drawn
  float thin;        // radius of the thinnest beam as it is drawn, over its depth (lib/thin.glsl); 0: as thin as it is
  uint supersample;  // pixels of the radiance a side of a pixel of the screen
  float work_lx;     // work light: on faces by their direction
  float tile_error;  // error that the beams of a supertile may have together, over their light (tile_class.glsl)
  uint tile_beams;   // fewer live beams than that are computed pixel by pixel, without the passes of tiles
  float body_error_px;  // error that a level of a body may have in the picture
  uint computed_triangles;  // 1: compute shaders draw bodies and objects; 0: the rasteriser does
  uint rims_max;  // rows of the RimRow table that a supertile has
  uint cuts_max;  // of the CutRow table
  uint object_level;  // row of the objects in the table of levels; FL_NONE: there are none
  float mirror_m;  // of a mirrored camera: the height of the mirror above it, m, where its rays begin; else 0
  uint probe_count;  // rows of the ProbeRow table
  uint pad_2;
  uint pad_3;
};

// One lit beam, 160 bytes: a head's, or one facet's of its prism. Light space is camera-relative: eye = camera in it.
// That of a rectangle is stretched along y until it is a square, which lies in the round beam of R0 and k (beam.h).
struct BeamRow {
  vec4 x_axis;  // xyz in stage space; w: lens radius R0, m
  vec4 y_axis;  // w: spread k
  vec4 axis;    // w: range, m
  vec4 eye;     // xyz: camera in light space, m; w: profile m
  vec4 j0;      // rgb: J0 per channel, lm; w: share of the profile's radius that an iris hides
  uint gobo;    // 0: open
  float gobo_cos;
  float gobo_sin;
  uint head;
  uint gobo_2;  // 0: open
  float gobo_2_cos;
  float gobo_2_sin;
  float gobo_scale;  // share of the image's radius that the beam shows: the iris
  float gobo_blur;   // of the images, by frost: radius in beam radii
  uint flags;        // FL_BEAM_...
  uint next_1;       // images of the slots beside, where a wheel stands between two
  uint next_2;
  float offset_1;  // of the gobo's middle from the beam's, in beam radii; 0: it stands right
  float offset_2;
  float focus;     // 1/m; below 0: sharp everywhere
  uint animation;  // image; 0: none
  float animation_cos;
  float animation_sin;
  uint measured;  // as TypeRow::measured
  float squeeze;  // 0: round; a rectangle's height over its width, squared
};

// A part of a sheet of light that a laser draws, 160 bytes. The directions of its beams are first + tau second, not
// normalised, for tau from 0 to `reach`; shared/laser.h has the rest.
struct LaserRow {
  vec4 first;    // xyz: unit; w: reach
  vec4 second;   // xyz: unit, perpendicular to first; w: reach over the angle that it stands for
  vec4 eye;      // xyz: the camera from where the light leaves, m; w: variance of the light across a beam there, m^2
  vec4 cross_1;  // xyz: first x eye, m; w: of the variance with the square of the distance
  vec4 cross_2;  // xyz: second x eye, m; w: pixels around it that it touches
  vec4 light;    // rgb: lm; w: tau at which the ends jump
  vec4 ends;     // sqrt(1 + tau^2) over the length of the beam: at 0, on both sides of the jump, at reach; 1/m
  vec4 box;      // pixels that it may touch: low, high; empty: it is dark
  uint end_fixture_1;  // of the thing at the end, on both sides of the jump; FL_NONE: of none
  uint end_fixture_2;
  float slack_m;  // that such a thing may be smaller
  uint pad;
  vec4 pad_2;
};

// The part of a square of the picture that a row of lasers touches, and polynomials of its light there
// (lib/laser_strip.glsl), 192 bytes. Pixels count from the middle of the square.
struct LaserStripRow {
  vec4 light;   // rgb: lm; w: reach of the sheet
  vec4 frame;   // xy: the middle; zw: along the beams, unit
  vec4 size;    // xy: half of it in pixels, along, and across between the edges of the sheet or around a beam; 0: it is
                // not in the square; zw: one over the change a pixel across of dot(ray, cross_1), and at the last edge
  vec4 edge_1;  // dot(xyz, (1, pixels)) is dot(ray, cross_1); w: pixels beside the edges that have light
  vec4 edge_2;  // likewise of cross_2
  vec4 smooth_light[3];  // coefficients of LaserAir.smooth_light: along, for each degree across
  vec4 scale[3];         // of LaserAir.scale
  vec4 pad;
};
#define FL_LASER_STRIPS 64  // a supertile of the picture, in the mean

// The rows of lasers of a supertile.
struct LaserListRow {
  uint rows;    // that may touch it
  uint first;   // strip
  uint strips;  // how many of the rows are strips
  uint pad;
};

// A pane of glass that the sun shines through, 144 bytes. Its light goes through the places center + u T + v B + c sun
// with u and v between -1 and 1 and c between 0 and the range of light; T and B go to the middles of its right and its
// upper edge. A vector p has the u, v and c of its dot products with `across`, `upward` and `along`.
struct PaneRow {
  vec4 center;  // m
  vec4 across;  // 1/m
  vec4 upward;
  vec4 along;   // without a unit
  vec4 sun;     // xyz: unit, in which light travels
  vec4 light;   // rgb: lx across the sun's light behind clear glass; 0 where the sun lies in the plane of the pane
  vec4 glass;   // rgb: cd/m^2 of clear glass against the sky
  uint texel_first;
  uint width;   // of its image, texels
  uint height;
  uint levels;  // of its image: each half as wide and high as the one before, rounded up
  uint pad_0;
  uint pad_1;
  uint pad_2;
  uint pad_3;
};

// Panes in one plane, and the rectangle around them, which has the places of PaneRow as if it were a pane; 144 bytes.
struct PaneGroupRow {
  vec4 center;  // m; w: half its diagonal, m
  vec4 across;  // 1/m; w: half its width, m
  vec4 upward;  // w: half its height, m
  vec4 along;   // without a unit; w: 1, or 0 where the sun lies in the plane
  vec4 sun;     // xyz: unit, in which light travels
  float texel_u;  // the smallest texel of the panes, in u and v
  float texel_v;
  uint pane_first;  // rows of GroupPaneRow
  uint pane_count;
  uint grid_first;  // word; a word a cell, from the lower left, and behind them lists of rows of GroupPaneRow
  uint grid_x;      // cells
  uint grid_y;
  uint lines;       // that the table has for the group
  uint line_first;  // entry
  uint stations;    // entries of a line
  uint is_even;     // 1: few panes without images, which need no table
  uint pad;
  vec4 pad_2;
};
// A pane in its group, 80 bytes.
struct GroupPaneRow {
  vec4 to_u;   // u on the pane: dot(xyz, (u, v, 1) of the group)
  vec4 to_v;
  vec4 light;  // as PaneRow
  vec4 glass;
  uint texel_first;
  uint width;
  uint height;
  uint levels;
};
// Lines through the point of the plane that the sun's light through the camera crosses (shaft.h), 32 bytes.
struct PaneFanRow {
  float q_low;
  float q_step;  // from a line to the next
  float p_low;
  float p_step;  // from a station to the next
  uint first;    // line of the group
  uint lines;    // 0: no glass lies there
  float p_middle;
  uint pad;
};
// The four fans of a group, and whether its table is that of the frame before; 144 bytes.
struct PaneFansRow {
  float eye_u;  // the point
  float eye_v;
  uint detail;   // bits of what else the table depends on; 0: there is none yet
  uint is_new;   // 0: the sums stay
  PaneFanRow fans[4];
};

// A display: a rectangle of pixels that shines from one side, 144 bytes.
struct DisplayRow {
  vec4 center;  // m
  vec4 right;   // unit; w: half the width, m
  vec4 down;    // unit; w: half the height, m
  vec4 front;   // unit, to where it shines
  vec4 light;   // rgb: cd/m^2 of a pixel whose share is 1
  uint columns;
  uint rows;
  uint levels;       // of cells, down to pixels
  uint level_first;  // row of the DisplayLevelRow table
  uint axes;         // bits: a cell has two of this level, beside each other, or above each other where the bit is 1
  uint part_axes;    // the same for the FL_DISPLAY_PARTS halvings of a pixel, the smallest first
  uint slot_first;  // in the levels, of its first universe; FL_NONE: an image, or even
  uint slot_start;  // in it, of the first pixel
  uint slots;       // of a pixel
  uint offsets;     // of red, green, blue and white in them, 8 bits each from red (lowest); 255: none
  uint first_pixels;     // in the first universe
  uint universe_pixels;  // in others
  uint order;            // FL_ORDER_...
  float gamma;
  uint pixel_first;  // of all displays' pixels
  uint pad;
};
#define FL_DISPLAY_PARTS 16  // a pixel may be halved so many times where it is near
#define FL_ORDER_COLUMNS 1u
#define FL_ORDER_SERPENTINE 2u
#define FL_ORDER_FROM_RIGHT 4u
#define FL_ORDER_FROM_BOTTOM 8u
// A cell of the lowest level is a pixel: its light, share of DisplayRow::light. Those of level 1, two pixels each, are
// computed where they are read. Others have 6 words, in pairs: the mean share, then half floats of its moments: the
// mean of the share times the distance from the middle of the cell, in pixels, to the right and then down.
struct DisplayLevelRow {
  uint first;  // of all displays' stored cells; 0 below FL_DISPLAY_STORED
  uint columns;
  uint rows;
  uint pad;
};
// Cells that a workgroup computes.
struct DisplayJobRow {
  uint display;
  uint level;
  uint first;
  uint pad;
};
#define FL_DISPLAY_STORED 2  // the lowest level whose cells are stored
#define FL_GROUP_DISPLAY 64  // cells a workgroup

// Light of displays is smooth on what a square of the picture shows of one plane, and in the air before it. A record is
// that of a rectangle of pixels: values at 4 x 4 nodes. Where these do not do, it has four children of half its size.
#define FL_DISPLAY_RECORD_LEVELS 4  // squares of 64, 32, 16 and 8 pixels a side
#define FL_DISPLAY_RECORD_PLANES 4  // of a tile
#define FL_DISPLAY_RECORD_LISTS 16  // planes of a supertile
#define FL_DISPLAY_RECORDS 24       // rows a supertile of the picture, in the mean
#define FL_DISPLAY_RECORD_LEAST 24  // fewer pixels are computed one by one
#define FL_DISPLAY_RECORD_NONE 15u  // of a pixel: it shows none of the planes
// What a tile of FL_TILE_PX x FL_TILE_PX pixels shows; 352 bytes.
struct DisplayTileRow {
  vec4 planes[FL_DISPLAY_RECORD_PLANES];  // normal, and its product with places from the camera, m; 0: nothing
  uint boxes[FL_DISPLAY_RECORD_PLANES];   // of the pixels that show it: first column and row, last ones, 8 bits each;
                                          // ~0: none
  uint counts[FL_DISPLAY_RECORD_PLANES];  // of these pixels
  float albedos[FL_DISPLAY_RECORD_PLANES];
  uint records[FL_DISPLAY_RECORD_PLANES];  // that of the supertile; FL_NONE: none
  uint rest_box;  // of pixels that show other things
  uint rest_count;
  float rest_near_m;  // their depths
  float rest_far_m;
  uint rest_record;  // of the supertile: the first of three, of planes across the camera's axis; FL_NONE: none
  float rest_from_m;  // the first and the last of these, of the supertile
  float rest_to_m;
  uint pad;
  uint pixels[FL_TILE_PX * FL_TILE_PX / 8];   // planes of pixels, 4 bits each
  uint exact[FL_TILE_PX * FL_TILE_PX / 32];   // bits of pixels whose light is computed by itself
  uint solids[FL_TILE_PX * FL_TILE_PX / 32];  // of these, those with light on surfaces only
};
struct DisplayListsHead {
  uint groups[4 * FL_DISPLAY_RECORD_LEVELS];  // indirect arguments: workgroups of each level, one a record
  uint counts[FL_DISPLAY_RECORD_LEVELS];  // of wanted records; those of one level stand after those of higher ones
};
// 448 bytes.
struct DisplayRecordRow {
  vec4 plane;    // as DisplayTileRow
  vec4 box;      // its hull: low and high, pixels
  uint state;    // FL_DISPLAY_RECORD_...
  uint root;     // that of the supertile, the first of three
  float albedo;  // below 0: light on surfaces is not in it
  uint square;   // y << 16 | x of its first tile
  uint children[4];  // FL_NONE: its pixels are computed one by one
  vec4 light[24];    // at nodes: light in the air over sigma_s, and the red of that on the surface, lx; then green and
                     // blue of the latter, two nodes each
};
#define FL_DISPLAY_RECORD_GOOD 0u
#define FL_DISPLAY_RECORD_SPLIT 1u

// Flags of a BeamRow.
#define FL_BEAM_BLADES 1u  // cut by the blades of the same number
#define FL_BEAM_THIN 2u    // somewhere thinner than FrameParams::thin, and drawn wider there (lib/thin.glsl)
#define FL_BEAM_PLAIN 4u   // round, narrower than 90 degrees, with nothing in it: tiles may take it with others
#define FL_BEAM_ROWS 8u    // plain, narrow, and seen from where rows of its shadow map can be read (lib/row_eye.glsl)
#define FL_BEAM_GATE_SHIFT 16  // above it: 1 + the GoboTableRow of the image of its gate; 0: it has none

// Four edges in the gobo plane: what has n . rho <= d passes. xy: n, unit; z: d.
struct BladesRow {
  vec4 edge[4];
};

// Counts of a frame. live_count and the indirect arguments are written by the last workgroup of the gather pass.
struct CountsRow {
  uint live_count;  // beams
  uint dark_count;  // heads
  uint shadows;     // of all beams
  uint shadows_lost;  // of them, for which the ShadowRow table has no room
  uint tiles_groups[4];   // indirect arguments of the tile pass: x = live / FL_GROUP_MASK, y = blocks, z = 1
  uint beams_groups[4];   // of the beam pass: 0 x 0 x 0 when nothing is lit
  uint depths_groups[4];  // of the depths pass: one group a tile; this and the next two are 0 for few beams
  uint coarse_groups[4];  // of the coarse pass: one group a supertile
  uint fine_groups[4];    // of the fine pass: one group FL_FINE_PX x FL_FINE_PX pixels
  uint shadow_groups[4];  // of the passes that find shadows: one group a beam, FL_SHADOWS_X side by side
};

// A level rectangle that mirrors; 48 bytes.
struct GlossRow {
  vec4 center;  // xyz: m; w: share of the light that comes straight down
  vec4 half_x;  // xyz: to the middle of an edge; w: root mean square slope of the facets
  vec4 half_y;
};
#define FL_MIRROR_LEVELS 12  // of the pyramid, at most

// What a tile of FL_TILE_PX x FL_TILE_PX pixels shows; 32 bytes.
struct TileDepthRow {
  float near_m;  // along the ray; FL_FAR_M where nothing is
  float far_m;
  uint is_plane;  // one plane, or nothing
  uint beams_left;  // 1: plainbeams.comp has left beams of the tile to the beam pass
  vec4 plane;  // x: 1 / depth at the tile's middle, 1/m; y, z: its change a pixel to the right and down
};

// The smooth beams of a supertile: light over sigma_s, coefficients of T_m T_n over the hull, 3 (4 n + m) + channel.
struct CoarseRow {
  float light[FL_TILE_LIGHT];
  float tolerance;  // of one beam there, over sigma_s; 0: all beams are left to the beam pass
  uint rims;        // rows of the RimRow table that are in use
  uint cuts;
  uint pad;
};

// A beam that is smooth over a rectangle of pixels but for its rim: polynomials of x and y, from -1 to 1 over the hull,
// each 6 coefficients of 1, T_1(x), T_1(y), T_2(x), T_1(x) T_1(y), T_2(y), of rho and then of h. Light: h (1 -
// rho^2)^(p + 1/2) times the colour.
struct RimRow {
  vec4 fits[3];
  vec4 color;  // w: p
};
// A beam that something cuts over a rectangle of pixels, likewise: polynomials of rho, g_0, g_1, g_2, s_a and s_b
// (tile_node.h).
struct CutRow {
  vec4 fits[9];
  vec4 color;
};
#define FL_RECORD_BYTES_MAX 134217728  // of each of the two tables
#define FL_RIMS_MAX 1024     // of a supertile
#define FL_RIMS_SHARE 16     // a supertile has room for one of so many beams of the rig, and at least for FL_RIMS_MIN
#define FL_RIMS_MIN 64
#define FL_CUTS_MAX 512
#define FL_CUTS_SHARE 32
#define FL_CUTS_MIN 32

// The tables of a gobo image or of the image of a gate, 52 bytes. The rows of images come first. Layers: those of its
// first colour, plus 1; 0: it has none.
struct GoboTableRow {
  uint planes;                   // 1: it is grey, 3: red, green and blue have tables of their own
  uint lines;                    // layer of its sums along lines
  uint blurs;                    // layer of its blurred copies
  uint built;                    // bits: 1 << profile of its whole chords, FL_GOBO_LINES_BUILT, FL_GOBO_BLURS_BUILT
  uint gate;                     // of a gate: the first layer of its image, plus 1; 0: the row of a slot's image
  uint whole[FL_GOBO_PROFILES];  // layer of its whole chords, by profile
};
#define FL_GOBO_LINES_BUILT 0x100u
#define FL_GOBO_BLURS_BUILT 0x200u

// Tables that a frame builds: indirect arguments whose z counts the jobs that follow, `capacity` of whole chords, as
// many of lines, then FL_GATES_MAX layers of gates to be drawn, then blurred copies.
struct GoboQueue {
  uint whole_groups[4];
  uint lines_groups[4];
  uint gate_groups[4];
  uint blur_groups[4];
  uint capacity;
  uint gates;             // layers of gates
  uint gate_builds;       // that a frame may draw
  uint gate_planes;       // layers of textures that each has
  uint gate_row;          // first GoboTableRow
  uint gate_whole_layer;  // first layers in the tables
  uint gate_lines_layer;
  uint pad;
};

// A layer of the gates, or a state that the frame before had, 32 bytes.
struct GateRow {
  uint key[FL_GATE_WORDS];  // lib/gate_key.glsl; the last one is 0 where there is none
  uint last_frame;          // in which it was in use
  uint planes;
};
// What the last frame did with gates; GateRow follow: `gates` layers, then as many states of that frame.
struct GatesHead {
  uint frame;          // number
  uint states;         // different ones in it, at most `gates`
  uint builds;         // that it drew
  uint sampled_beams;  // with a gate that has no image, since there are too many states or builds
};

// A pixel of a cell, as it is shown and by the general path, cd/m^2; 48 bytes.
struct RecheckRow {
  uint x;
  uint y;
  float weight;  // pixels of the picture that it stands for; 0: the cell has none
  uint pad;
  vec4 shown;
  vec4 general;
};

// The splat of a small lens: an ellipse with a soft edge.
struct LensRow {
  vec4 place;  // xy: of its middle, pixels from the top left; z: what is nearer than this hides it, m; w: no pixel's
               // middle is farther away along x or y, pixels; below 0: there is none
  vec4 color;  // rgb: radiance of a pixel with weight 1; w: the smaller half axis, pixels
  vec4 shape;  // xx, xy, yy of the form that is 1 on the ellipse
};
struct LensesHead {
  uint groups[4];  // indirect arguments
};

// The meter of the automatic exposure.
struct MeterRow {
  float luminance;  // that the exposure is made for, cd/m^2; 0: there was no light yet
  uint pad_0;
  uint pad_1;
  uint pad_2;
  uint bins[FL_METER_BINS];  // pixels of this frame; empty between frames
};

// A solid box, 48 bytes.
struct BoxRow {
  vec4 low;     // m
  vec4 high;    // m
  vec4 albedo;  // linear; w: its SheenRow
};

// A material with sheen (sheen.h), 32 bytes.
struct SheenRow {
  vec4 color;  // rgb: of a fixture's body, what it reflects as a metal; other surfaces have their albedo
  float roughness;
  float metal;
  uint pad_0;
  uint pad_1;
};
#define FL_SHEENS_MAX 64  // what the visibility buffer can number; the first one is matt

// What hides light: a parallelepiped on the stage, 64 bytes. Those that do not move come first, then FL_BODY_BOXES of
// each body; bodies near each other have near places, so that groups of rows are small.
struct OccluderRow {
  float center_x;  // m
  float center_y;
  float center_z;
  uint fixture;      // whose own beams it does not hide; FL_NONE: of none
  vec4 half_edge_0;  // from the centre to the middles of faces, m; w: radius of the sphere around it, below 0: nothing
  vec4 half_edge_1;  // w: the thing itself may be this much smaller on each side, m
  vec4 half_edge_2;
};
#define FL_BODY_BOXES 4
// What bounds the vertices of a mesh of bodies behind so many joints, in their space: FL_BODY_BOXES a mesh.
struct BodyBoxRow {
  vec4 center;  // m; w: below 0: there are none
  vec4 half_size;
};
// The shadows in a beam, a row each of ShadowRow, in the order of the occluders; with several points of a lens first
// those from its first point, then as many from the next one.
struct ShadowListRow {
  uint first;
  uint count;
};
// Beams of a word of a supertile's mask that have shadows there, but are not all in one, and where in the picks the
// places of their lists stand, in the order of the beams; FL_NONE: all their shadows count. A list is its length and
// an entry a shadow: bits of its planes that cross what the rectangle shows, and above them the number of its
// ShadowRow. Of a fine mask: beams whose shadows are left to pixels; FL_NONE: the supertile's list counts.
struct ShadowWordRow {
  uint beams;
  uint first;
};
// A ShadowPrism (shadow.h), 208 bytes. Planes: normal, offset, in the beam's light space.
struct ShadowRow {
  uint count;     // of planes; << 8: of them, those at the end that are fronts; FL_SHADOW_HIDDEN; point of the lens
  uint occluder;  // its row
  uint fixture;   // as OccluderRow
  float slack_m;  // likewise
  vec4 planes[12];  // filled up to a multiple of 4
};
#define FL_SHADOW_HIDDEN 65536u        // adds nothing to another shadow of the beam, in the air
#define FL_SHADOW_POINT_SHIFT 20       // of ShadowRow::count
#define FL_SHADOW_PLANE_BITS 12        // of an entry of a list
#define FL_SHADOW_ROWS_MAX 1048575     // what the other bits can number
// Words that all lists together have, for each supertile: so many a beam of the rig, and at least FL_PICKS_MIN. All
// together at most FL_PICKS_BYTES_MAX, or what a table of the device may have.
#define FL_PICKS_A_BEAM 8
#define FL_PICKS_BYTES_MAX 536870912
#define FL_PICKS_MIN 256

// A solid that light ends at and may be reflected by, 96 bytes. Inside it all dual[i].xyz . place + dual[i].w are
// between -1 and 1. Faces: 2 axis, and 2 axis + 1 for the side at 1.
struct BounceSolidRow {
  vec4 dual[3];
  uint first[6];  // patch of each face; FL_NONE: what reaches the face is lost, and its count is
                  // FL_BOUNCE_ALBEDO(red, green, blue), 0 to 1023 each, of what probes see of it
  uint count[6];  // patches along the axis after that of the face, and << 16 along the next; rows of the former
};
#define FL_BOUNCE_ALBEDO(red, green, blue) ((red) << 20 | (green) << 10 | (blue))
// A rectangle of a face, 80 bytes. Its cells are 4 x 4.
struct BouncePatchRow {
  vec4 center;  // m; w: area that no other solid covers, m^2
  vec4 half_u;  // from the centre to the middle of an edge, m; w: the length of the longer edge, m
  vec4 half_v;
  vec4 normal;
  float red;  // albedo
  float green;
  float blue;
  uint exposed;  // bits of cells that no other solid covers, 1 << (4 v + u)
};
#define FL_BOUNCE_CELLS 4
#define FL_BOUNCE_PATCHES_MAX 512
#define FL_BOUNCE_PROBES_MAX 512
#define FL_BOUNCE_RAYS 64       // of a beam; threads of a workgroup
#define FL_BOUNCE_FLUX 1048576.0
#define FL_BOUNCE_LISTS 4       // of patches in the light: what others reflect to it, then what it emits (bouncelight)
#define FL_GROUP_FORMS 64       // receivers of a workgroup that computes what reaches them
#define FL_GROUP_BOUNCE 8       // threads that have four receivers each, in a workgroup
#define FL_BOUNCE_PARTS 8       // of which each has so many: they share the sums
// Steps of bounceforms.comp and bouncelight.comp.
#define FL_BOUNCE_DIRECT 0u
#define FL_BOUNCE_TO_PATCHES 1u
#define FL_BOUNCE_TO_PROBES 2u
// Probes: a regular grid of places with the illuminance of planes towards +x, -x, +y, -y, +z, -z.
struct BounceGrid {
  vec4 low;  // of the first probe, m; w: from one to the next, m
  uint probes_x;
  uint probes_y;
  uint probes_z;
  uint patches;
};
struct BounceProbeRow {
  float clear_m[6];  // to the next face that has patches, towards +x, -x and so on
  uint usable;       // 0: inside a solid
  uint pad;
};

// A reflection probe: the box of the room that it shows, 48 bytes. Inside the box it counts whole; beside it less,
// until nothing is left blend_m away.
struct ProbeRow {
  vec4 low;     // m; w: blend_m, above 0
  vec4 high;    // m
  vec4 center;  // from where its texels are seen, m
};
#define FL_PROBES_MAX 16
#define FL_PROBE_SIDE_LOG2 6  // texels a side of level 0
#define FL_PROBE_TEXELS 4096  // of level 0: FL_PROBE_SIDE_LOG2 twice
#define FL_PROBE_LEVELS 6     // sides 64, 32, 16, 8, 8, 8
#define FL_PROBE_ALL 5568     // texels of all levels
#define FL_PROBE_SHARES 16    // a side of the table of shares
#define FL_GROUP_PROBES 64    // texels a workgroup

// A mesh of bodies: one a fixture type and head; 80 bytes. Its bodies are neighbours in the table of slots.
struct BodyMeshRow {
  vec4 sphere[4];    // round the vertices behind so many joints, in their space: centre, radius, m; radius < 0: none
  uint slot_first;   // index into the BodySlotRow table
  uint slot_count;
  uint level_first;  // index into the BodyLevelRow table; level 0 is the whole mesh
  uint level_count;
};
struct BodyLevelRow {
  uint index_first;
  uint index_count;
  uint vertex_first;
  float error_m;
  uint triangle_first;  // of objects: the number of the first triangle, after those of bodies
  uint outward_count;   // its first triangles, of closed shells, counter-clockwise seen from outside ...
  uint closed_count;    // ... and the next ones up to here, clockwise; those after them may be seen from both sides
};
struct TreeRow {  // as fixtures::TreeNode
  float low_x;
  float low_y;
  float low_z;
  uint skip;
  float high_x;
  float high_y;
  float high_z;
  uint leaf;
};
#define FL_TREE_COUNT_BITS 3
#define FL_EDGE_SAMPLES_MAX 16  // that a pixel may have of what it shows
// Of a tile: a word for each row of its pixels (in the low half a bit for each with an edge, in the high half how many
// of them are in rows before it), then the number of its first pixel with samples, among those of its part.
#define FL_EDGE_WORDS (FL_TILE_PX + 1)
// Row k is about two things: row k of the tiles, and part k of the rows, which are drawn one part after the other where
// not all pixels with edges have room for their samples at once.
struct EdgePartRow {
  uint count;      // pixels with an edge in row k of the tiles
  uint next;       // the number of the next of them, among those of its part
  int first;       // rows of pixels of part k: whole tiles
  int end;
  uint tiles_x;    // workgroups: of the part's tiles ...
  uint tiles_y;
  uint tiles_z;
  uint bodies_x;   // ... of bodies; those of a part that is not needed are 0 ...
  uint bodies_y;
  uint bodies_z;
  uint objects_x;  // ... of objects ...
  uint objects_y;
  uint objects_z;
  uint blocks_x;   // ... and of blocks of large triangles, as in DrawBlocksHead
  uint blocks_y;
  uint blocks_z;
  uint blocks_asked;
};
#define FL_GROUP_EDGES 128      // threads of a workgroup that has a tile
#define FL_GROUP_PARTS 256      // and of the one that divides rows into parts
#define FL_EDGE_PIXELS 2097152  // pixels with an edge that have room for samples at a time
#define FL_EDGE_SLOT_BITS 26    // of their numbers; the other bits are for one of FL_GROUP_TRIANGLES triangles
struct BodyVertexRow {  // as fixtures::BodyVertex
  float x;
  float y;
  float z;
  float normal_x;
  float normal_y;
  float normal_z;
  uint part;  // FL_PART_...
};
// A body in the rig. The triangles of all bodies are numbered from 0, those of whole meshes in the order of the slots:
// triangle t of any level of this body is triangle_first + t.
struct BodySlotRow {
  uint head;
  uint mesh;
  uint triangle_first;
  uint occluder;  // FL_BODY_BOXES rows from FL_BODY_BOXES times this on, of those that move, hide light in its place
};
// What is drawn of a body: the index of its level; or nothing.
#define FL_CHOICE_WIDE 0x80000000u  // it may have triangles that one thread should not draw alone
#define FL_CHOICE_NONE 0xffffffffu
#define FL_CHOICE_LEVEL 0x7fffffffu
#define FL_BODY_LEVELS 8     // levels of a mesh at most
#define FL_GROUP_LIST 256    // threads of a workgroup that lists the bodies of a mesh
#define FL_GROUP_TRIANGLES 64  // triangles of a body that a workgroup draws, one a thread
#define FL_OBJECT_TRIANGLES 32  // triangles of objects that a workgroup draws
#define FL_GROUP_OBJECTS 128    // and its threads
#define FL_WIDE_BODY_PX 16       // a body with this diameter has FL_CHOICE_WIDE
#define FL_SLOTS_X 32768  // workgroups side by side that draw objects
// Where a body is in the picture. For each number of joints, rows that take a place behind them to (x times w, y times
// w, w); x and y in pixels from the picture's middle. Then the rows of pixels that it may cover, and two bits for each
// number of joints, FL_AWAY_...: which triangles of closed shells face away there, 0 if the camera may be within them.
#define FL_AWAY_POSITIVE 1u  // outward ones with a positive area in the picture
#define FL_AWAY_NEGATIVE 2u
struct BodySpaceRow {
  vec4 to_picture[12];
  float first_px;
  float last_px;
  uint away;
  uint pad;
};
// The box in stage space, m, round all closed shells that have one of a workgroup's triangles of objects.
struct ObjectShellsRow {
  vec4 low;
  vec4 high;
};
// The workgroups that draw bodies: the commands of an indirect dispatch, and how many there are, FL_ROUNDS_X side by
// side.
#define FL_ROUNDS_X 1024
struct BodyRoundsHead {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint count;
};
struct BodyRoundRow {
  uint slot;
  uint triangle;  // the first that it draws
};
// Parts of large triangles, each drawn by a workgroup: the commands of an indirect dispatch, and how many parts have
// been asked for. Where edges are drawn, EdgePartRow has these instead. More than FL_BLOCKS_MAX are drawn by the
// workgroups that find them.
#define FL_BLOCK_PX 128
#define FL_BLOCKS_MAX 65535
struct DrawBlocksHead {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint asked;
};
struct DrawBlockRow {
  uint slot;  // FL_NONE: of an object
  uint triangle;
  uint x;  // the block, from the picture's corner
  uint y;
};
// A body with a diameter below this share of FrameParams::body_error_px is left out.
#define FL_BODY_LEAST 0.125

// The visibility buffer of fixture bodies, two words a pixel: packed normal; 0 for nothing, else 1 + (head << 3 |
// part). `part`: how many joints of the head's chain move it, with FL_PART_LENS for a lens.
#define FL_PART_DEPTH 3
#define FL_PART_LENS 4
// And its SheenRow, of vertices above FL_PART_SHEEN_SHIFT; between vertices and fragments this bit and the number above
// FL_BODY_SHEEN_SHIFT; in the visibility buffer the bit alone. Where it or FL_OBJECT_TEXTURED is set in a rig with
// sheen, the packed normal has the number in the last bits of its two halves (lib/normal.glsl).
#define FL_PART_SHEEN_SHIFT 8
#define FL_BODY_SHEEN 0x40000000u
#define FL_BODY_SHEEN_SHIFT 24
#define FL_HEADS_SHEEN_MAX 1048576  // heads of a rig whose bodies may have sheen
// Of an object of the scene: this bit, and its albedo with 10 bits each from blue (lowest) to red.
#define FL_OBJECT 0x80000000u
// And this bit where it has a texture or sheen: then a vertex has the number of its TextureRow in place of the albedo.
#define FL_OBJECT_TEXTURED 0x40000000u
struct TextureRow {
  vec4 albedo;  // times that of the image; w: its SheenRow
  uint texel_first;
  uint width;  // of the largest level; 0: it has no image
  uint height;
  uint modes;  // levels; << FL_TEXTURE_WRAP_...: 0 repeats, 1 mirrors, 2 is clamped
};
#define FL_TEXTURE_WRAP_U 8
#define FL_TEXTURE_WRAP_V 10
