#version 450
#extension GL_GOOGLE_include_directive : require
#define real double
#include "extreme_stiff.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0) readonly buffer In { double parameters[2]; int tasks[]; };
layout(set = 0, binding = 1) writeonly buffer Out { double results[]; };

void main() { results[gl_GlobalInvocationID.x] = double(stiff_task(tasks[gl_GlobalInvocationID.x], parameters[0], parameters[1])); }
