// A quad over the whole target, without vertex buffers.
#version 450

layout(push_constant) uniform Layer {
  vec4 layer_colour;
  float depth;
  float texture_scale;
};
layout(location = 0) out vec2 uv;

void main() {
  bool right = gl_VertexIndex == 1 || gl_VertexIndex == 2 || gl_VertexIndex == 4;
  bool bottom = gl_VertexIndex == 2 || gl_VertexIndex == 4 || gl_VertexIndex == 5;
  vec2 corner = vec2(right ? 1.0 : 0.0, bottom ? 1.0 : 0.0);
  uv = corner * texture_scale;
  gl_Position = vec4(2.0 * corner - 1.0, depth, 1.0);
}
