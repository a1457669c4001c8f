// One texture beyond its edges, with five samplers.
#version 450

layout(set = 0, binding = 0) uniform sampler2D pictures[5];
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec2 p = vec2(fract(uv.x * 5.0), uv.y) * 3.0 - 1.0;
  int cell = int(uv.x * 5.0);
  colour = vec4(0.0);
  if (cell == 0) colour = textureLod(pictures[0], p, 0.0);
  if (cell == 1) colour = textureLod(pictures[1], p, 0.0);
  if (cell == 2) colour = textureLod(pictures[2], p, 0.0);
  if (cell == 3) colour = textureLod(pictures[3], p, 0.0);
  if (cell == 4) colour = textureLod(pictures[4], p, 0.0);
}
