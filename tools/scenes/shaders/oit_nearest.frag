#version 450

// k-buffer: a pixel keeps its four nearest fragments, whatever the order in which they come.
layout(location = 0) in vec4 colour;
layout(location = 1) flat in uint card;
layout(location = 0) out vec4 nothing;  // transparent: blending keeps what is there
layout(push_constant) uniform Size { uint width; };
layout(binding = 0) buffer Keys { uint keys[]; };  // four a pixel, nearest first: depth << 4 | card

void main() {
  nothing = vec4(colour.rgb, 0.0);
  uint first = 4u * (uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x));
  uint key = uint(gl_FragCoord.z * 1048575.0) << 4 | card;
  for (uint i = 0u; i < 4u; ++i) key = max(key, atomicMin(keys[first + i], key));
}
