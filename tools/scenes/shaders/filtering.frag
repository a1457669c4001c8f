// From a magnified texture at the left to its smallest levels at the right.
#version 450

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  float zoom = uv.x * uv.x * uv.x * 24.0;
  colour = texture(picture, vec2(uv.x * 0.1 + zoom, (uv.y - 0.5) * (0.1 + zoom)));
}
