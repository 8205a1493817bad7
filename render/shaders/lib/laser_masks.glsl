// For each supertile one bit a row of the lasers: may it touch the supertile? After laser_row.glsl.
layout(set = 0, binding = FL_BINDING_LASER_MASKS, std430) FL_LASER_MASKS_ACCESS buffer LaserMasksBuffer {
  uint laser_masks[];
};
uint laser_words() { return (uint(lasers.length()) + 31u) / 32u; }
