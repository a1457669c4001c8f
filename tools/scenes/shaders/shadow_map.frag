// Nine comparisons around each pixel, each of them filtered.
#version 450

layout(set = 0, binding = 0) uniform sampler2DShadow shadow_map;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  float sum = 0.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) sum += textureLod(shadow_map, vec3(uv + vec2(x, y) / 256.0, uv.x), 0.0);
  }
  colour = vec4(mix(vec3(0.16, 0.18, 0.26), vec3(1.0, 0.93, 0.78), sum / 9.0), 1.0);
}
