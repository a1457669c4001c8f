// Colour grading: a picture through a table of colours.
#version 450

layout(set = 0, binding = 0) uniform sampler3D table;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() { colour = textureLod(table, vec3(uv, fract(uv.x * 7.0 + uv.y * 3.0)), 0.0); }
