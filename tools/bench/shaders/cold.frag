// One directional light, and a constant that no cache has seen.
#version 450

layout(constant_id = 0) const uint kFresh = 1;
layout(location = 0) in vec3 normal;
layout(location = 0) out vec4 result;

void main() {
  float fresh = float(kFresh & 0xffffffu) / 16777216.0;
  vec3 n = normalize(normal);
  float sun = max(dot(n, vec3(0.36, 0.48, 0.8)), 0.0);
  result = vec4(vec3(0.2 + fresh * 0.5, 0.3, 0.4) * (0.3 + 0.7 * sun), 1.0);
}
