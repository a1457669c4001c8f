// The four texels of each footprint, plain and moved.
#version 450

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  vec2 p = uv * 1.5 - 0.25;
  vec4 red = textureGather(picture, p, 0), green = textureGatherOffset(picture, p, ivec2(-3, 2), 1);
  vec4 blue = textureGather(picture, p * 2.0, 2);
  colour = vec4(dot(red, vec4(0.4, 0.3, 0.2, 0.1)), dot(green, vec4(0.1, 0.2, 0.3, 0.4)), dot(blue, vec4(0.25)), 1.0);
}
