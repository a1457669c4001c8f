// Slanted cuts through a volume.
#version 450

layout(set = 0, binding = 0) uniform sampler3D volume;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec3 p = vec3(uv * 1.2 - 0.1, uv.x * 0.7 + uv.y * 0.5);
  colour = vec4(texture(volume, p).rgb * 0.6 + texture(volume, p.zxy * 3.0).rgb * 0.4, 1.0);
}
