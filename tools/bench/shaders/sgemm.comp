#version 450

// c = a * b, square matrices; each workgroup computes a 16x16 tile from tiles of a and b in shared memory.
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) readonly buffer A { float a[]; };
layout(set = 0, binding = 1) readonly buffer B { float b[]; };
layout(set = 0, binding = 2) writeonly buffer C { float c[]; };
layout(push_constant) uniform Size { uint size; };

shared float tile_a[16][16];
shared float tile_b[16][16];

void main() {
  uint x = gl_LocalInvocationID.x, y = gl_LocalInvocationID.y;
  uint row = gl_WorkGroupID.y * 16 + y, column = gl_WorkGroupID.x * 16 + x;
  float sum = 0.0;
  for (uint first = 0; first < size; first += 16) {
    tile_a[y][x] = a[row * size + first + x];
    tile_b[y][x] = b[(first + y) * size + column];
    barrier();
    for (uint k = 0; k < 16; ++k) sum += tile_a[y][k] * tile_b[k][x];
    barrier();
  }
  c[row * size + column] = sum;
}
