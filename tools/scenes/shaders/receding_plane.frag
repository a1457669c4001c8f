// A plane up to its horizon.
#version 450

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  float depth = 1.0 / (uv.y + 0.01);
  colour = texture(picture, vec2((uv.x - 0.5) * depth * 2.0, depth));
}
