// The shaders of the accuracy suite: one text for two compilers. Here it is GLSL (suite.vert, suite.frag); reference_shaders.cpp
// compiles it as C++ with `real` = double, which makes the truth. So: no swizzles, no qualifiers, and only constants that binary32
// holds exactly, for else the two programs would not be the same one.

const int kSceneEdges = 0, kScenePlane = 1, kSceneMarble = 2, kSceneGlass = 3, kSceneSpheres = 4;

// ---- vertices: `place` and `data` are the attributes -------------------------------------------------------------------------------

vec3 sphere_normal(vec4 data) {  // data: polar angle, azimuth
  return vec3(sin(data.x) * cos(data.y), cos(data.x), sin(data.x) * sin(data.y));
}

// Perspective from the origin along -z; near 1, far 16, depth 0 to 1.
vec4 project(vec3 eye) { return vec4(eye.x * 1.5, eye.y * 2.0, (eye.z * -16.0 - 16.0) * 0.0666656494140625, -eye.z); }

vec4 suite_position(int scene, vec4 place, vec4 data) {
  if (scene != kSceneSpheres) return place;
  vec3 normal = sphere_normal(data);
  return project(vec3(place.x + place.w * normal.x, place.y + place.w * normal.y, place.z + place.w * normal.z));
}

vec4 suite_varying(int scene, vec4 place, vec4 data) {
  if (scene != kSceneSpheres) return data;
  vec3 normal = sphere_normal(data);
  return vec4(normal.x, normal.y, normal.z, data.z);
}

// ---- fragments ---------------------------------------------------------------------------------------------------------------------

// Smooth stripes from additions and multiplications alone: a bump of height 1 in each unit interval.
real bump(real x) {
  real s = x - floor(x);
  return 16.0 * s * s * (1.0 - s) * (1.0 - s);
}

vec4 plane_colour(vec4 v) {
  real a = bump(v.x), b = bump(v.y);
  return vec4(0.25 + 0.5 * a, 0.125 + 0.75 * b, 0.25 + 0.5 * a * b, 1.0);
}

// Veins: every function whose algorithm PINEDA_PRECISION chooses.
vec4 marble_colour(vec4 v) {
  real x = v.x, y = v.y, turbulence = 0.0, weight = 0.5;
  for (int octave = 0; octave < 5; ++octave) {
    turbulence += weight * sin(x * 1.75 + 2.0 * cos(y * 1.25 + turbulence));
    x = x * 1.875 + 0.75;
    y = y * 1.9375 - 0.625;
    weight *= 0.5;
  }
  real vein = pow(abs(sin(3.0 * (v.x + turbulence))) + 0.0625, 0.375);
  real glow = exp(-2.0 * abs(v.y + 0.5 * turbulence)) + 0.125 * log2(2.0 + turbulence);
  real angle = atan(v.y + 0.5, v.x + 1.25);
  return vec4(vein, 0.5 * vein + 0.5 * glow, 0.25 + 0.25 * angle * glow + 0.125 * tanh(turbulence), 1.0);
}

vec4 sphere_colour(vec4 v) {
  vec3 normal = normalize(vec3(v.x, v.y, v.z));
  vec3 light = vec3(0.5, 0.625, 0.59765625);
  real diffuse = max(dot(normal, light), 0.0);
  real shine = pow(max(normal.z * 0.8125 + normal.y * 0.375 + normal.x * 0.4375, 0.0), 24.0);
  return vec4(0.0625 + diffuse * v.w + 0.5 * shine, 0.0625 + diffuse * 0.625 + 0.5 * shine, 0.125 + diffuse * (1.0 - v.w) + 0.5 * shine,
              1.0);
}

vec4 suite_colour(int scene, vec4 v) {
  if (scene == kScenePlane) return plane_colour(v);
  if (scene == kSceneMarble) return marble_colour(v);
  if (scene == kSceneSpheres) return sphere_colour(v);
  return v;  // edges: 1; glass: a colour and its opacity
}
