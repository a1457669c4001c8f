#version 450
// As measured.comp, in binary64. An array holds the low words of half as many values, then their high words.

layout(constant_id = 0) const uint kFunction = 0;
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) readonly buffer X { uint x_bits[]; };
layout(set = 0, binding = 1) readonly buffer Y { uint y_bits[]; };
layout(set = 0, binding = 2) readonly buffer Z { uint z_bits[]; };
layout(set = 0, binding = 3) writeonly buffer R { uint r_bits[]; };

const uint kCount = 1u << 19;

double measured(double x, double y, double z) {
  switch (kFunction) {
    case 192: return sqrt(x);
    case 193: return inversesqrt(x);
    case 194: return fract(x);
    case 195: return floor(x);
    case 196: return roundEven(x);
    case 197: return double(float(x));
    case 208: return x + y;
    case 209: return x - y;
    case 210: return x * y;
    case 211: return x / y;
    case 212: return mod(x, y);
    case 213: return length(dvec2(x, y));
    case 214: return fma(x, y, z);
    case 215: return mix(x, y, z);
    case 216: return dot(dvec2(x, y), dvec2(y, z));
  }
  return 0.0;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= kCount) return;
  uvec2 r = unpackDouble2x32(measured(packDouble2x32(uvec2(x_bits[i], x_bits[i + kCount])),
                                      packDouble2x32(uvec2(y_bits[i], y_bits[i + kCount])),
                                      packDouble2x32(uvec2(z_bits[i], z_bits[i + kCount]))));
  r_bits[i] = r.x;
  r_bits[i + kCount] = r.y;
}
