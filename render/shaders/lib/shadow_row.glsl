// Planes of a ShadowRow: those of the outline come first, then the fronts. After the buffer `shadows`.
uint shadow_planes(uint shadow) { return shadows[shadow].count & 255u; }
uint shadow_outline(uint shadow) { return shadow_planes(shadow) - (shadows[shadow].count >> 8 & 255u); }
// Its body is wholly in the shadow of another one (prune.comp).
bool shadow_is_hidden(uint shadow) { return (shadows[shadow].count & FL_SHADOW_HIDDEN) != 0u; }
