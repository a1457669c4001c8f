#version 450

layout(location = 0) in vec4 colour;
layout(location = 1) flat in vec4 flat_colour;
layout(location = 0) out vec4 result;

void main() { result = vec4(mix(colour.rgb, flat_colour.rgb, 0.3), 1.0); }
