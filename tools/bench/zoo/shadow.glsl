#version 450
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

vec4 shade(vec2 uv) {
  vec4 p = view * vec4(uv * 2.0 - 1.0, 0.3, 1.0);
  vec2 at = p.xy / p.w * 0.5 + 0.5, texel = 1.0 / vec2(textureSize(picture, 0));
  float lit = 0.0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) lit += pixel(at + vec2(x, y) * texel).r < p.z / p.w ? 0.0 : 1.0;
  return vec4(tint.rgb * (0.2 + 0.8 * lit / 9.0), 1.0);
}
