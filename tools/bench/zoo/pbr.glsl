#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 p = vec3(uv * 4.0 - 2.0, 0.0), n = normalize(vec3(cos(uv.x * 9.0), sin(uv.y * 7.0), 3.0)), v = normalize(eye.xyz - p);
  vec3 albedo = pixel(uv).rgb * tint.rgb, sum = vec3(0.0);
  float rough = mix(0.1, 0.9, uv.x), metal = uv.y, a = rough * rough, k = (rough + 1.0) * (rough + 1.0) / 8.0;
  vec3 f0 = mix(vec3(0.04), albedo, metal);
  float nv = max(dot(n, v), 1e-4);
  for (int i = 0; i < 4; ++i) {
    vec3 l = normalize(light[i].xyz - p), h = normalize(l + v);
    float nl = max(dot(n, l), 0.0), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);
    float q = nh * nh * (a * a - 1.0) + 1.0, d = a * a / (3.14159265 * q * q);
    float g = nl / (nl * (1.0 - k) + k) * nv / (nv * (1.0 - k) + k);
    vec3 f = f0 + (1.0 - f0) * pow(1.0 - vh, 5.0);
    sum += ((1.0 - f) * (1.0 - metal) * albedo / 3.14159265 + d * g * f / (4.0 * nl * nv + 1e-4)) * light[i].w * nl;
  }
  return vec4(pow(sum / (sum + 1.0), vec3(1.0 / 2.2)), 1.0);
}
