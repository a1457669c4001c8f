// What blits made: a mip chain at the left, a scaled and mirrored picture, one of another format, one of sRGB.
#version 450

layout(set = 0, binding = 0) uniform sampler2D pictures[4];
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec4 chain = texture(pictures[0], vec2(uv.x * 2.0, uv.y) * (0.5 + 16.0 * uv.y * uv.y));
  vec2 p = vec2(uv.x * 2.0 - 1.0, uv.y * 3.0);
  vec4 scaled = textureLod(pictures[1], p, 0.0);
  vec4 converted = textureLod(pictures[2], p, 0.0);
  vec4 encoded = textureLod(pictures[3], p, 0.0);
  vec4 right = uv.y < 1.0 / 3.0 ? scaled : uv.y < 2.0 / 3.0 ? converted : encoded;
  colour = vec4((uv.x < 0.5 ? chain : right).rgb, 1.0);
}
