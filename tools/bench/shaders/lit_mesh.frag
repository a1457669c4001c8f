#version 450

layout(location = 0) in vec3 world_normal;
layout(location = 0) out vec4 result;

void main() {
  vec3 n = normalize(world_normal);
  float sun = max(dot(n, vec3(0.36, 0.8, 0.48)), 0.0);
  result = vec4(vec3(0.9, 0.6, 0.3) * (0.25 + 0.75 * sun), 1.0);
}
