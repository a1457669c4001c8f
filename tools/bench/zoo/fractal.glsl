#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec2 c = uv * 3.0 - vec2(2.0, 1.5), z = vec2(0.0);
  int n = 0;
  for (; n < 64 && dot(z, z) < 16.0; ++n) z = vec2(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y) + c;
  float t = (float(n) - log2(log2(max(dot(z, z), 2.0)))) / 64.0;
  return n == 64 ? vec4(0, 0, 0, 1) : vec4(0.5 + 0.5 * cos(6.28318 * (t + vec3(0.0, 0.33, 0.67))), 1.0);
}
