#version 450
#extension GL_EXT_spirv_intrinsics : require
// One function of up to three operands on arrays; the function is a specialization constant, so that every driver compiles just
// that one. The numbers are those of kFunctions in functions.cpp.

layout(constant_id = 0) const uint kFunction = 0;
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) readonly buffer X { uint x_bits[]; };
layout(set = 0, binding = 1) readonly buffer Y { uint y_bits[]; };
layout(set = 0, binding = 2) readonly buffer Z { uint z_bits[]; };
layout(set = 0, binding = 3) writeonly buffer R { uint r_bits[]; };

// What GLSL has no name for.
spirv_instruction(id = 140) float f_rem(float x, float y);
spirv_instruction(id = 116) float quantize_to_f16(float x);
spirv_instruction(set = "GLSL.std.450", id = 79) float n_min(float x, float y);
spirv_instruction(set = "GLSL.std.450", id = 80) float n_max(float x, float y);
spirv_instruction(set = "GLSL.std.450", id = 81) float n_clamp(float x, float low, float high);

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
    case 29: return abs(x);
    case 30: return -x;
    case 31: return round(x);
  }
  return 0.0;
}

float conversion(float x) {
  uint bits = floatBitsToUint(x);
  switch (kFunction) {
    case 96: return float(packUnorm4x8(vec4(x)) & 255u);
    case 97: return float(bitfieldExtract(int(packSnorm4x8(vec4(x))), 8, 8));
    case 98: return float(packUnorm2x16(vec2(x)) >> 16);
    case 99: return float(bitfieldExtract(int(packSnorm2x16(vec2(x))), 0, 16));
    case 100: return unpackUnorm4x8(bits).y;
    case 101: return unpackSnorm4x8(bits).z;
    case 102: return unpackUnorm2x16(bits).x;
    case 103: return unpackSnorm2x16(bits).y;
    case 104: return unpackHalf2x16(bits).y;
    case 105: return unpackHalf2x16(packHalf2x16(vec2(x, 0.0))).x;
    case 106: return quantize_to_f16(x);
    case 107: return float(int(bits));
    case 108: return float(bits);
    case 109: return float(int(x));
    case 110: return float(uint(x));
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
    case 45: return f_rem(x, y);
    case 46: return n_min(x, y);
    case 47: return n_max(x, y);
    case 64: return fma(x, y, z);
    case 65: return clamp(x, min(y, z), max(y, z));
    case 66: return mix(x, y, z);
    case 67: return smoothstep(min(x, y), max(x, y), z);
    case 68: return length(vec3(x, y, z));
    case 69: return dot(vec3(x, y, z), vec3(y, z, x));
    case 70: return cross(vec3(x, y, z), vec3(y, z, x)).x;
    case 71: return determinant(mat2(x, y, z, x));
    case 72: return distance(vec3(x, y, z), vec3(y, z, x));
    case 73: return normalize(vec3(x, y, z)).x;
    case 74: return faceforward(vec2(x, y), vec2(y, z), vec2(z, x)).x;
    case 75: return reflect(vec2(x, y), vec2(y, z)).x;
    case 76: return refract(vec2(x, y), vec2(y, z), z).x;
    case 77: return n_clamp(x, min(y, z), max(y, z));
    case 78: return (mat2(x, y, z, x) * vec2(y, z)).x;
    case 79: return determinant(mat3(x, y, z, y, z, x, 1.0, x, y));
    case 80: return determinant(mat4(x, y, z, 1.0, y, z, x, 2.0, z, 1.0, y, x, 1.0, x, 2.0, y));
    case 81: return inverse(mat2(x, y, z, x))[0][0];
    case 82: return inverse(mat3(x, y, z, y, z, x, 1.0, x, y))[0][0];
  }
  return 0.0;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  float x = uintBitsToFloat(x_bits[i]);
  if (kFunction < 32) r_bits[i] = floatBitsToUint(unary(x));
  else if (kFunction >= 96) r_bits[i] = floatBitsToUint(conversion(x));
  else if (kFunction < 64) r_bits[i] = floatBitsToUint(several(x, uintBitsToFloat(y_bits[i]), 0.0));
  else r_bits[i] = floatBitsToUint(several(x, uintBitsToFloat(y_bits[i]), uintBitsToFloat(z_bits[i])));
}
