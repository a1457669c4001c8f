#version 450
// Every operation on every pair of operands; integers.cpp has the same table.
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { uvec2 operands[]; };
layout(set = 0, binding = 1) writeonly buffer Out { uint results[]; };

const uint kOperations = 20;

void main() {
  uint i = gl_GlobalInvocationID.x, at = i * kOperations;
  uint a = operands[i].x, b = operands[i].y;
  int sa = int(a), sb = int(b);
  results[at + 0] = a + b;
  results[at + 1] = a - b;
  results[at + 2] = a * b;
  results[at + 3] = uint(-sa);
  results[at + 4] = uint(abs(sa));
  results[at + 5] = uint(sign(sa));
  uint carry, high, low;
  results[at + 6] = uaddCarry(a, b, carry) + carry;
  umulExtended(a, b, high, low);
  results[at + 7] = high;
  int signed_high, signed_low;
  imulExtended(sa, sb, signed_high, signed_low);
  results[at + 8] = uint(signed_high);
  results[at + 9] = uint(findMSB(a));
  results[at + 10] = uint(findMSB(sa));
  results[at + 11] = uint(findLSB(a));
  results[at + 12] = uint(bitCount(a));
  results[at + 13] = bitfieldReverse(a);
  results[at + 14] = a >> (b & 31u);
  results[at + 15] = uint(sa >> int(b & 31u));
  results[at + 16] = uint(bitfieldExtract(sa, int(b & 15u), 0));
  results[at + 17] = bitfieldInsert(a, b, 0, 32);
  results[at + 18] = floatBitsToUint(float(sa));
  results[at + 19] = floatBitsToUint(float(a));
}
