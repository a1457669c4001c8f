#version 450

layout(location = 0) out vec4 result;
layout(push_constant) uniform Size { uint width; };
layout(binding = 0) buffer Keys { uint keys[]; };

const vec3 kHues[12] = vec3[](vec3(0.93, 0.26, 0.27), vec3(0.96, 0.47, 0.20), vec3(0.98, 0.69, 0.19), vec3(0.86, 0.84, 0.24),
                              vec3(0.50, 0.80, 0.33), vec3(0.20, 0.73, 0.49), vec3(0.13, 0.71, 0.71), vec3(0.20, 0.58, 0.86),
                              vec3(0.30, 0.43, 0.90), vec3(0.48, 0.35, 0.88), vec3(0.69, 0.32, 0.80), vec3(0.88, 0.29, 0.56));

void main() {
  uint first = 4u * (uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x));
  vec3 sum = vec3(0.953, 0.957, 0.965);
  for (int i = 3; i >= 0; --i) {
    uint key = keys[first + uint(i)];
    if (key != 0xFFFFFFFFu) sum = mix(sum, kHues[min(key & 15u, 11u)], 0.6);
  }
  result = vec4(sum, 1.0);
}
