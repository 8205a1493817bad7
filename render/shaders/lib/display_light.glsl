// Light of the cells of a display at a place: on a surface, or in the air towards the eye. After beam.h, display.h and
// display_cells.glsl. Places and directions are in the space of the display (display.h).

// A cell is as large as this at most, as its extent over its distance: what it gives is then linear over it but for
// this error. Larger ones are halved, down to pixels. In the air and in dense haze pixels are halved as well. On
// surfaces it is smaller where much is lost on the way, as that bends what it gives; at most by kMostLoss, beyond which
// hardly any light arrives.
const float kWidestOnSurface = 0.35;
const float kMostLoss = 12.0;
const float kWidestInAir = 0.5;
const float kWidestHaze = 2e-3;  // of a pixel's extent times the extinction; else it is halved where it is wide
// Up to these the light of a cell is taken from second derivatives; beyond, its angle or its form are exact.
const float kSeriesInAir = 0.25;
const float kSeriesOnSurface = 0.3;

// Nearer to its face light is as there: the largest part of a pixel, times this.
const float kAhead = 2.0;
float ahead_of(DisplayRow row) {
  vec2 size = vec2(uvec2(row.columns, row.rows) << halvings(row, FL_DISPLAY_PARTS));
  return kAhead * max(2.0 * row.right.w / size.x, 2.0 * row.down.w / size.y);
}

// A cell as it is seen from a place.
struct SeenCell {
  vec3 from;     // to its middle, m
  vec2 side;     // m
  vec2 pixel_m;  // of the display
  float area;    // m^2
  float square;  // of the distance
  float away;
  float extent;  // the longer side
  float per_m;   // extinction
  bool is_whole;  // larger than a pixel: it has moments
};

// Illuminance, lx.
vec3 cell_on_surface(DisplayCell cell, SeenCell seen, vec3 normal) {
  float above = dot(seen.from, normal);
  float point = -seen.from.z * seen.area / (seen.square * seen.square);
  vec2 fall = seen.from.xy * (-4.0 / seen.square - seen.per_m / seen.away);
  bool is_whole_above = above > 0.5 * dot(seen.side, abs(normal.xy));
  float form;
  if (is_whole_above && seen.extent < kSeriesOnSurface * seen.away) {
    vec2 to = seen.from.xy * seen.from.xy / seen.square;
    vec2 bend = fall * (2.0 * normal.xy + above * fall) -
                above * ((4.0 - 8.0 * to) / seen.square + (1.0 - to) * (seen.per_m / seen.away));
    form = max(point * (above + dot(seen.side * seen.side, bend) / 24.0), 0.0);
  } else {
    form = display_form(seen.from, 0.5 * seen.side.x, 0.5 * seen.side.y, normal);
  }
  vec3 lx = cell.mean * form;
  if (seen.is_whole && above > 0.0 && seen.extent < seen.away) {
    vec2 slope = (normal.xy + above * fall) * (point * seen.pixel_m);
    lx += cell.moment_x * slope.x + cell.moment_y * slope.y;
  }
  return lx * exp(-seen.per_m * seen.away);
}

// Light that a metre of haze scatters towards the eye, over sigma_s. ray: from the eye.
vec3 cell_in_air(DisplayCell cell, SeenCell seen, vec3 ray) {
  float g = params.anisotropy;
  float mu = -dot(seen.from, ray) / seen.away;
  float point = -seen.from.z * seen.area / (seen.square * seen.away);
  // What is integrated is -from.z / away^3 times the phase function and the loss. slope: its derivatives over itself,
  // times the distance; bend: its second derivatives over itself, times the square, less those of the first factor.
  float forward = max(1.0 + g * g + 2.0 * g * mu, 1e-6);
  float loss = seen.per_m * seen.away;
  vec2 to = seen.from.xy / seen.away;
  vec2 turn = ray.xy + mu * to;
  vec2 bent = turn * (3.0 * g / forward) - to * loss;
  vec2 bend = bent * (bent - 6.0 * to) + (to * to - 1.0) * loss +
              (mu * (1.0 - to * to) - 2.0 * turn * to + turn * turn * (2.0 * g / forward)) * (3.0 * g / forward);
  bool is_series = seen.extent < kSeriesInAir * seen.away;
  bool is_near = seen.extent > seen.away;
  if (is_series) bend += 15.0 * to * to - 3.0;
  float angle = is_series ? point : display_angle(seen.from, 0.5 * seen.side.x, 0.5 * seen.side.y);
  if (!is_near) angle = max(angle + point * dot(seen.side * seen.side, bend) / (24.0 * seen.square), 0.0);
  vec3 light = cell.mean * angle;
  if (seen.is_whole && !is_near) {
    vec2 slope = (bent - 3.0 * to) * (point / seen.away * seen.pixel_m);
    light += cell.moment_x * slope.x + cell.moment_y * slope.y;
  }
  return light * (exp(-loss) * phase_function(mu, g));
}

