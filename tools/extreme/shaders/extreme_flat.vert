#version 450
layout(location = 0) in vec4 place;
layout(location = 1) in vec4 data;
layout(location = 0) out vec4 varying_data;
void main() {
  gl_Position = place;
  varying_data = data;
}
