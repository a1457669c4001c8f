// A wall of turned cubes, from the indices alone.
#version 450

layout(location = 0) out vec3 place;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 surface;
layout(location = 3) flat out int cube;

const mat3 kTurn = mat3(2.0, 3.0, 6.0, 3.0, -6.0, 2.0, 6.0, 2.0, -3.0) / 7.0;  // orthonormal

void main() {
  int face = gl_VertexIndex / 6, corner = gl_VertexIndex % 6, axis = face % 3;
  surface = vec2(corner == 1 || corner >= 4 ? 1.0 : -1.0, corner == 2 || corner == 3 || corner == 5 ? 1.0 : -1.0);
  vec3 outward = vec3(0.0), position;
  outward[axis] = face < 3 ? -1.0 : 1.0;
  position = outward;
  position[(axis + 1) % 3] = surface.x;
  position[(axis + 2) % 3] = surface.y;
  cube = gl_InstanceIndex;
  vec3 centre = vec3(float(cube % 6) - 2.5, float(cube / 6) - 1.5, 0.2 * float(cube * 5 % 7));
  place = centre + 0.42 * (kTurn * position);
  normal = kTurn * outward;
  gl_Position = vec4(place.x / 3.2, place.y / 2.3, 0.6 - 0.2 * place.z, 1.0);
}
