#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec4 p = view * vec4(uv * 10.0 - 5.0, uv.x * 20.0, 1.0);
  float far = length(p.xyz), height = exp(-max(p.y, 0.0) * 0.3);
  float amount = 1.0 - exp(-far * 0.05 * height);
  vec3 sun = pow(max(dot(normalize(p.xyz), normalize(light[0].xyz)), 0.0), 8.0) * vec3(1.0, 0.7, 0.4);
  return vec4(mix(pixel(uv).rgb * tint.rgb, vec3(0.5, 0.6, 0.7) + sun, amount), 1.0);
}
