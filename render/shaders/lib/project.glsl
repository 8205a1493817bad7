// Camera-relative position to clip space: reversed depth without a far plane, depth = near / distance along the axis.
vec4 project(vec3 from_camera_m) {
  float across = dot(from_camera_m, params.right.xyz) / dot(params.right.xyz, params.right.xyz);
  float up = dot(from_camera_m, params.up.xyz) / dot(params.up.xyz, params.up.xyz);
  return vec4(across, -up, params.right.w, dot(from_camera_m, params.forward.xyz));
}
