// Beams that are not round: rectangles, and measured ones with their table. Before beam.h.
layout(constant_id = FL_SPEC_RECTANGLE) const bool kRectangle = false;
layout(constant_id = FL_SPEC_MEASURED) const bool kMeasured = false;
layout(set = 0, binding = FL_BINDING_DEFAULTS, std430) readonly buffer DefaultsBuffer { float defaults[]; };
float fl_default(uint index) { return defaults[index]; }
#include "fixtures/shared/measured.h"
#define FL_NEED_RECTANGLE kRectangle
#define FL_MEASURED
#define FL_NEED_MEASURED kMeasured
