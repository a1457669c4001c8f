#version 450
#extension GL_EXT_shader_explicit_arithmetic_types_float16 : require
// As measured.comp, in binary16: the operands and the result are binary16 values, kept as binary32.

layout(constant_id = 0) const uint kFunction = 0;
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) readonly buffer X { float x_in[]; };
layout(set = 0, binding = 1) readonly buffer Y { float y_in[]; };
layout(set = 0, binding = 2) readonly buffer Z { float z_in[]; };
layout(set = 0, binding = 3) writeonly buffer R { float r_out[]; };

float16_t measured(float16_t x, float16_t y, float16_t z) {
  switch (kFunction) {
    case 128: return sin(x);
    case 129: return cos(x);
    case 130: return tan(x);
    case 131: return asin(x);
    case 132: return acos(x);
    case 133: return atan(x);
    case 134: return sinh(x);
    case 135: return cosh(x);
    case 136: return tanh(x);
    case 137: return asinh(x);
    case 138: return acosh(x);
    case 139: return atanh(x);
    case 140: return exp(x);
    case 141: return exp2(x);
    case 142: return log(x);
    case 143: return log2(x);
    case 144: return sqrt(x);
    case 145: return inversesqrt(x);
    case 146: return fract(x);
    case 147: return floor(x);
    case 148: return roundEven(x);
    case 160: return x + y;
    case 161: return x - y;
    case 162: return x * y;
    case 163: return x / y;
    case 164: return mod(x, y);
    case 165: return pow(x, y);
    case 166: return atan(x, y);
    case 167: return min(x, y);
    case 168: return length(f16vec2(x, y));
    case 169: return dot(f16vec2(x, y), f16vec2(y, z));
    case 170: return fma(x, y, z);
    case 171: return mix(x, y, z);
  }
  return float16_t(0.0);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  r_out[i] = float(measured(float16_t(x_in[i]), float16_t(y_in[i]), float16_t(z_in[i])));
}
