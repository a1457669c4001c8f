#version 450

layout(push_constant) uniform Layer {
  vec4 layer_colour;
  float depth;
  float texture_scale;
};
layout(location = 0) out vec4 result;

void main() { result = layer_colour; }
