// What the frame shows: the picture, how beams were computed, or the light on surfaces. A constant of the pipelines, so
// that the picture's have none of the others' code.
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
const bool kShowsClasses = kView == uint(FL_VIEW_CLASSES);
// In the view of classes a beam is 1: red where it is computed for the pixel, green where it is taken together as
// smooth, blue where it is smooth but for its rim or its cuts.
const vec3 kClassPixel = vec3(1.0, 0.0, 0.0);
const vec3 kClassSmooth = vec3(0.0, 1.0, 0.0);
const vec3 kClassRecord = vec3(0.0, 0.0, 1.0);
// What light over sigma_s is multiplied by.
float light_scale() { return kShowsClasses ? 1.0 : params.forward.w; }
