#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 c = pixel(uv).rgb;
  float high = max(c.r, max(c.g, c.b)), low = min(c.r, min(c.g, c.b)), d = high - low + 1e-6;
  float h = high == c.r ? (c.g - c.b) / d : high == c.g ? 2.0 + (c.b - c.r) / d : 4.0 + (c.r - c.g) / d;
  h = mod(h / 6.0 + time.x * 0.1, 1.0);
  vec3 k = clamp(abs(fract(h + vec3(1.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
  return vec4(high * mix(vec3(1.0), k, d / (high + 1e-6)), 1.0);
}
