// Instances of one cube, each with its own place, size, turn (a unit quaternion) and colour.
#version 450

layout(set = 0, binding = 0) uniform View {
  mat4 view_projection;
  vec4 light_direction;  // towards the light
};
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 place_and_size;
layout(location = 3) in vec4 turn;
layout(location = 4) in vec4 instance_colour;
layout(location = 0) out vec3 colour;

vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }

void main() {
  vec3 world_normal = turned(normal);
  float sun = max(dot(world_normal, light_direction.xyz), 0.0);
  float sky = 0.5 + 0.5 * world_normal.y;
  colour = instance_colour.rgb * (0.25 + 0.3 * sky + 0.6 * sun);
  gl_Position = view_projection * vec4(place_and_size.xyz + place_and_size.w * turned(position), 1.0);
}
