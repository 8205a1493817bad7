// Light of round beams without gobo, blades, iris or measured light on surfaces, and its polynomial where such a beam
// covers a tile's plane. The nodes are 4 x 4 Chebyshev nodes of the tile, on the plane. The cut of the cone and the
// plane is convex, also in the picture, so a beam that lights the outermost nodes lights every pixel between them.
// Thin beams (lib/thin.glsl) need no care: a beam that covers 32 pixels is not thin there.
//
// After beam.h, tile_test.glsl, tile_list.glsl and surface_tile.glsl. Design and error: docs/decisions/0104.

// Largest share that a beam's own tail may have, whatever the tolerance.
const float kTailMax = 0.1;
const float kHalfHullPx = FL_HULL * 0.5 * float(FL_SURFACE_PX);
const float kNodeAt[4] = float[4](0.92387953, 0.38268343, -0.38268343, -0.92387953);  // also T_1 there
const float kNodeTwo[4] = float[4](0.70710678, -0.70710678, -0.70710678, 0.70710678);
const float kNodeThree[4] = float[4](0.38268343, -0.92387953, 0.92387953, -0.38268343);

#define FL_NODES 17u        // 4 x 4, and one in the middle
#define FL_COVERS_MAX 128u  // beams that are classified together
#define FL_FEW_COVERS 4u    // so few are computed pixel by pixel, which takes less time
const uint kSumParts = kGroup / uint(FL_TILE_LIGHT);  // threads that add one sum together

shared vec4 nodes[FL_NODES];  // places from the camera; w: 0 where the ray misses the plane
shared float node_light[FL_COVERS_MAX * FL_NODES];
shared vec4 smooth_color[FL_COVERS_MAX];  // 0 of a beam that is not smooth
shared float part_sums[kSumParts * uint(FL_TILE_LIGHT)];
shared vec2 light_means[FL_SUBGROUPS_MAX];  // of subgroups: light, and beams that give some

bool is_plain(BeamRow row) {
  bool is_shaped = (kIris && row.j0.w != 0.0) || (kMeasured && row.measured != 0u) ||
                   (kRectangle && row.squeeze != 0.0) || (kBlades && (row.flags & FL_BEAM_BLADES) != 0u);
  return !is_shaped && !has_gobo(row);
}

// Of the middle of the lens, from the camera.
vec3 lens_place(BeamRow row) {
  return -(row.eye.x * row.x_axis.xyz + row.eye.y * row.y_axis.xyz + row.eye.z * row.axis.xyz);
}

// Cosine of a plain beam's light to a surface, times the length of (rho k, 1) w, so that it is the same for all places
// of a plane. lens_m: lens_place(). along_m: dot(normal, place).
float plain_facing(BeamRow row, vec3 lens_m, vec3 normal, float along_m) {
  return row.y_axis.w * (dot(normal, lens_m) - along_m) - row.x_axis.w * dot(normal, row.axis.xyz);
}

// Illuminance over J0 of a plain beam at a place, dimmed by the haze up to it: what beam_illuminance() and
// beam_direction() give, with lengths times w. Without branches, so that the places of a thread are computed together:
// nearly all are lit.
float plain_illuminance(BeamRow row, Medium medium, vec3 place_m, float facing) {
  vec3 p = row.eye.xyz + to_light(row, place_m);
  float w = row.x_axis.w + row.y_axis.w * p.z;
  float across = dot(p.xy, p.xy);
  float square = w * w;
  float inverse = 1.0 / w;
  float slant_square = square + row.y_axis.w * row.y_axis.w * across;
  float root = inversesqrt(slant_square);
  float value = beam_profile(across * inverse * inverse, drawn_profile(row.eye.w)) * facing * root * root * root;
  if (kExtinction) value *= exp(-medium.extinction_per_m * (p.z * slant_square * root * inverse));
  bool is_lit = p.z > 0.0 && p.z <= row.axis.w && across < square && facing > 0.0;
  return is_lit ? value : 0.0;
}

// T_0 to T_3.
vec4 chebyshev(float x) { return vec4(1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x); }

// Fills `nodes`; a barrier must follow.
void place_nodes(vec4 plane, vec2 middle_px) {
  uint number = thread_number();
  if (number >= FL_NODES) return;
  vec2 at = number < 16u ? vec2(kNodeAt[number & 3u], kNodeAt[number >> 2 & 3u]) : vec2(0.0);
  vec3 ray = ray_through(middle_px + kHalfHullPx * at);
  float depth_m = plane.w / dot(plane.xyz, ray);  // NaN or infinite where there is none
  nodes[number] = depth_m > 0.0 && depth_m < FL_FAR_M ? vec4(ray * depth_m, 1.0) : vec4(0.0);
}

// facing: plain_facing() of the tile's plane.
float light_at_node(BeamRow row, uint node, Medium medium, float facing) {
  return nodes[node].w > 0.0 ? plain_illuminance(row, medium, nodes[node].xyz, facing) : 0.0;
}

