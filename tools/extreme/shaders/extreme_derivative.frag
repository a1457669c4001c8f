#version 450
layout(location = 0) in vec4 varying_data;
layout(location = 0) out vec4 colour;
void main() { colour = vec4(dFdx(varying_data.x), dFdy(varying_data.y), varying_data.x, fwidth(varying_data.z)); }
