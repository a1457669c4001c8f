#version 450
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { float places[]; };
layout(set = 0, binding = 1) writeonly buffer Out { float texels[]; };
layout(set = 0, binding = 2) uniform sampler2D numbered;
void main() {
  uint i = gl_GlobalInvocationID.x;
  texels[i] = textureLod(numbered, vec2(places[i], 0.5), 0.0).x;
}
