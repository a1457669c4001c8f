// Two slanted planes that cross, larger than the viewport; each instance in a viewport of its own.
#version 450
#extension GL_ARB_shader_viewport_layer_array : require

layout(location = 0) out vec3 colour;

void main() {
  int corner = gl_VertexIndex % 6, plane = gl_VertexIndex / 6;
  float x = corner == 1 || corner >= 4 ? 1.0 : -1.0, y = corner == 2 || corner == 3 || corner == 5 ? 1.0 : -1.0;
  float tint = float(gl_InstanceIndex) / 15.0;
  colour = plane == 0 ? vec3(0.95, 0.3 + 0.4 * y, 0.2 + 0.6 * tint) : vec3(0.1 + 0.5 * tint, 0.4, 0.8 + 0.2 * x);
  gl_Position = plane == 0 ? vec4(1.25 * x, 0.7 * y, 0.5 + 0.4 * x, 1.0) : vec4(0.7 * x, 1.25 * y, 0.5 - 0.3 * x + 0.15 * y, 1.0);
  gl_ViewportIndex = gl_InstanceIndex;
}
