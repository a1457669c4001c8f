#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec2 slope = vec2(0.0);
  for (int i = 0; i < 6; ++i) {
    vec2 d = normalize(light[i & 3].xy + float(i));
    float f = exp2(float(i) * 0.5) * 3.0;
    slope += d * cos(dot(uv, d) * f + time.x * sqrt(f)) / f;
  }
  vec3 n = normalize(vec3(-slope, 1.0)), v = normalize(vec3(uv - 0.5, -1.0));
  float fresnel = 0.02 + 0.98 * pow(1.0 - abs(dot(n, v)), 5.0);
  return vec4(mix(vec3(0.0, 0.1, 0.2), pixel(refract(v, n, 0.75).xy * 0.2 + uv).rgb, fresnel), 1.0);
}
