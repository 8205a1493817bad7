// Which forms of beams a rig can have: profiles other than m = 1, wide beams, irises, rectangles, and measured beams
// with their table. Every pass that computes light includes this, so that all of them leave out the same. Include it
// before beam.h.
layout(constant_id = FL_SPEC_PROFILE) const bool kProfile = false;
layout(constant_id = FL_SPEC_WIDE) const bool kWide = false;
layout(constant_id = FL_SPEC_IRIS) const bool kIris = false;
layout(constant_id = FL_SPEC_RECTANGLE) const bool kRectangle = false;
layout(constant_id = FL_SPEC_MEASURED) const bool kMeasured = false;
layout(set = 0, binding = FL_BINDING_DEFAULTS, std430) readonly buffer DefaultsBuffer { float defaults[]; };
float fl_default(uint index) { return defaults[index]; }
#include "fixtures/shared/measured.h"
#define FL_NEED_RECTANGLE kRectangle
#define FL_NEED_IRIS kIris
#define FL_NEED_WIDE kWide
#define FL_MEASURED
#define FL_NEED_MEASURED kMeasured
// The profile that is drawn. The flux factor of a beam has to be that of this profile.
float drawn_profile(float profile_power) { return kProfile ? profile_power : 1.0; }
