// Planes of a ShadowRow: those of the outline come first, then the fronts. After the buffer `shadows`.
uint shadow_planes(uint shadow) { return shadows[shadow].count & 255u; }
uint shadow_outline(uint shadow) { return shadow_planes(shadow) - (shadows[shadow].count >> 8); }
