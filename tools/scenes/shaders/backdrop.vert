// One triangle that covers the screen; `position` runs from -1 to 1 on it.
#version 450

layout(location = 0) out vec2 position;

void main() {
  position = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
  gl_Position = vec4(position, 1.0, 1.0);
}
