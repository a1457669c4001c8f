#version 450

layout(set = 0, binding = 0) uniform View { mat4 view_projection; };
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 world_normal;

void main() {
  world_normal = normal;
  gl_Position = view_projection * vec4(position, 1.0);
}
