#version 450
// Conversions of one number, and of one word.
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { uint words[]; };
layout(set = 0, binding = 1) writeonly buffer Out { uint results[]; };

const uint kOperations = 9;

void main() {
  uint i = gl_GlobalInvocationID.x, at = i * kOperations, word = words[i];
  float x = uintBitsToFloat(word);
  results[at + 0] = packUnorm4x8(vec4(x, 0.0, 0.0, 0.0));
  results[at + 1] = packSnorm4x8(vec4(x, 0.0, 0.0, 0.0));
  results[at + 2] = packUnorm2x16(vec2(x, 0.0));
  results[at + 3] = packSnorm2x16(vec2(x, 0.0));
  results[at + 4] = packHalf2x16(vec2(x, 0.0));
  results[at + 5] = floatBitsToUint(unpackUnorm4x8(word).x);
  results[at + 6] = floatBitsToUint(unpackSnorm4x8(word).x);
  results[at + 7] = floatBitsToUint(unpackHalf2x16(word).x);
  results[at + 8] = floatBitsToUint(unpackSnorm2x16(word).x);
}