// towards: the normal of the surface, or the ray. per_m: extinction.
vec3 light_of_cells(DisplayRow row, vec3 place, vec3 towards, bool in_air, float per_m) {
  uvec2 parts = halvings(row, FL_DISPLAY_PARTS);
  uvec2 size = uvec2(row.columns, row.rows) << parts;
  vec2 half_m = vec2(row.right.w, row.down.w);
  vec2 part_m = 2.0 * half_m / vec2(size);
  uint root = FL_DISPLAY_PARTS + row.levels - 1u;
  uint level = root;
  uvec2 shift = halvings(row, level);
  uvec2 at = uvec2(0u);
  vec3 sum = vec3(0.0);
  for (bool more = true; more;) {
    vec2 low = vec2(at << shift);
    vec2 high = vec2(min((at + 1u) << shift, size));
    SeenCell seen;
    seen.from = vec3(0.5 * (low + high) * part_m - half_m - place.xy, -place.z);
    seen.side = (high - low) * part_m;
    seen.square = max(dot(seen.from, seen.from), 1e-20);
    seen.away = sqrt(seen.square);
    seen.extent = max(seen.side.x, seen.side.y);
    float widest = in_air ? kWidestInAir : kWidestOnSurface * 4.0 / (4.0 + min(per_m * seen.away, kMostLoss));
    bool is_pixel = level <= uint(FL_DISPLAY_PARTS);
    bool halves = !is_pixel || ((in_air || per_m * seen.extent > kWidestHaze) && level > 0u);
    bool dark = !in_air && dot(seen.from, towards) + 0.5 * dot(seen.side, abs(towards.xy)) <= 0.0;  // below the horizon
    if (seen.extent > widest * seen.away && halves && !dark) {
      --level;
      uint down = halves_down(row, level) ? 1u : 0u;
      shift -= uvec2(1u - down, down);
      at <<= uvec2(1u - down, down);
      continue;
    }
    if (!dark) {
      seen.pixel_m = part_m * vec2(uvec2(1u) << parts);
      seen.area = seen.side.x * seen.side.y;
      seen.per_m = per_m;
      seen.is_whole = !is_pixel;
      uint cell_level = is_pixel ? 0u : level - uint(FL_DISPLAY_PARTS);
      DisplayCell cell = read_cell(row, cell_level, is_pixel ? at >> (parts - shift) : at);
      sum += in_air ? cell_in_air(cell, seen, towards) : cell_on_surface(cell, seen, towards);
    }
    // The next cell in the order of the halves.
    more = false;
    while (level < root && !more) {
      uint down = halves_down(row, level) ? 1u : 0u;
      uvec2 axis = uvec2(1u - down, down);
      uint own = down != 0u ? at.y : at.x;
      uint next = (own + 1u) << (down != 0u ? shift.y : shift.x);
      more = (own & 1u) == 0u && next < (down != 0u ? size.y : size.x);
      if (more) {
        at += axis;
      } else {
        at >>= axis;
        shift += axis;
        ++level;
      }
    }
  }
  return max(sum, 0.0);
}

// Rays are integrated over w, where the distance from the nearest place is d sinh(w): near a display a node stands for
// a part of d, and far away each has the same share of the distance. Pieces of w have four nodes. They are
// shorter where much is lost within the size of what is seen, and in clouds, as a node stands for the haze around it.
const float kPieceW = 1.0;
#ifdef FL_USE_HAZE
const float kPieceMostW = kPieceW;
#else
const float kPieceMostW = 2.0;
#endif
const uint kPiecesMost = 32u;
const float kFar = 30.0;       // in sizes of what is seen; beyond, light falls with the square of the distance
const float kNearest = 0.25;   // of the shorter side of a display: nearer to it d stays

float w_of(float x) { return sign(x) * log(abs(x) + sqrt(x * x + 1.0)); }

#ifdef FL_USE_HAZE
// Beyond the table of haze there are no clouds, but haze thins with height all the same (haze_field.h). This is
// (z / height)^4.
float haze_thins(float z_m) {
  float height = max(z_m, 0.0) * haze_field.per_height;
  height *= height;
  return height * height;
}
// Mean density of the piece of a ray that a node at t_m stands for. up: what the ray rises in a metre.
float haze_of_piece(float t_m, float from_m, float to_m, float up) {
  float density = haze_mean(from_m, to_m);
  float begin_m = haze_field.from_m;
  float end_m = begin_m + haze_field.length_m;
  float inside = clamp((min(to_m, end_m) - max(from_m, begin_m)) / max(to_m - from_m, 1e-6), 0.0, 1.0);
  if (inside == 1.0) return density;
  if (t_m >= begin_m && t_m <= end_m) t_m = to_m > end_m ? 0.5 * (end_m + to_m) : 0.5 * (from_m + begin_m);
  float thins = haze_thins(params.position.z + up * t_m);
  return density - (1.0 - inside) * thins / (1.0 + thins);
}
#endif

