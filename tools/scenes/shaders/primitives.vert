#version 450

layout(push_constant) uniform Cell { vec4 place; } cell;  // centre and half size, in clip coordinates

layout(location = 0) in vec2 position;  // of the cell: -1 to 1
layout(location = 1) in vec4 vertex_colour;
layout(location = 0) out vec4 colour;
layout(location = 1) flat out vec4 flat_colour;

void main() {
  colour = vertex_colour;
  flat_colour = vertex_colour;
  gl_Position = vec4(cell.place.xy + position * cell.place.zw, 0.5, 1.0);
  gl_PointSize = 1.0 + 12.0 * vertex_colour.a;
  gl_ClipDistance[0] = 1.1 - dot(position, position);  // a circle, cut at the triangles' sides
}
