#version 460
// Values of the records of one level: light at nodes, and at kChecks places more. Where the polynomials through the
// nodes are off there by more than half of FrameParams::tile_error, a record is split. One workgroup a record;
// kLanes threads share each place, and their sums are added in their order.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/display.h"
#include "render/shaders/lib/surface.glsl"
#define FL_CELLS_ACCESS readonly
#include "render/shaders/lib/display_cells.glsl"
#include "render/shaders/lib/display_pixels.glsl"
#include "render/shaders/lib/display_light.glsl"
#define FL_RAYS 21
#define FL_TOGETHER 12
#include "render/shaders/lib/display_rays.glsl"
#define FL_DISPLAY_TILES_ACCESS readonly
#define FL_DISPLAY_RECORDS_ACCESS
#include "render/shaders/lib/display_records.glsl"

layout(local_size_x = 128) in;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(push_constant) uniform Push { uint level; } push;

const float kPi = 3.141592653589793;
// Where errors of the polynomials are largest. Where light begins along a line, one of the corners is beyond it.
const uint kChecks = 5u;
const vec2 kCheckPlaces[5] =
    vec2[5](vec2(0.0), vec2(-0.99, -0.99), vec2(0.99, -0.99), vec2(-0.99, 0.99), vec2(0.99, 0.99));
const uint kPlaces = kNodes + kChecks;  // FL_RAYS
const uint kLanes = 6u;  // of 126 threads
const float kGrazing = 1e-4;

shared vec3 lane_air[kPlaces * kLanes];
shared vec3 lane_lx[kPlaces * kLanes];
shared float lane_face[kPlaces * kLanes];
shared vec3 node_air[kNodes];
shared vec3 node_lx[kNodes];
shared uint uneven;
shared uint child_count[4];
shared vec4 child_box[4];
shared uint child_record[4];

vec2 place_of(uint place) {
  return place < kNodes ? node_place(place) : kCheckPlaces[min(place - kNodes, kChecks - 1u)];
}
float largest(vec3 v) { return max(v.r, max(v.g, v.b)); }

bool is_off(vec2 place, RayLight light, float albedo, float lost) {
  vec4 across = weights_at(place.x);
  vec4 down = weights_at(place.y);
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  for (uint i = 0u; i < kNodes; ++i) {
    air += across[i & 3u] * down[i >> 2] * node_air[i];
    lx += across[i & 3u] * down[i >> 2] * node_lx[i];
  }
  float air_off = largest(abs(max(air, 0.0) - light.air));
  float lx_off = largest(abs(max(lx, 0.0) - light.lx));
  float tolerance = 0.5 * params.tile_error;
  if (kView == uint(FL_VIEW_LUX)) return !(lx_off <= tolerance * largest(light.lx));
  float reflects = max(albedo, 0.0) / kPi * lost;
  float scatters = params.forward.w;
  float shown = largest(scatters * light.air + reflects * light.lx) + 0.3 * lost * light.face;
  return !(scatters * air_off + reflects * lx_off <= tolerance * shown);
}

// The pixels of a record in one of its four squares: how many there are at most, and their box.
void find_child(uint record, uint child) {
  uint side = uint(FL_SUPERTILE_PX / 2) >> push.level;  // of the square
  uvec2 first = uvec2(display_records[record].square & 65535u, display_records[record].square >> 16);
  uvec2 at = uvec2(child & 1u, child >> 1);
  uint count = 0u;
  vec4 box = vec4(0.0);
  if (side < uint(FL_TILE_PX)) {
    vec2 low = vec2(first * uint(FL_TILE_PX) + at * side);
    vec4 whole = display_records[record].box;
    box = vec4(max(whole.xy, low), min(whole.zw, low + float(side)));
    vec2 size = max(box.zw - box.xy, 0.0);
    count = uint(size.x * size.y);
  } else {
    uint tiles = side / uint(FL_TILE_PX);
    uint root = display_records[record].root;
    uvec2 size = tiles_of_picture();
    uvec2 low = uvec2(~0u);
    uvec2 high = uvec2(0u);
    for (uint i = 0u; i < tiles * tiles; ++i) {
      uvec2 tile_at = first + at * tiles + uvec2(i % tiles, i / tiles);
      if (tile_at.x >= size.x || tile_at.y >= size.y) continue;
      uint tile = tile_at.y * size.x + tile_at.x;
      for (uint k = 0u; k < uint(FL_DISPLAY_RECORD_PLANES); ++k) {
        uint packed = display_tiles[tile].boxes[k];
        if (packed == ~0u || display_tiles[tile].records[k] != root) continue;
        uvec4 ends = unpacked_box(packed) + uvec4(tile_at, tile_at) * uint(FL_TILE_PX);
        low = min(low, ends.xy);
        high = max(high, ends.zw + 1u);
        count += display_tiles[tile].counts[k];
      }
      if (display_tiles[tile].rest_count > 0u && display_tiles[tile].rest_record == root) {
        uvec4 ends = unpacked_box(display_tiles[tile].rest_box) + uvec4(tile_at, tile_at) * uint(FL_TILE_PX);
        low = min(low, ends.xy);
        high = max(high, ends.zw + 1u);
        count += display_tiles[tile].rest_count;
      }
    }
    box = vec4(low, high);
  }
  child_count[child] = count;
  child_box[child] = box;
}

