#version 450

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 vertex_colour;
layout(location = 2) in uint vertex_card;
layout(location = 0) out vec4 colour;
layout(location = 1) flat out uint card;

void main() {
  colour = vertex_colour;
  card = vertex_card;
  gl_Position = vec4(position, 1.0);
}
