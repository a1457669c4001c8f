#version 450

// Inclusive prefix sums of blocks of 256 values (Hillis and Steele 1986).
layout(local_size_x = 256) in;
layout(set = 0, binding = 0) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 1) writeonly buffer Sums { uint sums[]; };

shared uint block[256];

void main() {
  uint lane = gl_LocalInvocationIndex, index = gl_GlobalInvocationID.x;
  uint sum = values[index];
  block[lane] = sum;
  barrier();
  for (uint step = 1; step < 256; step <<= 1) {
    uint before = lane >= step ? block[lane - step] : 0;
    barrier();
    sum += before;
    block[lane] = sum;
    barrier();
  }
  sums[index] = sum;
}
