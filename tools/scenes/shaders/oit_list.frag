#version 450

// A-buffer: every fragment becomes a node of its pixel's list.
layout(location = 0) in vec4 colour;
layout(location = 0) out vec4 nothing;  // transparent: blending keeps what is there
layout(push_constant) uniform Size { uint width; };
layout(binding = 0) buffer Heads { uint heads[]; };  // 1 + index of the first node; 0: none
layout(binding = 1) buffer Nodes {
  uint count;
  uint words[];  // colour, depth, next
} nodes;

void main() {
  nothing = vec4(colour.rgb, 0.0);
  uint node = atomicAdd(nodes.count, 1u);
  if (3u * node + 2u >= uint(nodes.words.length())) return;
  uint pixel = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
  nodes.words[3u * node] = packUnorm4x8(colour);
  nodes.words[3u * node + 1u] = floatBitsToUint(gl_FragCoord.z);
  nodes.words[3u * node + 2u] = atomicExchange(heads[pixel], node + 1u);
}
