#include "tools/scene_registry.h"

#include <filesystem>
#include <string_view>

#include "tools/bench/bench_scenes.h"
#include "tools/error.h"
#include "tools/scenes/sampling.h"
#include "tools/scenes/scenes.h"
#include "tools/scenes/states.h"

namespace pineda::tools {
namespace {

#define PINEDA_ASSIMP_MODELS "/usr/share/assimp/models/"  // Debian: assimp-testmodels

constexpr SceneInfo kScenes[] = {
    {"triangle", "Triangle", "One triangle, a colour at each corner", make_triangle_scene, nullptr},
    {"blend", "Blending", "Overlapping translucent quads", make_blend_scene, nullptr},
    {"cubes", "Cubes", "1,000 instanced cubes with depth", make_cubes_scene, nullptr},
    {"oit-lists", "A-buffer", "Order-independent transparency: lists of fragments by atomics, sorted for each pixel",
     [] { return make_oit_scene(OitKind::kABuffer); }, nullptr},
    {"oit-nearest", "k-buffer", "Order-independent transparency: the four nearest fragments of each pixel, by atomic minima",
     [] { return make_oit_scene(OitKind::kKBuffer); }, nullptr},
    {"cubes-4x", "Cubes, 4 samples", "The same, with 4 samples a pixel", [] { return with_samples(make_cubes_scene(), 4); },
     nullptr},
    {"blend-4x", "Blending, 4 samples", "Overlapping translucent quads, with 4 samples a pixel",
     [] { return with_samples(make_blend_scene(), 4); }, nullptr},
    {"engine-4x", "Two-cylinder engine, 4 samples", "The engine, with 4 samples a pixel",
     [] {
       return with_samples(make_model_scene(PINEDA_ASSIMP_MODELS "glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb"), 4);
     },
     nullptr},
    {"primitives", "Primitives", "Points, lines, strips, fans, polygon modes and a clip distance", make_primitives_scene,
     nullptr},
    {"blend-modes", "Blend modes", "Every factor and operation, a cell each",
     [] { return make_states_scene(StatesKind::kBlendModes); }, nullptr},
    {"stencil", "Stencil", "An outline, parity, overlaps counted, a hole", [] { return make_states_scene(StatesKind::kStencil); },
     nullptr},
    {"stencil-4x", "Stencil, 4 samples", "The same, with 4 samples a pixel",
     [] { return with_samples(make_states_scene(StatesKind::kStencil), 4); }, nullptr},
    {"depth-bias", "Depth bias", "A plane and its decal under constant and slope biases",
     [] { return make_states_scene(StatesKind::kDepthBias); }, nullptr},
    {"depth-bias-d16", "Depth bias, 16 bits", "The same, with D16 as depth format",
     [] { return with_depth_format(make_states_scene(StatesKind::kDepthBias), VK_FORMAT_D16_UNORM); }, nullptr},
    {"depth-bias-d24", "Depth bias, 24 bits", "The same, with X8_D24 as depth format",
     [] { return with_depth_format(make_states_scene(StatesKind::kDepthBias), VK_FORMAT_X8_D24_UNORM_PACK32); }, nullptr},
    {"viewports", "Viewports", "Sixteen, chosen by the vertex shader: upside down, reversed depth, scissors",
     make_viewports_scene, nullptr},
    {"deferred", "Deferred shading", "Three attachments of different formats, then lights from input attachments",
     make_deferred_scene, nullptr},
    {"line-modes", "Line modes", "Rectangular, Bresenham and smooth lines: thin, wide, stippled",
     [] { return make_states_scene(StatesKind::kLineModes); }, nullptr, 0.97},
    {"restart", "Primitive restart", "Strips and fans of triangles, strips of lines",
     [] { return make_states_scene(StatesKind::kRestart); }, nullptr},
    {"mandelbrot", "Mandelbrot", "Compute shader into a storage buffer", make_mandelbrot_scene, nullptr},
    {"filtering", "Filtering", "A texture from magnified to its smallest level, trilinear",
     [] { return make_sampling_scene(SamplingKind::kFiltering); }, nullptr, 0.7},
    {"receding-plane", "Receding plane", "A plane up to its horizon, anisotropic 16",
     [] { return make_sampling_scene(SamplingKind::kRecedingPlane); }, nullptr, 0.65},
    {"cube-seams", "Cube seams", "Edges and a corner of a cube map of 4x4 texels",
     [] { return make_sampling_scene(SamplingKind::kCubeSeams); }, nullptr},
    {"borders", "Borders", "A texture beyond its edges: address modes and border colours",
     [] { return make_sampling_scene(SamplingKind::kBorders); }, nullptr},
    {"volume", "Volume", "Slanted cuts through a 3D texture", [] { return make_sampling_scene(SamplingKind::kVolume); }, nullptr},
    {"shadow-map", "Shadow map", "Filtered comparisons, 3x3", [] { return make_sampling_scene(SamplingKind::kShadowMap); },
     nullptr},
    {"gathers", "Gathers", "The four texels of a footprint, with offsets",
     [] { return make_sampling_scene(SamplingKind::kGathers); }, nullptr},
    {"blocks", "Compressed textures", "BC1, BC7, ETC2 and ASTC; where a driver lacks one, what its blocks decode to",
     make_blocks_scene, nullptr, 0.98},
    {"blits", "Blits", "A mip chain, a mirrored scaling, a change of format, sRGB", make_blits_scene, nullptr, 0.79},
    {"milktruck", "Milk truck", "CesiumMilkTruck, glTF with a texture", nullptr,
     PINEDA_ASSIMP_MODELS "glTF/CesiumMilkTruck/CesiumMilkTruck.gltf"},
    {"duck", "Duck", "The Collada duck, textured", nullptr, PINEDA_ASSIMP_MODELS "Collada/duck.dae"},
    {"engine", "Two-cylinder engine", "Binary glTF 2.0 with deep node transforms", nullptr,
     PINEDA_ASSIMP_MODELS "glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb"},
    {"bunny", "Stanford bunny", "OBJ, 69,000 triangles", nullptr, "/usr/share/glmark2/models/bunny.obj"},
};

#undef PINEDA_ASSIMP_MODELS

constexpr std::string_view kBenchPrefix = "bench:";

const BenchScene* find_bench_scene(const std::string& name) {
  for (const BenchScene& scene : bench_scenes()) {
    if (name == std::string(kBenchPrefix) + scene.name) return &scene;
  }
  return nullptr;
}

}  // namespace

std::span<const SceneInfo> known_scenes() { return kScenes; }

const SceneInfo* find_scene(const std::string& name) {
  for (const SceneInfo& scene : kScenes) {
    if (name == scene.name) return &scene;
  }
  return nullptr;
}

void require_scene(const std::string& name_or_path) {
  const SceneInfo* scene = find_scene(name_or_path);
  if ((scene && !scene->model_path) || find_bench_scene(name_or_path)) return;
  const std::string path = scene ? scene->model_path : name_or_path;
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) return;
  if (scene) fail("scene {}: its model {} is missing (install assimp-testmodels and glmark2-data)", scene->name, path);
  if (std::filesystem::exists(path, error)) fail("{} is not a file", path);
  std::string names;
  for (const SceneInfo& known : kScenes) names += fmt::format(" {}", known.name);
  fail("{}: no such file, and no such scene (known scenes:{})", path, names);
}

std::unique_ptr<Scene> create_scene(const std::string& name_or_path) {
  require_scene(name_or_path);
  if (const BenchScene* scene = find_bench_scene(name_or_path)) return scene->create();
  const SceneInfo* scene = find_scene(name_or_path);
  if (!scene) return make_model_scene(name_or_path);
  return scene->model_path ? make_model_scene(scene->model_path) : scene->create();
}

}  // namespace pineda::tools
