#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 x = pixel(uv).rgb * exp2(tint.w * 4.0);
  vec3 mapped = clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  float grey = dot(mapped, vec3(0.2126, 0.7152, 0.0722));
  mapped = mix(vec3(grey), mapped, 1.2) * (1.0 - 0.4 * dot(uv - 0.5, uv - 0.5));
  return vec4(mix(mapped * 12.92, 1.055 * pow(max(mapped, 1e-5), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, mapped)), 1.0);
}
