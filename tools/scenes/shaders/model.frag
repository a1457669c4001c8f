// Directional light, sky and ground light, a soft highlight, in linear light. On the way out a square root stands for the sRGB curve: it
// is exact on every driver, unlike pow.
#version 450

layout(constant_id = 0) const bool kTextured = true;
layout(set = 0, binding = 0) uniform View {
  mat4 view_projection;
  vec4 eye;
  vec4 light_direction;
};
layout(set = 1, binding = 0) uniform sampler2D base_texture;
layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec3 to_eye;
layout(location = 2) in vec3 albedo;
layout(location = 3) in vec2 uv;
layout(location = 0) out vec4 result;

void main() {
  vec3 surface = albedo;
  if (kTextured) surface *= texture(base_texture, uv).rgb;
  vec3 n = normalize(gl_FrontFacing ? world_normal : -world_normal);
  vec3 v = normalize(to_eye);
  vec3 l = light_direction.xyz;
  float sun = max(dot(n, l), 0.0);
  vec3 ambient = mix(vec3(0.13, 0.115, 0.105), vec3(0.25, 0.285, 0.35), 0.5 + 0.5 * n.y);
  float fill = max(dot(n, v), 0.0) * 0.13;
  float highlight = max(dot(n, normalize(l + v)), 0.0);
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  vec3 light = ambient + vec3(0.98, 0.93, 0.84) * sun + fill;
  vec3 radiance = surface * light + 0.10 * highlight * sun;
  // Rolls bright colours off to white at 1.5 instead of cutting them (Reinhard et al. 2002, equation 4).
  vec3 mapped = radiance * (1.0 + radiance * (1.0 / 2.25)) / (1.0 + radiance);
  result = vec4(sqrt(mapped) * 1.08, 1.0);
}
