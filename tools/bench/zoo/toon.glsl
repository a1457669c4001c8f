#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec3 n = normalize(vec3(uv * 2.0 - 1.0, 0.5));
  float lit = dot(n, normalize(light[0].xyz));
  float band = lit > 0.8 ? 1.0 : lit > 0.4 ? 0.7 : lit > 0.1 ? 0.4 : 0.15;
  float rim = smoothstep(0.6, 0.8, 1.0 - n.z);
  return vec4(tint.rgb * band * (1.0 - rim), 1.0);
}
