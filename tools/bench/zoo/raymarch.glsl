#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 from = vec3(0, 0, -3), ray = normalize(vec3(uv * 2.0 - 1.0, 1.5));
  float far = 0.0;
  for (int i = 0; i < 48; ++i) {
    vec3 p = from + ray * far;
    vec3 q = abs(p) - 0.7;
    float box = length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0) - 0.1;
    float d = max(box, 0.9 - length(p));
    if (d < 1e-3) {
      vec3 n = normalize(sign(p) * step(q.yzx, q) * step(q.zxy, q) + 1e-3);
      return vec4(tint.rgb * (0.2 + 0.8 * max(dot(n, normalize(light[0].xyz)), 0.0)), 1.0);
    }
    far += d;
    if (far > 8.0) break;
  }
  return vec4(0.1, 0.1, 0.15, 1.0);
}
