// What the rivals of the report add to render/shaders/shared/frame_io.h: bindings, constants and rows of their own.
// Included by GLSL and, inside a namespace with GLM aliases, by C++ (render/rivals/rival_pass.h). No include guard.

#define FL_BINDING_BOUNDS (FL_BINDING_COUNT + 0)    // BoundsRow
#define FL_BINDING_FROXELS (FL_BINDING_COUNT + 1)   // vec4, by x, y and depth
#define FL_BINDING_CLUSTERS (FL_BINDING_COUNT + 2)  // bits of lights: axis, slab, word
#define FL_BINDING_BLENDED (FL_BINDING_COUNT + 3)   // what a rasteriser has summed up
#define FL_BINDING_SHADOW_MAPS (FL_BINDING_COUNT + 4)  // m along the axis: beam, row, texel

#define FL_SPEC_WHOLE_RAY (FL_SPEC_COUNT + 0)   // samples lie on the whole ray, not in the beam alone
#define FL_SPEC_JITTER (FL_SPEC_COUNT + 1)      // a random place in each stratum, else its middle
#define FL_SPEC_FROXELS_X (FL_SPEC_COUNT + 2)
#define FL_SPEC_FROXELS_Y (FL_SPEC_COUNT + 3)
#define FL_SPEC_FROXELS_Z (FL_SPEC_COUNT + 4)
#define FL_SPEC_FROXEL_SAMPLES (FL_SPEC_COUNT + 5)  // of a froxel; one lies in its middle
#define FL_SPEC_CLUSTER_LIGHTS (FL_SPEC_COUNT + 6)  // only so many lights; 0: all
#define FL_SPEC_CLUSTER_EDGES (FL_SPEC_COUNT + 7)   // a slab has a light if one of its two faces cuts it
#define FL_SPEC_CLUSTER_LAW (FL_SPEC_COUNT + 8)     // its own law of light, in half floats
#define FL_SPEC_MAP_TEXELS (FL_SPEC_COUNT + 9)      // a side of a beam's shadow map

// The box that holds all live beams, from the camera, m; and their depths in the picture.
struct BoundsRow {
  vec4 low;   // w: least depth, at least FL_LEAST_DEPTH_M
  vec4 high;  // w: largest depth
};
#define FL_LEAST_DEPTH_M 0.5
#define FL_GROUP_BOUNDS 256

#define FL_GROUP_FROXELS 8   // froxels a side of a workgroup
#define FL_CONE_SIDES 32     // of the polygon that stands for a cone
#define FL_CLUSTER_SLABS 1024
#define FL_CLUSTER_REACH_M 100.0  // slabs divide a cube that reaches so far from the camera on each side
#define FL_GROUP_CLUSTERS 64      // slabs of a workgroup
#define FL_GROUP_SURFACE 8        // pixels a side of a workgroup
#define FL_GROUP_MAPS 8           // texels a side of a workgroup
