// Where a person wants to stand to see a rig that brings no camera of its own.
#pragma once

#include "fixtures/model/rig.h"

namespace footlight::tools {

// A camera that sees as many fixtures as can be, from the front where that is possible: every fixture and the stage
// below it is in a picture of this width over height. In a hall whose walls are in the way the camera comes inside and
// its field of view widens, up to 95 degrees. Reads the meshes of the scene; what cannot be read hides nothing.
// Its exposure is that of work light; with `lit`, one at which all lamps at full, spread evenly over the floor below
// the rig, make a grey floor half white.
[[nodiscard]] fixtures::Camera start_view(const fixtures::Rig& rig, double aspect, bool lit);

// Puts start_view() before the rig's cameras, as "start", where those were made up by the importer.
void add_start_view(fixtures::Rig& rig, double aspect, bool lit);

// Work light where nothing drives a rig, so that it can be seen, lx: 150, or as much as shows the black housings of
// fixtures where the exposure is for bright lamps.
[[nodiscard]] double work_light_lx(double exposure_ev);
// The little that shows them beside lit lamps: a housing then has 2 % of white, a grey floor 18 %. Chosen by eye.
[[nodiscard]] double faint_light_lx(double exposure_ev);

}  // namespace footlight::tools