// By one thread.
void place_children() {
  uint wanted = 0u;
  for (uint i = 0u; i < 4u; ++i) wanted += child_count[i] >= uint(FL_DISPLAY_RECORD_LEAST) ? 1u : 0u;
  if (wanted == 0u) return;
  uint begin = first_of_level(push.level + 1u);
  uint next = atomicAdd(display_lists.counts[push.level + 1u], wanted);
  if (begin + next + wanted > uint(display_records.length())) return;
  atomicMax(display_lists.groups[4u * (push.level + 1u)], next + wanted);
  for (uint i = 0u; i < 4u; ++i) {
    if (child_count[i] >= uint(FL_DISPLAY_RECORD_LEAST)) child_record[i] = begin + next++;
  }
}

// By four threads.
void write_child(uint record, uint child) {
  uint to = child_record[child];
  display_records[record].children[child] = to;
  if (to == FL_NONE) return;
  display_records[to].plane = display_records[record].plane;
  display_records[to].box = child_box[child];
  display_records[to].root = display_records[record].root;
  display_records[to].albedo = display_records[record].albedo;
  uint tiles = (uint(FL_SUPERTILE_PX / 2) >> push.level) / uint(FL_TILE_PX);
  display_records[to].square = display_records[record].square + ((child >> 1) * tiles << 16 | (child & 1u) * tiles);
}

void main() {
  if (!has_room(push.level)) return;
  uint thread = gl_LocalInvocationIndex;
  uint record = first_of_level(push.level) + gl_WorkGroupID.x;
  uint place = thread % kPlaces;
  uint number = thread / kPlaces;
  vec4 plane = display_records[record].plane;
  vec4 box = display_records[record].box;
  bool solid = plane.xyz != vec3(0.0);
  vec2 px = 0.5 * (box.xy + box.zw) + 0.5 * (box.zw - box.xy) * place_of(place);
  vec3 ray = normalize(ray_through(px));
  float faces = solid ? dot(plane.xyz, ray) : -1.0;
  float t_m = solid ? plane.w / min(faces, -kGrazing) : kNothingM;
  if (thread == 0u) uneven = 0u;
  barrier();
  if (faces > -kGrazing || !(t_m > 0.0)) atomicOr(uneven, 1u);
  barrier();
  bool works = uneven == 0u && number < kLanes;
  if (uneven == 0u) {
    bool lit = display_records[record].albedo >= 0.0;
    vec3 normal = lit ? plane.xyz : vec3(0.0);
    RayLight light = light_along(RayPart(works, px, ray, place, t_m, normal, kAir, number, kLanes));
    if (works) {
      lane_air[thread] = light.air;
      lane_lx[thread] = light.lx;
      lane_face[thread] = light.face;
    }
  }
  barrier();
  RayLight light = RayLight(vec3(0.0), vec3(0.0), 0.0);
  bool sums = works && number == 0u;
  if (sums) {
    for (uint i = place; i < kPlaces * kLanes; i += kPlaces) {
      light.air += lane_air[i];
      light.lx += lane_lx[i];
      light.face += lane_face[i];
    }
    if (place < kNodes) {
      node_air[place] = light.air;
      node_lx[place] = light.lx;
      display_records[record].light[place] = vec4(light.air, light.lx.r);
    }
  }
  barrier();
  if (sums && place < kNodes / 2u) {
    vec2 even = node_lx[2u * place].gb;
    display_records[record].light[kNodes + place] = vec4(even, node_lx[2u * place + 1u].gb);
  }
  if (sums && place >= kNodes) {
    float lost = solid ? exp(-extinction() * t_m) : 0.0;
    if (is_off(place_of(place), light, display_records[record].albedo, lost)) atomicOr(uneven, 2u);
  }
  barrier();
  bool splits = uneven != 0u;
  if (thread == 0u) display_records[record].state = splits ? FL_DISPLAY_RECORD_SPLIT : FL_DISPLAY_RECORD_GOOD;
  if (!splits) return;
  if (thread < 4u) {
    child_record[thread] = FL_NONE;
    child_count[thread] = 0u;
    if (push.level + 1u < uint(FL_DISPLAY_RECORD_LEVELS)) find_child(record, thread);
  }
  barrier();
  if (thread == 0u && push.level + 1u < uint(FL_DISPLAY_RECORD_LEVELS)) place_children();
  barrier();
  if (thread < 4u) write_child(record, thread);
}
