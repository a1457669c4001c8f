#version 450

// 20 turns of four transcendental functions; the map contracts, so that small errors stay small.
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) buffer X { float x[]; };
layout(push_constant) uniform Turns { uint turns; };

void main() {
  float v = float(gl_GlobalInvocationID.x) * (1.0 / 65536.0) - 8.0;
  for (uint i = 0; i < turns; ++i) v = 0.25 * (sin(v) + cos(v) + exp2(-v * v)) + 0.1 * log2(1.5 + v * v);
  x[gl_GlobalInvocationID.x] = v;
}
