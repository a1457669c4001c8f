#version 450

layout(push_constant) uniform Cell { vec4 place; } cell;  // centre and half size, in clip coordinates

layout(location = 0) in vec3 position;  // of the cell: -1 to 1, and depth
layout(location = 1) in vec4 vertex_colour;
layout(location = 0) out vec4 colour;

void main() {
  colour = vertex_colour;
  gl_Position = vec4(cell.place.xy + position.xy * cell.place.zw, position.z, 1.0);
}
