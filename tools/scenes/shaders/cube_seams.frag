// Three faces of a cube of few texels, and the corner where they meet.
#version 450

layout(set = 0, binding = 0) uniform samplerCube sky;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec2 p = uv * 3.0 - 1.5;
  vec3 across = vec3(0.7071068, -0.7071068, 0.0), up = vec3(0.4082483, 0.4082483, -0.8164966);
  colour = texture(sky, vec3(1.0, 0.9, 0.8) + p.x * across + p.y * up);
}
