// What a surface is called where edges are found: as in the visibility buffer, and a box by this bit, its number << 3
// and its face; 0: nothing. After surface.glsl.
#define FL_BOX_ID 0x40000000u
// What is the same all over a surface: of a textured one the two bits alone.
uint object_identity(uint id) {
  const uint kTextured = FL_OBJECT | FL_OBJECT_TEXTURED;
  return (id & kTextured) == kTextured ? kTextured : id;
}
uint box_face_id(uint box, vec3 normal) {
  uint axis = normal.x != 0.0 ? 0u : normal.y != 0.0 ? 1u : 2u;
  return FL_BOX_ID | box << 3 | axis << 1 | (normal[axis] > 0.0 ? 1u : 0u);
}
uint surface_name(Surface surface) {
  return surface.kind == kNothing  ? 0u
         : surface.kind == kBox    ? box_face_id(surface.which, surface.normal)
         : surface.kind == kObject ? object_identity(surface.which | FL_OBJECT)
                                   : surface.which + 1u;
}