// Where haze along a ray is lit by a display: before its plane, up to what the ray hits. Nowhere: y is not beyond x.
vec2 lit_range(vec3 eye, vec3 way, float end_m) {
  float begin_m = 0.0;
  if (way.z > 0.0) begin_m = max(-eye.z / way.z, 0.0);
  if (way.z < 0.0) end_m = min(end_m, eye.z / -way.z);
  if (way.z == 0.0 && !(eye.z > 0.0)) end_m = 0.0;
  return vec2(begin_m, end_m);
}

// How a ray is cut before a display: its part in front of it, and what w is along it.
struct AirShape {
  float begin_m;
  float last_m;  // where it ends
  float far_m;
  float middle_m;  // the nearest to the middle of the display
  float size_m;    // of what is seen
  float nearest_m;  // where w is 0
  float d;
  uint pieces;
};
float w_at(AirShape shape, float t_m) { return w_of((t_m - shape.nearest_m) / shape.d); }

// Without nearest_m, d and pieces.
AirShape air_range(DisplayRow row, vec3 eye, vec3 way, float end_m) {
  AirShape shape;
  vec2 lit = lit_range(eye, way, end_m);
  shape.begin_m = lit.x;
  shape.last_m = lit.y;
  shape.middle_m = max(-dot(eye, way), lit.x);
  shape.size_m = length(vec2(row.right.w, row.down.w)) + length(eye + way * shape.middle_m);
  shape.far_m = shape.middle_m + kFar * shape.size_m;
  return shape;
}
float air_end(AirShape shape) { return min(shape.last_m, shape.far_m); }
bool is_lit(AirShape shape) { return air_end(shape) > shape.begin_m; }
void find_nearest(DisplayRow row, vec3 eye, vec3 way, float per_m, inout AirShape shape) {
  vec2 half_m = vec2(row.right.w, row.down.w);
  float end_m = air_end(shape);
  shape.nearest_m = display_nearest(eye, way, half_m.x, half_m.y, shape.begin_m, end_m);
  shape.d = max(display_distance(eye + way * shape.nearest_m, half_m.x, half_m.y),
                2.0 * kNearest * min(half_m.x, half_m.y));
  float piece_w = clamp(kPieceMostW * (1.0 - per_m * shape.size_m), kPieceW, kPieceMostW);
  float whole = w_at(shape, end_m) - w_at(shape, shape.begin_m);
  shape.pieces = uint(clamp(ceil(whole / piece_w), 1.0, float(kPiecesMost)));
}

// Light at a node of a ray, times what it stands for and what is lost to the eye, over sigma_s. first, whole: w where
// the ray begins, and up to air_end(). up: what the ray rises in a metre. The last node is for what is beyond far_m.
vec3 light_of_node(DisplayRow row, AirShape shape, vec3 eye, vec3 way, float first, float whole, float up, uint number,
                   float per_m) {
  bool is_last = number == 4u * shape.pieces;
  float piece = whole / float(shape.pieces);
  float grown = exp(first + piece * (float(number >> 2) + kGaussNode[6u + (number & 3u)]));
  float t_m = clamp(shape.nearest_m + 0.5 * shape.d * (grown - 1.0 / grown), shape.begin_m, air_end(shape));
  float step_m = 0.5 * shape.d * (grown + 1.0 / grown) * piece * kGaussWeight[6u + (number & 3u)];
  if (is_last) {
    if (!(shape.far_m < shape.last_m)) return vec3(0.0);
    t_m = shape.far_m;
    // The light falls by this power of the distance, and one more: by its square, the loss, and what haze thins.
    float away_m = shape.far_m - shape.middle_m;
    float power = 1.0 + 2.0 * per_m * away_m;
#ifdef FL_USE_HAZE
    float z_m = params.position.z + up * t_m;
    float thins = haze_thins(z_m);
    power += 4.0 * thins / (1.0 + thins) * max(up, 0.0) * away_m / max(z_m, 1e-3);
#endif
    // Less what is beyond the end of the ray.
    step_m = away_m / power * (1.0 - pow(away_m / (shape.last_m - shape.middle_m), power));
  }
  float weight = step_m * exp(-per_m * t_m);
#ifdef FL_USE_HAZE
  vec2 haze_m = is_last ? vec2(0.95, 1.05) * t_m
                        : clamp(t_m + vec2(-0.5, 0.5) * step_m, shape.begin_m, air_end(shape));
  weight *= haze_of_piece(t_m, haze_m.x, haze_m.y, up);
#endif
  vec3 place = eye + way * t_m;
  if (all(lessThan(abs(place.xy), vec2(row.right.w, row.down.w)))) place.z = max(place.z, ahead_of(row));
  place.z = max(place.z, 1e-6 * shape.d);
  return light_of_cells(row, place, way, true, per_m) * weight;
}
