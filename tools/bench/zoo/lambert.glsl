#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 n = normalize(vec3(uv * 2.0 - 1.0, 0.7));
  vec3 sum = vec3(0.05);
  for (int i = 0; i < 4; ++i) sum += max(dot(n, normalize(light[i].xyz)), 0.0) * light[i].w * tint.rgb;
  return vec4(sum, 1.0);
}