// The mean light of beam `which` of node_light and the error of its polynomial, sum of c[4 n + m] T_m(x) T_n(y).
vec2 mean_and_tail(uint which) {
  float c[16];
  [[unroll]] for (int k = 0; k < 16; ++k) c[k] = 0.0;
  [[unroll]] for (int j = 0; j < 4; ++j) {
    vec4 sum = vec4(0.0);
    [[unroll]] for (int i = 0; i < 4; ++i) {
      float light = node_light[which * FL_NODES + 4u * uint(j) + uint(i)];
      sum += light * vec4(1.0, kNodeAt[i], kNodeTwo[i], kNodeThree[i]);
    }
    [[unroll]] for (int m = 0; m < 4; ++m) {
      // 1/16, times 2 for each m > 0 and n > 0.
      float scaled = sum[m] * (m > 0 ? 0.125 : 0.0625);
      c[m] += scaled;
      c[4 + m] += 2.0 * kNodeAt[j] * scaled;
      c[8 + m] += 2.0 * kNodeTwo[j] * scaled;
      c[12 + m] += 2.0 * kNodeThree[j] * scaled;
    }
  }
  // What the polynomial leaves out: its last terms, and what it misses at the middle, since the terms of a light that
  // is even about the middle are zero.
  float tail = abs(node_light[which * FL_NODES + 16u] - (c[0] - c[2] - c[8] + c[10]));
  [[unroll]] for (int k = 0; k < 4; ++k) tail += abs(c[12 + k]) + (k < 3 ? abs(c[4 * k + 3]) : 0.0);
  return vec2(c[0], tail);
}

// The error that one beam of a list may have: params.tile_error of the light of all of them, if errors are independent.
// light: of this thread's beam, in its brightest channel. All threads of the group call it together.
float surface_tolerance(float light) {
  vec2 sum = subgroupAdd(vec2(light, light > 0.0 ? 1.0 : 0.0));
  if (subgroupElect()) light_means[gl_SubgroupID] = sum;
  barrier();
  sum = vec2(0.0);
  for (uint s = 0u; s < gl_NumSubgroups; ++s) sum += light_means[s];
  return params.tile_error * sum.x * inversesqrt(max(sum.y, 1.0));
}

// Adds the light in node_light of the beams that have a smooth_color to the sum of each node and channel. sum: of
// thread k < FL_TILE_LIGHT, at node k / 3 in channel k % 3. All threads of the group call it together.
void add_nodes(uint count, inout float sum) {
  uint number = thread_number();
  // Threads have fixed beams, and parts are added in order.
  for (uint k = number; k < kSumParts * uint(FL_TILE_LIGHT); k += kGroup) {
    uint own = k % uint(FL_TILE_LIGHT);
    float total = 0.0;
    for (uint b = k / uint(FL_TILE_LIGHT); b < count; b += kSumParts) {
      total += smooth_color[b][own % 3u] * node_light[b * FL_NODES + own / 3u];
    }
    part_sums[k] = total;
  }
  barrier();
  for (uint k = number; k < uint(FL_TILE_LIGHT); k += kGroup) {
    for (uint p = 0u; p < kSumParts; ++p) sum += part_sums[p * uint(FL_TILE_LIGHT) + k];
  }
}

// Of `count` <= FL_COVERS_MAX beams that cover the plane, whose light is in node_light: this thread's own, with its
// colour. Returns whether it is smooth. sum: of thread k < FL_TILE_LIGHT, the light of the smooth ones at node k / 3 in
// channel k % 3. All threads of the group call it together.
bool add_smooth_beams(uint count, vec3 color, inout float sum) {
  uint number = thread_number();
  vec2 fit = vec2(0.0, FL_FAR_M);
  float lum = max(color.r, max(color.g, color.b));
  for (uint b = number; b < count; b += kGroup) fit = mean_and_tail(b);
  float tolerance = surface_tolerance(lum * fit.x);
  bool is_smooth = fit.y <= kTailMax * fit.x && lum * fit.y <= tolerance;
  for (uint b = number; b < count; b += kGroup) {
    smooth_color[b] = is_smooth ? vec4(color, 0.0) : vec4(0.0);
  }
  barrier();
  add_nodes(count, sum);
  return is_smooth;
}

// Light at the nodes to coefficients of T_m T_n, 3 (4 n + m) + channel, in part_sums. sum: as add_smooth_beams() leaves
// it. All threads of the group call it together.
void fit_sums(float sum) {
  uint number = thread_number();
  barrier();  // the parts have been read
  if (number < uint(FL_TILE_LIGHT)) part_sums[number] = sum;
  barrier();
  float value = 0.0;
  for (uint own = number; own < uint(FL_TILE_LIGHT); own += kGroup) {
    uint channel = own % 3u;
    uint m = own / 3u & 3u;
    uint n = own / 12u;
    for (uint k = 0u; k < 16u; ++k) {
      vec4 x = chebyshev(kNodeAt[k & 3u]);
      vec4 y = chebyshev(kNodeAt[k >> 2]);
      value += part_sums[3u * k + channel] * (x[m] * y[n]);
    }
    value *= (m > 0u ? 0.125 : 0.0625) * (n > 0u ? 2.0 : 1.0);
  }
  barrier();
  if (number < uint(FL_TILE_LIGHT)) part_sums[number] = value;
  barrier();
}
