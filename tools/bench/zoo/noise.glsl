#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  float sum = 0.0, weight = 0.5;
  vec2 p = uv * 8.0;
  for (int octave = 0; octave < 5; ++octave) {
    vec2 i = floor(p), f = fract(p), s = f * f * (3.0 - 2.0 * f);
    vec4 r = fract(sin(vec4(dot(i, vec2(127.1, 311.7)), dot(i + vec2(1, 0), vec2(127.1, 311.7)),
                            dot(i + vec2(0, 1), vec2(127.1, 311.7)), dot(i + 1.0, vec2(127.1, 311.7)))) * 43758.5453);
    sum += weight * mix(mix(r.x, r.y, s.x), mix(r.z, r.w, s.x), s.y);
    p = p * 2.03 + time.x;
    weight *= 0.5;
  }
  return vec4(mix(vec3(0.1, 0.2, 0.4), tint.rgb, sum), 1.0);
}
