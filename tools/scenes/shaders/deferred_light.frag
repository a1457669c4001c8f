// Four lights, from the attachments of the subpass before.
#version 450

layout(input_attachment_index = 0, set = 0, binding = 0) uniform subpassInput albedo;
layout(input_attachment_index = 1, set = 0, binding = 1) uniform subpassInput packed_normal;
layout(input_attachment_index = 2, set = 0, binding = 2) uniform subpassInput position;
layout(location = 0) out vec4 result;

const vec4 kLights[4] = vec4[](vec4(-2.0, -1.0, 2.2, 1.6), vec4(2.2, 1.2, 2.4, 1.8), vec4(0.0, -1.8, 1.6, 1.0), vec4(-1.6, 1.6, 1.8, 0.9));
const vec3 kColours[4] = vec3[](vec3(1.0, 0.8, 0.6), vec3(0.6, 0.8, 1.0), vec3(1.0, 0.4, 0.5), vec3(0.5, 1.0, 0.6));

void main() {
  vec4 surface = subpassLoad(albedo);
  vec3 normal = subpassLoad(packed_normal).xyz * 2.0 - 1.0, place = subpassLoad(position).xyz;
  vec3 light = vec3(0.12);
  for (int i = 0; i < 4; ++i) {
    vec3 way = kLights[i].xyz - place;
    float squared = dot(way, way);
    light += kColours[i] * kLights[i].w * abs(dot(normal, way)) / (sqrt(squared) * (0.4 + squared));
  }
  result = vec4(surface.a == 0.0 ? vec3(0.08, 0.09, 0.12) : surface.rgb * light, 1.0);
}
