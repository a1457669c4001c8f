#version 450

// Counts of the low eight bits: atomics in shared memory, one global atomic a bin and workgroup.
layout(local_size_x = 256) in;
layout(set = 0, binding = 0) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 1) buffer Bins { uint bins[256]; };
layout(push_constant) uniform Count { uint values_per_invocation; };

shared uint local_bins[256];

void main() {
  uint lane = gl_LocalInvocationIndex, first = gl_WorkGroupID.x * 256 * values_per_invocation + lane;
  local_bins[lane] = 0;
  barrier();
  for (uint i = 0; i < values_per_invocation; ++i) atomicAdd(local_bins[values[first + i * 256] & 255], 1);
  barrier();
  atomicAdd(bins[lane], local_bins[lane]);
}
