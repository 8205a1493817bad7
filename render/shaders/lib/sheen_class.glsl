// Sheen of the plane that a tile shows, as polynomials: of beams that are smooth over it, as surface_class.glsl has
// them for illuminance. What pixels of one material reflect is straight P + Q + diffuse rest R, with three sums over
// beams: P and Q of the light that facets mirror, without and with Schlick's share, and R of what is left to the
// diffuse part. Each is a polynomial, so that pixels may differ in their colour. After sheen.glsl and
// surface_class.glsl.
//
// A highlight must not lie between nodes: the facets that mirror the lamp to the eye turn over the tile by no more than
// kTurnMax of its width, else each pixel computes the beam.
const float kTurnMax = 1.5;

// Of the pixel in the middle, if it is on the plane: alpha, the largest channels of `straight` and `diffuse`, and its
// SheenRow; 0: it has no sheen.
shared vec4 tile_sheen;
shared bool plane_sheen;  // some pixel on the plane has sheen
shared bool plane_mixed;  // and some that of another material
bool in_tile_sheen[kRows];  // the pixel is on the plane and has its material
float sheen_sums[3];        // of thread k < FL_TILE_LIGHT: as add_smooth_beams() adds to it
shared uint sheen_bits[kBatchWords];  // of a batch: beams in these polynomials
shared bool has_sheen_sums;

float largest(vec3 v) { return max(v.r, max(v.g, v.b)); }

// After begin_sheen() and find_shapes(). middle: the pixel in the middle, as find_shapes() has it.
void find_tile_sheen(uvec2 first, uvec2 middle) {
  if (thread_number() == 0u) {
    tile_sheen = vec4(0.0);
    plane_sheen = false;
    plane_mixed = false;
    has_sheen_sums = false;
  }
  for (int part = 0; part < 3; ++part) sheen_sums[part] = 0.0;
  barrier();
  for (int i = 0; i < int(kRows); ++i) {
    if (first + uvec2(0, i) != middle || !on_plane[i] || surface[i].sheen == 0u) continue;
    tile_sheen = vec4(sheen[i].alpha, largest(sheen[i].straight), largest(sheen[i].diffuse), float(surface[i].sheen));
  }
  barrier();
  for (int i = 0; i < int(kRows); ++i) {
    in_tile_sheen[i] = on_plane[i] && surface[i].sheen != 0u && surface[i].sheen == uint(tile_sheen.w) &&
                       sheen[i].alpha == tile_sheen.x;
    if (on_plane[i] && surface[i].sheen != 0u) plane_sheen = true;
    if (on_plane[i] && surface[i].sheen != 0u && !in_tile_sheen[i]) plane_mixed = true;
  }
}

// Towards the lens from a node, and the angle of the lens there.
vec3 node_to_light(BeamRow row, uint node, out float lens_rad) {
  vec3 p = row.eye.xyz + to_light(row, nodes[node].xyz);
  vec3 way = plain_way(row, p);
  float slant = length(way);
  lens_rad = lens_angle(row, p.z * slant);
  return -way_on_stage(row, way / slant);
}

// part: 0 to 2 for P, Q and R; 3: what the middle's material reflects in its brightest channel.
float sheen_at_node(BeamRow row, uint node, Medium medium, float facing, vec3 normal, uint part) {
  float light = light_at_node(row, node, medium, facing);
  if (!(light > 0.0)) return 0.0;
  float lens_rad;
  vec3 to_lens = node_to_light(row, node, lens_rad);
  vec3 to_eye = -normalize(nodes[node].xyz);
  float left = sheen_left(max(dot(normal, to_lens), 0.0));
  if (part == 2u) return light * left;
  float fresnel;
  float lobe = light * sheen_lobe(tile_sheen.x, lens_rad, normal, to_eye, to_lens, fresnel);
  if (part == 0u) return lobe * (1.0 - fresnel);
  if (part == 1u) return lobe * fresnel;
  return lobe * mix(tile_sheen.y, 1.0, fresnel) + light * tile_sheen.z * sheen_rest(normal, to_eye) * left;
}

