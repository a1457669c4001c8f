#version 450

// k-buffer: a pixel keeps its four nearest fragments, whatever the order in which they come.
layout(location = 1) flat in uint card;
layout(push_constant) uniform Size { uint width; };
layout(binding = 0) buffer Keys { uint keys[]; };  // four a pixel, nearest first: depth << 4 | card

void main() {
  uint first = 4u * (uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x));
  uint key = uint(gl_FragCoord.z * 1048575.0) << 4 | card;
  for (uint i = 0u; i < 4u; ++i) key = max(key, atomicMin(keys[first + i], key));
}
