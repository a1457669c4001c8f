#version 450
#extension GL_GOOGLE_include_directive : require
#define real float
#include "suite_body.glsl"

layout(constant_id = 0) const int kScene = 0;
layout(location = 0) in vec4 varying_value;
layout(location = 0) out vec4 colour;

void main() { colour = suite_colour(kScene, varying_value); }
