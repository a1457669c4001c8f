#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 t = pixel(uv * 2.0).xyz * 2.0 - 1.0;
  mat3 frame = mat3(normalize(view[0].xyz + 0.01), normalize(view[1].xyz + 0.02), normalize(view[2].xyz + 0.03));
  vec3 n = normalize(frame * t), l = normalize(light[1].xyz), r = reflect(-l, n);
  return vec4(pixel(uv).rgb * max(dot(n, l), 0.1) + pow(max(r.z, 0.0), 16.0) * 0.3, 1.0);
}
