#version 450
// What SPIR-V leaves undefined for some operands, beside a number that it does not: b * 3 + a.
layout(local_size_x = 16) in;
layout(set = 0, binding = 0) readonly buffer In { uvec2 operands[]; };
layout(set = 0, binding = 1) writeonly buffer Out { uint results[]; };

const uint kOperations = 10;

void main() {
  uint i = gl_GlobalInvocationID.x, at = i * kOperations;
  uint a = operands[i].x, b = operands[i].y;
  int sa = int(a), sb = int(b);
  results[at + 0] = b * 3u + a;
  results[at + 1] = a / b;
  results[at + 2] = a % b;
  results[at + 3] = uint(sa / sb);
  results[at + 4] = uint(sa % sb);
  results[at + 5] = a << b;
  results[at + 6] = a >> b;
  results[at + 7] = uint(sa >> sb);
  results[at + 8] = uint(int(uintBitsToFloat(a)));
  results[at + 9] = uint(uintBitsToFloat(a));
}
