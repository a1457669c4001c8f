#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec2 t = 1.0 / vec2(textureSize(picture, 0));
  float v[9];
  for (int i = 0; i < 9; ++i) v[i] = dot(pixel(uv + vec2(i % 3 - 1, i / 3 - 1) * t).rgb, vec3(0.299, 0.587, 0.114));
  float x = v[2] + 2.0 * v[5] + v[8] - v[0] - 2.0 * v[3] - v[6], y = v[6] + 2.0 * v[7] + v[8] - v[0] - 2.0 * v[1] - v[2];
  return vec4(vec3(sqrt(x * x + y * y)) * tint.rgb, 1.0);
}
