#version 450
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { uint unused[]; };
layout(set = 0, binding = 1) writeonly buffer Out { float linear[]; };
layout(set = 0, binding = 2) uniform sampler2D codes;
void main() {
  uint i = gl_GlobalInvocationID.x;
  linear[i] = texelFetch(codes, ivec2(i, 0), 0).x;
}
