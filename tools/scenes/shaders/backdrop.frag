// A studio backdrop: bright behind the subject, darker towards the edges and the floor.
#version 450

layout(push_constant) uniform Backdrop {
  vec4 centre_colour;
  vec4 edge_colour;
};
layout(location = 0) in vec2 position;
layout(location = 0) out vec4 colour;

void main() {
  vec2 offset = vec2(position.x * 0.75, position.y + 0.15);
  float distance = min(dot(offset, offset) * 0.6, 1.0);
  float weight = distance * (2.0 - distance);
  colour = vec4(mix(centre_colour.rgb, edge_colour.rgb, weight), 1.0);
}
