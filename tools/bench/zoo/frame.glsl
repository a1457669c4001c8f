// What the shaders of this folder share: each defines shade(uv), the colour at a place of the picture. Compiled twice, as a fragment
// shader and (COMPUTE) as a compute shader that writes the same colours to a buffer.

layout(set = 0, binding = 0) uniform Scene {
  mat4 view;
  vec4 eye, light[4], tint, time;  // time.x in seconds
};
layout(set = 0, binding = 1) uniform sampler2D picture;

vec4 shade(vec2 uv);

#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 2) buffer Colours { vec4 colours[]; };
void main() {
  uvec2 size = gl_NumWorkGroups.xy * gl_WorkGroupSize.xy, at = gl_GlobalInvocationID.xy;
  colours[at.y * size.x + at.x] = shade((vec2(at) + 0.5) / vec2(size));
}
vec4 pixel(vec2 uv) { return textureLod(picture, uv, 0.0); }
#else
layout(location = 0) in vec2 place;
layout(location = 0) out vec4 colour;
void main() { colour = shade(place); }
vec4 pixel(vec2 uv) { return texture(picture, uv); }
#endif
