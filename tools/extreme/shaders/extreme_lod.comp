#version 450
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { vec4 gradients[]; };
layout(set = 0, binding = 1) writeonly buffer Out { float levels[]; };
layout(set = 0, binding = 2) uniform sampler2D numbered;
void main() {
  uint i = gl_GlobalInvocationID.x;
  levels[i] = textureGrad(numbered, vec2(0.5), gradients[i].xy, gradients[i].zw).x;
}
