// Nine taps of a Gauss filter.
#version 450

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
  const float kWeight[5] = float[](0.227027, 0.194594, 0.121622, 0.054054, 0.016216);
  vec2 step = vec2(1.0 / 1024.0, 0.0);
  vec4 sum = texture(picture, uv) * kWeight[0];
  for (int i = 1; i < 5; ++i) {
    sum += (texture(picture, uv + step * float(i)) + texture(picture, uv - step * float(i))) * kWeight[i];
  }
  colour = sum;
}
