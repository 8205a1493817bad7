// What rivals share that draw a mesh a beam. They have no unit: the lens is as bright as the haze across it would be if
// it scattered to all sides, and the method's own fall-off takes it from there. Times the exposure, so that half floats
// hold it.
vec3 mesh_light(BeamRow row) {
  return row.j0.rgb * (params.exposure * params.forward.w * 0.15915494 / row.x_axis.w);
}
