#version 450

// Sorts a pixel's list and blends it from back to front.
layout(location = 0) out vec4 result;
layout(push_constant) uniform Size { uint width; };
layout(binding = 0) buffer Heads { uint heads[]; };
layout(binding = 1) buffer Nodes {
  uint count;
  uint words[];
} nodes;

const uint kMost = 12u;

void main() {
  uint colours[kMost];
  float depths[kMost];
  uint n = 0u;
  uint node = heads[uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x)];
  while (node != 0u && n < kMost) {
    float depth = uintBitsToFloat(nodes.words[3u * node - 2u]);
    uint at = n;
    while (at > 0u && depths[at - 1u] < depth) {  // farthest first
      depths[at] = depths[at - 1u];
      colours[at] = colours[at - 1u];
      --at;
    }
    depths[at] = depth;
    colours[at] = nodes.words[3u * node - 3u];
    ++n;
    node = nodes.words[3u * node - 1u];
  }
  vec3 sum = vec3(0.953, 0.957, 0.965);
  for (uint i = 0u; i < n; ++i) {
    vec4 c = unpackUnorm4x8(colours[i]);
    sum = mix(sum, c.rgb, c.a);
  }
  result = vec4(sum, 1.0);
}