// How far the facets turn between the outermost nodes, over the width of the highlight.
float sheen_turn(BeamRow row) {
  const uint kOuter[4] = uint[4](0u, 3u, 12u, 15u);
  vec3 facets[4];
  float lens_rad = 0.0;
  for (uint k = 0u; k < 4u; ++k) {
    vec3 to_lens = node_to_light(row, kOuter[k], lens_rad);
    facets[k] = sheen_facet(-normalize(nodes[kOuter[k]].xyz), to_lens);
  }
  float turn = max(length(facets[0] - facets[3]), length(facets[1] - facets[2]));
  return turn / sheen_alpha(tile_sheen.x, lens_rad, 1.0);
}

// Of `here` beams that cover the plane, from the list's place `at` on: finds those whose sheen is smooth and adds them.
// covering: their numbers in the batch. All threads of the group call it together.
void classify_sheen(uint at, uint here, Medium medium, vec3 normal) {
  uint number = thread_number();
  for (uint step = 0u; step < 4u; ++step) {
    uint part = step == 0u ? 3u : step - 1u;
    for (uint e = number; e < here * FL_NODES; e += kGroup) {
      uint b = covering[e / FL_NODES];
      node_light[e] = sheen_at_node(beams[list_ids[at + b]], e % FL_NODES, medium, plane_facing[b], normal, part);
    }
    barrier();
    if (step == 0u) {
      vec2 fit = vec2(0.0, FL_FAR_M);
      vec3 color = vec3(0.0);
      for (uint b = number; b < here; b += kGroup) {
        BeamRow row = beams[list_ids[at + covering[b]]];
        fit = mean_and_tail(b);
        if (!(sheen_turn(row) <= kTurnMax)) fit.y = FL_FAR_M;
        color = row.j0.rgb;
      }
      float tolerance = surface_tolerance(largest(color) * fit.x);
      bool is_smooth = fit.y <= kTailMax * fit.x && largest(color) * fit.y <= tolerance;
      for (uint b = number; b < here; b += kGroup) {
        smooth_color[b] = is_smooth ? vec4(color, 0.0) : vec4(0.0);
        if (is_smooth) {
          atomicOr(sheen_bits[covering[b] >> 5], 1u << (covering[b] & 31u));
          has_sheen_sums = true;
        }
      }
    } else {
      add_nodes(here, sheen_sums[part]);
    }
    barrier();
  }
}

// The polynomial in part_sums. px: from the middle of the tile.
vec3 polynomial_at(vec2 px) {
  vec4 tx = chebyshev(px.x / kHalfHullPx);
  vec4 ty = chebyshev(px.y / kHalfHullPx);
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 4; ++n) {
    for (int m = 0; m < 4; ++m) {
      int k = 3 * (4 * n + m);
      sum += tx[m] * ty[n] * vec3(part_sums[k], part_sums[k + 1], part_sums[k + 2]);
    }
  }
  return sum;
}

// Adds the polynomials of the tile to its pixels. from_px: of the thread's first pixel, from the middle.
void add_sheen_sums(vec2 from_px) {
  for (uint part = 0u; part < 3u; ++part) {
    fit_sums(sheen_sums[part]);
    for (int i = 0; i < int(kRows); ++i) {
      if (!in_tile_sheen[i]) continue;
      vec3 sum = polynomial_at(from_px + vec2(0.0, i));
      vec3 to_eye = -normalize(offset_m[i]);
      if (part == 0u) sum *= sheen[i].straight;
      if (part == 2u) sum *= sheen[i].diffuse * sheen_rest(surface[i].normal, to_eye);
      reflected[i] += sum;
    }
  }
  for (int i = 0; i < int(kRows); ++i) reflected[i] = max(reflected[i], vec3(0.0));
}
