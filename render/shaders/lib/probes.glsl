// What surfaces with sheen mirror, as reflection probes show it (shared/probe.h). After sheen.h and probe.h.
layout(set = 0, binding = FL_BINDING_PROBES, std430) readonly buffer ProbesBuffer { ProbeRow probes[]; };
layout(set = 0, binding = FL_BINDING_PROBE_LIGHT, std430) readonly buffer ProbeLightBuffer { vec4 probe_light[]; };

const uint kShares = uint(FL_PROBE_SHARES);

// Of even light: share of what goes straight back, and what is added by Schlick.
vec2 probe_shares(float alpha, float cosine) {
  vec2 at = probe_share_place(alpha, cosine) * float(kShares - 1u);
  vec2 low = min(floor(at), vec2(kShares - 2u));
  vec2 share = at - low;
  uint first = uint(low.y) * kShares + uint(low.x);
  return mix(mix(probe_light[first].xy, probe_light[first + 1u].xy, share.x),
             mix(probe_light[first + kShares].xy, probe_light[first + kShares + 1u].xy, share.x), share.y);
}

vec3 probe_level_light(uint probe, uint level, vec2 at) {
  uint first = kShares * kShares + probe * uint(FL_PROBE_ALL) + probe_first(level);
  int side = int(probe_side(level));
  vec2 place = at * float(side) - 0.5;
  ivec2 low = ivec2(floor(place));
  vec2 share = place - vec2(low);
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < 4u; ++i) {
    ivec2 corner = ivec2(i & 1u, i >> 1);
    vec2 weight = mix(1.0 - share, share, vec2(corner));
    sum += weight.x * weight.y * probe_light[first + probe_texel(low.x + corner.x, low.y + corner.y, side)].rgb;
  }
  return sum;
}

// Light that a probe sees in a direction, over a lobe of this alpha.
vec3 probe_seen(uint probe, vec3 toward, float alpha) {
  vec2 at = probe_square(toward);
  float level = probe_level(alpha);
  float low = floor(min(level, float(FL_PROBE_LEVELS - 2)));
  return mix(probe_level_light(probe, uint(low), at), probe_level_light(probe, uint(low) + 1u, at), level - low);
}

// Light that a surface with sheen mirrors to the eye, cd/m^2. offset_m: from the camera. even: what is left of the
// light that it shows of even illuminance, since that is mirrored here; a metal has no other.
vec3 probes_mirrored(Sheen sheen, float metal, vec3 normal, vec3 offset_m, out float even) {
  vec3 to_eye = -normalize(offset_m);
  vec3 place = params.position.xyz + offset_m;
  vec3 straight = vec3(0.0);  // light of what goes straight back, and of what Schlick's term adds
  vec3 added = vec3(0.0);
  vec2 weights = vec2(0.0);
  float covered = 0.0;
  for (uint k = 0u; k < kProbeFacets; ++k) {
    ProbeFacet facet = probe_facet(k, sheen.alpha, normal, to_eye);
    vec2 parts = facet.share * vec2(1.0 - facet.fresnel, facet.fresnel);
    weights += parts;
    float left = 1.0;
    for (uint i = 0u; i < FL_NOT_IN_CODE(params.probe_count) && left > 0.0 && facet.share > 0.0; ++i) {
      ProbeRow probe = probes[i];
      float weight = min(probe_weight(place, probe.low.xyz, probe.high.xyz, probe.low.w), left);
      if (!(weight > 0.0)) continue;
      left -= weight;
      vec3 toward = probe_toward(place, facet.way, probe.low.xyz, probe.high.xyz, probe.center.xyz);
      if (!(dot(toward, toward) > 1e-12)) toward = facet.way;
      vec3 seen = weight * probe_seen(i, toward, facet.alpha);
      straight += parts.x * seen;
      added += parts.y * seen;
    }
    covered = max(covered, 1.0 - left);
  }
  vec2 shares = probe_shares(sheen.alpha, max(dot(normal, to_eye), 0.0));
  even = 1.0 - covered * mix(kSheenDielectric * shares.x + shares.y, 1.0, metal);
  return sheen.straight * shares.x * straight / max(weights.x, 1e-9) + shares.y * added / max(weights.y, 1e-9);
}
