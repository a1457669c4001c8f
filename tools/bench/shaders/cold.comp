// A small but not trivial kernel: some arithmetic, a loop, a store.
#version 450

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kFresh = 1;
layout(set = 0, binding = 0) writeonly buffer Results { uint results[]; };

void main() {
  uint lane = gl_LocalInvocationID.x;
  float x = float(lane);
  for (uint i = 0; i < 8; ++i) x = x * 1.25 - sqrt(x + float(i));
  results[lane] = lane == 0 ? kFresh : floatBitsToUint(x) + kFresh;
}
