// Rivals: published methods for light in the haze and on surfaces, in code of our own, for `footlight report`. They
// take the place of the product's passes in a frame of the same rig, and read the same rows of beams, masks of tiles
// and distances of surfaces. Nothing of the product includes this folder.
//
// A rival is one file pair, its shaders in render/rivals/shaders/, and one line in rivals.cpp. What each is, where it
// is from and what it loses: docs/numerics.md.
#pragma once

#include <vector>

#include "render/frame.h"

namespace footlight::render {

struct Rival {
  const char* method;               // the name of its rows
  std::vector<double> knobs;        // the rows
  std::vector<double> quick_knobs;  // those of `report --quick`
  const char* after;                // what it restates
  bool on_surfaces = false;         // it replaces the light on surfaces, not that in the haze
  bool has_unit = true;             // false: its brightness is chosen, so the report fits it as well
  bool is_raster = false;           // it is mostly fragment shaders
  PassList (*passes)() = nullptr;
  // The settings of a frame at a knob.
  FrameSettings (*settings)(FrameSettings judged, double knob) = nullptr;
  bool of_shadows = false;  // it has rows only where something hides light
  bool of_panes = false;    // it replaces the light behind panes, and has rows only where a rig has some
};

[[nodiscard]] const std::vector<Rival>& rivals();

// The passes of the product with others in place of its light in the haze; empty: without.
[[nodiscard]] PassList passes_with_air(const PassList& air);
// The same for its light on surfaces.
[[nodiscard]] PassList passes_with_surfaces(const PassEntry* surfaces);

}  // namespace footlight::render
