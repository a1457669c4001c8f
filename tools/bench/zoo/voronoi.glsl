#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec2 p = uv * 6.0, cell = floor(p);
  float nearest = 8.0, second = 8.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      uvec2 c = uvec2(ivec2(cell) + ivec2(x, y) + 1000);
      uint h = (c.x * 1664525u + 1013904223u) ^ (c.y * 22695477u + 1u);
      h ^= h >> 15;
      h *= 2246822519u;
      vec2 q = vec2(x, y) + vec2(h & 0xffffu, h >> 16) / 65535.0 - fract(p);
      float d = dot(q, q);
      if (d < nearest) { second = nearest; nearest = d; } else second = min(second, d);
    }
  }
  return vec4(tint.rgb * smoothstep(0.0, 0.1, sqrt(second) - sqrt(nearest)), 1.0);
}
