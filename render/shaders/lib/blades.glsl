// Edges of blades, one row a beam.
layout(constant_id = FL_SPEC_BLADES) const bool kBlades = false;
layout(set = 0, binding = FL_BINDING_BLADES, std430) readonly buffer BladesBuffer { BladesRow blades[]; };
