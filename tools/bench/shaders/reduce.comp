#version 450

// The sum of each workgroup's values: a tree in shared memory.
layout(local_size_x = 256) in;
layout(set = 0, binding = 0) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 1) writeonly buffer Sums { uint sums[]; };
layout(push_constant) uniform Count { uint values_per_invocation; };

shared uint partial[256];

void main() {
  uint lane = gl_LocalInvocationIndex, first = gl_WorkGroupID.x * 256 * values_per_invocation + lane, sum = 0;
  for (uint i = 0; i < values_per_invocation; ++i) sum += values[first + i * 256];
  partial[lane] = sum;
  barrier();
  for (uint step = 128; step > 0; step >>= 1) {
    if (lane < step) partial[lane] += partial[lane + step];
    barrier();
  }
  if (lane == 0) sums[gl_WorkGroupID.x] = partial[0];
}
