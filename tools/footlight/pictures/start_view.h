// The start camera of a rig without cameras of its own.
#pragma once

#include "fixtures/model/rig.h"

namespace footlight::tools {

// A camera that sees as many fixtures as possible, if possible from the front, with every fixture and the stage below
// it in a picture of this width over height. In a hall with walls in the way the camera moves inside and its field of
// view widens, up to 95 degrees. Reads the meshes of the scene; unreadable ones hide nothing. Its exposure is that of
// work light; with `lit`, the one at which all lamps at full, spread evenly over the floor below the rig, make a grey
// floor half white.
[[nodiscard]] fixtures::Camera start_view(const fixtures::Rig& rig, double aspect, bool lit);

// Inserts start_view() as "start" before the rig's cameras, if the importer made those up.
void add_start_view(fixtures::Rig& rig, double aspect, bool lit);

// Work light for a rig without input, lx: 150, or enough to show the black housings of fixtures at an exposure for
// bright lamps.
[[nodiscard]] double work_light_lx(double exposure_ev);
// Faint work light beside lit lamps: a housing then has 2 % of white, a grey floor 18 %. Chosen by eye.
[[nodiscard]] double faint_light_lx(double exposure_ev);

}  // namespace footlight::tools
