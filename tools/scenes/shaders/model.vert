#version 450

layout(set = 0, binding = 0) uniform View {
  mat4 view_projection;
  vec4 eye;
  vec4 light_direction;  // towards the light
};
layout(push_constant) uniform Draw {
  vec4 world_rows[3];   // model space to world space, an affine matrix by rows
  vec4 normal_rows[3];  // its cofactor matrix, which carries normals
  vec4 base_colour;     // linear
};
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texture_coordinate;
layout(location = 3) in vec4 vertex_colour;
layout(location = 0) out vec3 world_normal;
layout(location = 1) out vec3 to_eye;
layout(location = 2) out vec3 albedo;
layout(location = 3) out vec2 uv;

void main() {
  vec4 p = vec4(position, 1.0);
  vec3 world = vec3(dot(world_rows[0], p), dot(world_rows[1], p), dot(world_rows[2], p));
  world_normal = vec3(dot(normal_rows[0].xyz, normal), dot(normal_rows[1].xyz, normal), dot(normal_rows[2].xyz, normal));
  to_eye = eye.xyz - world;
  albedo = base_colour.rgb * vertex_colour.rgb;
  uv = texture_coordinate;
  gl_Position = view_projection * vec4(world, 1.0);
}
