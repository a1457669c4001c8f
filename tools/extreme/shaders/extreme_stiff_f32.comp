#version 450
#extension GL_GOOGLE_include_directive : require
#define real float
#include "extreme_stiff.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { float parameters[2]; int tasks[]; };
layout(set = 0, binding = 1) writeonly buffer Out { float results[]; };

void main() { results[gl_GlobalInvocationID.x] = float(stiff_task(tasks[gl_GlobalInvocationID.x], parameters[0], parameters[1])); }
