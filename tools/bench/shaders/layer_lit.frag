#version 450

layout(push_constant) uniform Layer {
  vec4 layer_colour;
  float depth;
  float texture_scale;
};
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 result;

void main() {
  vec3 n = normalize(vec3(uv - 0.5, 1.0));
  vec3 v = normalize(vec3(0.5 - uv, 2.0));
  vec3 l = vec3(0.36, 0.48, 0.8);
  float sun = max(dot(n, l), 0.0);
  float highlight = max(dot(n, normalize(l + v)), 0.0);
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  result = vec4(layer_colour.rgb * (0.2 + 0.8 * sun) + highlight * 0.3, 1.0);
}
