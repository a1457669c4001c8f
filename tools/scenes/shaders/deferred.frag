// What the lights need to know, in attachments of three formats.
#version 450

layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 surface;
layout(location = 3) flat in int cube;
layout(location = 0) out vec4 albedo;
layout(location = 1) out vec4 packed_normal;  // 10 bits a channel
layout(location = 2) out vec4 position;       // 16-bit floats

// Constants none of whose values lies halfway between two codes of the formats: rounding there would hang on the last bit.
void main() {
  bool dark = (int(floor(surface.x * 2.0)) + int(floor(surface.y * 2.0)) & 1) != 0;
  vec3 hue = vec3(0.41 + 0.5 * float(cube % 3) / 2.0, 0.41 + 0.5 * float(cube % 4) / 3.0, 0.41 + 0.5 * float(cube % 5) / 4.0);
  albedo = vec4(dark ? 0.53 * hue : hue, 1.0);
  packed_normal = vec4(normal * 0.5 + 0.5, 1.0);
  position = vec4(place, 1.0);
}
