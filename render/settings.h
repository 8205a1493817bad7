// How a frame is computed: size, method and its knob. What the scene needs comes from fixtures::Needs.
#pragma once

#include <cstdint>

#include "render/frame_io.h"

namespace footlight::render {

// Gobos in haze (render/shaders/lib/gobo_chord.glsl). kTables: tables, and samples where frost blurs widely. kTaps:
// samples. kMidpoints: samples with all of the integrand computed at each, for the report. kSuited: as suits the
// device, which is kTaps on a CPU and else kTables. A CPU takes seconds to build the tables, and is slower with them.
enum class GoboMethod : std::uint32_t {
  kMidpoints = FL_GOBO_MIDPOINTS,
  kTaps = FL_GOBO_TAPS,
  kTables = FL_GOBO_TABLES,
  kSuited
};

enum class BeamMethod : std::uint32_t { kGauss = FL_METHOD_GAUSS, kMarch = FL_METHOD_MARCH };

// What the radiance of a frame is. kClasses: how many beams a pixel shows, red those that were computed for the pixel,
// green those that were taken together as smooth, blue those with a rim or cuts; surfaces are black. kLux: illuminance
// of the surface of each pixel in lx, per channel, without the air between it and the camera and without work light.
// kSteps: in each channel the cells of the images of panes that were integrated along the pixel's ray, of a rig with
// panes.
enum class FrameView : std::uint32_t {
  kPicture = FL_VIEW_PICTURE,
  kClasses = FL_VIEW_CLASSES,
  kLux = FL_VIEW_LUX,
  kSteps = FL_VIEW_STEPS
};

// From exposed light to the screen (render/shaders/shared/tone.h); words: render/display.h.
enum class ToneCurve : std::uint32_t {
  kAgx = FL_TONE_AGX,
  kFilmic = FL_TONE_FILMIC,
  kReinhard = FL_TONE_REINHARD,
  kLinear = FL_TONE_LINEAR
};

inline constexpr std::uint32_t kShadowsSuited = ~0u;
inline constexpr std::uint32_t kMapUsualPx = 64;
inline constexpr std::uint32_t kMapLeastPx = 16;
inline constexpr std::uint32_t kMapMostPx = 256;

// kTwoRounds: compute shaders that find depths first, then triangles, as devices without atomics of 64 bits need.
enum class TriangleMethod { kSuited, kRasteriser, kCompute, kTwoRounds };

struct FrameSettings {
  int width = 1280;
  int height = 720;
  // Beams in haze. Nodes of the Gauss rule (1 to 8) or steps of the march; errors in docs/numerics.md.
  BeamMethod method = BeamMethod::kGauss;
  std::uint32_t nodes = 3;
  // Beams that are smooth over a tile are taken together. Error that this may add to a tile's light, as a share of it,
  // when the errors of its beams are independent; 0: every beam is computed pixel by pixel.
  double tile_error = 4e-3;
  // Fewer live beams than that are computed pixel by pixel as well: there the passes of tiles cost more than they save.
  std::uint32_t tile_beams = 128;
  GoboMethod gobo_method = GoboMethod::kSuited;
  std::uint32_t gobo_taps = 128;  // samples of the gobo along one ray through one beam
  // Texels a side of gobo images, a power of two; 0: as suits the device and their number (gobo_size_px, resources.h).
  // A new frame reads it; change() does not.
  int gobo_px = 0;
  // Gates: whatever stands in a beam beside one still image is drawn as an image with tables of its own, for as many
  // states as this, up to FL_GATES_MAX. A new frame takes their memory (kGateBytes each, gobo_tables.h); change() does
  // not. A frame draws at most gate_builds of them, 0.3 ms each on an H200; beams whose gate has no image are sampled.
  std::uint32_t gobo_gates = 16;
  std::uint32_t gate_builds = 8;
  bool bodies = true;  // draw fixture bodies
  // Error in the picture that a plainer model of a body may have, in pixels; 0: whole models. A body is left out if its
  // diameter is below an eighth of that.
  double body_error_px = 0.5;
  // What draws the triangles of bodies and objects. kSuited: the rasteriser on a CPU, else compute shaders, if each
  // triangle of the rig can have a number below 2^32 - 1.
  TriangleMethod triangles = TriangleMethod::kSuited;
  bool haze = true;        // light in the air, where the rig has haze
  double dark_lm = 0;      // beams with no more flux are left out
  // Beams thinner than a pixel are drawn a pixel wide and as much weaker, lenses of a few pixels as splats of their
  // light, and lasers at all. Off in frames that are compared with the judge of beams.
  bool widen_thin = true;
  // Samples of what a pixel shows, where the edge of something solid may be in it: 4, 8 or 16; 0: edges stay jagged.
  std::uint32_t edge_samples = 16;
  // Pixels with room for samples at a time, 4 bytes each sample; at least a row of tiles has. The picture is the same.
  int edge_pixels = FL_EDGE_PIXELS;
  bool shadows = true;  // boxes and bodies hide light
  // Texels a side of shadow maps, 16 to 256, a power of two; 0: shadows are cut exactly. A new frame makes fewer where
  // the maps of all beams would take more than FL_MAP_BYTES_MAX. kShadowsSuited: as suits the rig (suited_map_px,
  // shadow_tables.h). A new frame reads it; change() refuses another way than the frame was made for.
  std::uint32_t shadow_map_px = kShadowsSuited;
  // Points of each lens from which exact shadows are cast, 1, 4 or 7 (lens_point(), render/shaders/shared/shadow.h). 1:
  // shadows have hard edges. Shadow maps have one. A new frame reads it; change() refuses more points than the frame
  // was made for.
  std::uint32_t penumbra = 1;
  // Boxes and built-in scenery reflect light to each other and to bodies (render/bounce_tables.h). Off here since the
  // judge has no such light; `render` and `preview` turn it on.
  bool bounce = false;
  // Surfaces with sheen mirror what reflection probes show (render/probe_tables.h). Only with bounce. Off here, too;
  // `render` and `preview` turn it on.
  bool probes = false;
  // Texels of each probe that a frame computes anew, 1 to FL_PROBE_TEXELS: all of them, or one after the other over
  // many frames, so that mirrored light is late.
  std::uint32_t probe_texels = FL_PROBE_TEXELS;
  // Pixels a side of the radiance, times supersample, that a pixel of the mirrored camera's picture stands for, 1 to 8,
  // in rigs with floors that mirror (render/mirror.h); 0: all floors are matt.
  std::uint32_t gloss_px = 2;
  // Share of the light that the camera's lens scatters, 0 to 1 (render/shaders/shared/glare.h); 0: no glare. The light
  // that is read back has none.
  double glare = 0.01;
  // What the camera makes of the light; the light that is read back stays as it is. white_k: light of a black body of
  // that temperature is shown as white, 1,500 to 20,000 K; 0: as it is, so that white is D65.
  double white_k = 0;
  ToneCurve tone = ToneCurve::kAgx;
  // Depth of field (Camera::f_stop, focus_m); f_stop 0: all is sharp. Of the picture's own light, so read back with it.
  double f_stop = 0;
  double focus_m = 10;
  bool auto_exposure = false;  // Frame::record() then takes its exposure from the picture
  FrameView view = FrameView::kPicture;
  int supersample = 1;  // pixels a side of one pixel of the screen; the size is that of the radiance
  bool operator==(const FrameSettings&) const = default;
};

}  // namespace footlight::render
