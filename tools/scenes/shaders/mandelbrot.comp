// The Mandelbrot set: iterations with a continuous count, so that the colour has no steps, packed to RGBA8.
// The iteration is chaotic near the set: one rounding more or less ends in another colour (a fused multiply-add alone changes 0.2 % of
// the pixels). It is `precise` (NoContraction), which leaves no choice of roundings to a driver.
#version 450

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) writeonly buffer Pixels { uint pixels[]; };
layout(push_constant) uniform Window {
  vec2 corner;  // of pixel (0, 0), in the complex plane
  vec2 step;
  uvec2 size;
  uint max_iterations;
};

// log2 from the bits of a float and a polynomial on the mantissa (largest error 2e-4): the same plain operations on every driver.
float plain_log2(float x) {
  uint bits = floatBitsToUint(x);
  float exponent = float(int(bits >> 23) - 127);
  float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u) - 1.0;
  return exponent + m * (1.4385468 + m * (-0.6793298 + m * (0.3236529 - 0.0828699 * m)));
}

vec3 palette(float t) {
  float position = fract(t) * 5.0;
  vec3 colour = mix(vec3(0.03, 0.05, 0.16), vec3(0.10, 0.32, 0.66), clamp(position, 0.0, 1.0));
  colour = mix(colour, vec3(0.80, 0.93, 0.97), clamp(position - 1.0, 0.0, 1.0));
  colour = mix(colour, vec3(0.99, 0.78, 0.32), clamp(position - 2.0, 0.0, 1.0));
  colour = mix(colour, vec3(0.72, 0.24, 0.16), clamp(position - 3.0, 0.0, 1.0));
  return mix(colour, vec3(0.03, 0.05, 0.16), clamp(position - 4.0, 0.0, 1.0));
}

void main() {
  uvec2 at = gl_GlobalInvocationID.xy;
  if (at.x >= size.x || at.y >= size.y) return;
  precise vec2 c = corner + step * vec2(at);
  precise vec2 z = vec2(0.0);
  uint count = 0;
  precise float squared = 0.0;
  while (count < max_iterations && squared < 4096.0) {
    z = vec2(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y) + c;
    squared = z.x * z.x + z.y * z.y;
    ++count;
  }
  vec3 colour = vec3(0.01, 0.01, 0.03);
  if (squared >= 4096.0) {
    float smooth_count = float(count) - plain_log2(plain_log2(squared) / 12.0);
    colour = palette(0.33 * sqrt(max(smooth_count, 0.0)) - 0.55);
  }
  uvec3 bytes = uvec3(colour * 255.0 + 0.5);
  pixels[at.y * size.x + at.x] = bytes.r | bytes.g << 8 | bytes.b << 16 | 0xff000000u;
}
