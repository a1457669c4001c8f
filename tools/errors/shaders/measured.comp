#version 450
// One function of up to three operands on arrays; the function is a specialization constant, so that every driver compiles just
// that one. The numbers are those of kFunctions in functions.cpp.

layout(constant_id = 0) const uint kFunction = 0;
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) readonly buffer X { uint x_bits[]; };
layout(set = 0, binding = 1) readonly buffer Y { uint y_bits[]; };
layout(set = 0, binding = 2) readonly buffer Z { uint z_bits[]; };
layout(set = 0, binding = 3) writeonly buffer R { uint r_bits[]; };

float unary(float x) {
  int exponent;
  float whole;
  switch (kFunction) {
    case 0: return sin(x);
    case 1: return cos(x);
    case 2: return tan(x);
    case 3: return asin(x);
    case 4: return acos(x);
    case 5: return atan(x);
    case 6: return sinh(x);
    case 7: return cosh(x);
    case 8: return tanh(x);
    case 9: return asinh(x);
    case 10: return acosh(x);
    case 11: return atanh(x);
    case 12: return exp(x);
    case 13: return exp2(x);
    case 14: return log(x);
    case 15: return log2(x);
    case 16: return sqrt(x);
    case 17: return inversesqrt(x);
    case 18: return radians(x);
    case 19: return degrees(x);
    case 20: return fract(x);
    case 21: return floor(x);
    case 22: return ceil(x);
    case 23: return trunc(x);
    case 24: return roundEven(x);
    case 25: return sign(x);
    case 26: return modf(x, whole);
    case 27: return frexp(x, exponent);
    case 28: frexp(x, exponent); return float(exponent);
  }
  return 0.0;
}

float several(float x, float y, float z) {
  switch (kFunction) {
    case 32: return x + y;
    case 33: return x - y;
    case 34: return x * y;
    case 35: return x / y;
    case 36: return mod(x, y);
    case 37: return pow(x, y);
    case 38: return atan(x, y);
    case 39: return ldexp(x, int(y));
    case 40: return min(x, y);
    case 41: return max(x, y);
    case 42: return step(x, y);
    case 43: return length(vec2(x, y));
    case 44: return normalize(vec2(x, y)).x;
    case 64: return fma(x, y, z);
    case 65: return clamp(x, min(y, z), max(y, z));
    case 66: return mix(x, y, z);
    case 67: return smoothstep(min(x, y), max(x, y), z);
    case 68: return length(vec3(x, y, z));
    case 69: return dot(vec3(x, y, z), vec3(y, z, x));
    case 70: return cross(vec3(x, y, z), vec3(y, z, x)).x;
    case 71: return determinant(mat2(x, y, z, x));
  }
  return 0.0;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  float x = uintBitsToFloat(x_bits[i]);
  if (kFunction < 32) r_bits[i] = floatBitsToUint(unary(x));
  else if (kFunction < 64) r_bits[i] = floatBitsToUint(several(x, uintBitsToFloat(y_bits[i]), 0.0));
  else r_bits[i] = floatBitsToUint(several(x, uintBitsToFloat(y_bits[i]), uintBitsToFloat(z_bits[i])));
}
