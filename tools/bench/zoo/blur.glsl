#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  const float weight[5] = float[](0.227027, 0.194594, 0.121622, 0.054054, 0.016216);
  vec2 texel = 1.0 / vec2(textureSize(picture, 0));
  vec4 sum = pixel(uv) * weight[0];
  for (int i = 1; i < 5; ++i) sum += (pixel(uv + vec2(texel.x * i, 0)) + pixel(uv - vec2(texel.x * i, 0))) * weight[i];
  return sum;
}
