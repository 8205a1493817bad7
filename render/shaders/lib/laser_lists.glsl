// Strips of lasers in supertiles: LaserStripRow, and where those of a supertile are. After frame.glsl.
layout(set = 0, binding = FL_BINDING_LASER_STRIPS, std430) FL_STRIPS_ACCESS buffer LaserStripsBuffer {
  LaserStripRow laser_strips[];
};
layout(set = 0, binding = FL_BINDING_LASER_LISTS, std430) FL_LISTS_ACCESS buffer LaserListsBuffer {
  LaserListRow laser_lists[];  // of each supertile
};
