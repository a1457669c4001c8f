#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 p = vec3(uv * 4.0 - 2.0, 0.0), n = normalize(vec3(sin(p.x * 3.0), cos(p.y * 3.0), 2.0)), sum = vec3(0.02);
  vec3 v = normalize(eye.xyz - p);
  for (int i = 0; i < 4; ++i) {
    vec3 to = light[i].xyz - p, l = normalize(to), h = normalize(l + v);
    float fade = light[i].w / (1.0 + dot(to, to));
    sum += fade * (tint.rgb * max(dot(n, l), 0.0) + pow(max(dot(n, h), 0.0), 32.0));
  }
  return vec4(sum, 1.0);
}
