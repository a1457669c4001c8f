#version 450
// Not interpolated: colours stand for something, and infinity minus infinity would be NaN.
layout(location = 0) flat in vec4 stored;
layout(location = 0) out vec4 colour;
void main() { colour = stored; }
