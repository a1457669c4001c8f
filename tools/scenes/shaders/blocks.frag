// A quarter of the picture for each texture, from magnified to minified.
#version 450

layout(set = 0, binding = 0) uniform sampler2D pictures[4];
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec2 p = uv * (0.8 + 5.0 * uv.x * uv.y);
  vec4 top = uv.x < 0.5 ? texture(pictures[0], p) : texture(pictures[1], p);
  vec4 bottom = uv.x < 0.5 ? texture(pictures[2], p) : texture(pictures[3], p);
  colour = vec4((uv.y < 0.5 ? top : bottom).rgb, 1.0);
}
