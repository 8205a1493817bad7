#version 460
// A rival: a card a beam, a flat fan that turns about the beam's axis to face the camera (DH Wang, "a simple shaft of
// light from a spotlight", 2022, in Chinese). Two corners are at the lens, two at the end; the attenuation of a corner
// is 1 and 0, as the colours of its vertices say.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/project.glsl"
#include "render/rivals/shaders/lib/beam_ends.glsl"
#include "render/rivals/shaders/lib/mesh_light.glsl"

layout(location = 0) out vec3 from_camera_m;
layout(location = 1) out vec2 place;   // x: over the radius at its distance, times that radius; y: from the apex
layout(location = 2) out float attenuation;
layout(location = 3) flat out vec3 light;

void main() {
  BeamRow row = beams[gl_InstanceIndex];
  uint corner = uint(gl_VertexIndex);
  float across = corner == 1u || corner == 2u || corner == 4u ? 1.0 : -1.0;
  float along = corner == 2u || corner == 4u || corner == 5u ? 1.0 : 0.0;
  BeamEnds ends = beam_ends(row);
  // Across the axis and the camera's direction. A camera on the axis sees the card from the edge, whichever way it is
  // turned.
  vec3 aside = cross(row.axis.xyz, ends.lens_m);
  float length_m = length(aside);
  aside = length_m > 1e-6 ? aside / length_m : normalize(row.x_axis.xyz);
  float z = along * row.axis.w;
  float w = row.x_axis.w + row.y_axis.w * z;
  from_camera_m = ends.lens_m + row.axis.xyz * z + aside * (across * w);
  // In units in which the fan's edge is at 1 radian: x LightRange, y + LightOffset.
  place = vec2(1.5574077 * across * w, w);
  attenuation = 1.0 - along;
  light = mesh_light(row);
  gl_Position = project(from_camera_m);
}
