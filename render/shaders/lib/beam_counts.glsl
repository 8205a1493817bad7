// Sizes of the passes that follow, for so many beams. After view_beams.glsl.
void write_beam_counts(uint live) {
  counts.live_count = live;
  set_view_groups(live);
  counts.shadow_groups[0] = min(live, uint(FL_SHADOWS_X));
  counts.shadow_groups[1] = (live + uint(FL_SHADOWS_X) - 1u) / uint(FL_SHADOWS_X);
  counts.shadow_groups[2] = 1u;
}
