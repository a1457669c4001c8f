#version 450
#extension GL_GOOGLE_include_directive : require
#define real float
#include "suite_body.glsl"

layout(constant_id = 0) const int kScene = 0;
layout(location = 0) in vec4 place;
layout(location = 1) in vec4 data;
layout(location = 0) out vec4 varying_value;

void main() {
  gl_Position = suite_position(kScene, place, data);
  varying_value = suite_varying(kScene, place, data);
}
