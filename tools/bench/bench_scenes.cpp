#include "tools/bench/bench_scenes.h"

#include <vector>

#include "tools/bench/grid_scenes.h"
#include "tools/bench/layer_scenes.h"
#include "tools/scenes/sampling.h"

namespace pineda::tools {

// A new row is one line here.
std::span<const BenchScene> bench_scenes() {
  constexpr VkExtent2D kFullHd{1920, 1080}, kHd{1280, 720};
  const auto layers = [](LayerKind kind, uint32_t count) { return [=] { return make_layer_scene(kind, count); }; };
  const auto mesh = [](const LitMeshOptions& options) { return [=] { return make_lit_mesh_scene(options); }; };
  const auto sampling = [](SamplingKind kind) { return [=] { return make_sampling_scene(kind); }; };
  static const std::vector<BenchScene> scenes{
      {"tiny-draw", "lit mesh of 1,024 triangles, 128x128", {128, 128}, mesh({.columns = 32, .rows = 16})},
      {"opaque-layers", "8 opaque colour layers", kFullHd, layers(LayerKind::kOpaque, 8)},
      {"blended-layers", "8 blended layers", kFullHd, layers(LayerKind::kBlended, 8)},
      {"trilinear-layers", "4 trilinear layers", kFullHd, layers(LayerKind::kTrilinear, 4)},
      {"bc7-layers", "4 trilinear layers of BC7 blocks", kFullHd, layers(LayerKind::kTrilinearBc7, 4)},
      {"astc-layers", "4 trilinear layers of ASTC blocks (lavapipe: RGBA8, as it has none)", kFullHd,
       layers(LayerKind::kTrilinearAstc, 4)},
      {"bilinear-upscale", "bilinear upscaling from 240x135", kFullHd, sampling(SamplingKind::kUpscale)},
      {"anisotropic", "receding plane, anisotropic 16", kFullHd, sampling(SamplingKind::kRecedingPlane)},
      {"shadow-filter", "shadow map with a 3x3 filter", kFullHd, sampling(SamplingKind::kShadowMap)},
      {"lookup-table", "3D table lookup", kFullHd, sampling(SamplingKind::kLookupTable)},
      {"blur", "9-tap blur", kFullHd, sampling(SamplingKind::kBlur)},
      {"lit-layers", "16 lit layers front to back", kHd, layers(LayerKind::kLitFrontToBack, 16)},
      {"tiny-triangles", "1 M tiny triangles with depth", kFullHd, mesh({.columns = 1000, .rows = 500})},
      {"culled-triangles", "1 M triangles, both faces culled", kFullHd, mesh({.columns = 1000, .rows = 500, .culled = true})},
      {"screen-edge", "262 k triangle lit mesh across the edge of the picture", kHd,
       mesh({.columns = 512, .rows = 256, .shift_x = 1})},
      {"lit-mesh", "262 k triangle lit mesh", kHd, mesh({.columns = 512, .rows = 256})},
      {"lit-mesh-4x", "262 k triangle lit mesh, 4 samples", kHd,
       [] { return with_samples(make_lit_mesh_scene({.columns = 512, .rows = 256}), 4); }},
      {"lit-mesh-8x", "262 k triangle lit mesh, 8 samples (lavapipe: 4, its most)", kHd,
       [] { return with_samples(make_lit_mesh_scene({.columns = 512, .rows = 256}), 8); }},
      {"depth-only", "depth of 1 M triangles", {2048, 2048}, mesh({.columns = 1000, .rows = 500, .depth_only = true})},
      {"many-draws", "10,000 draws of 16 triangles", kHd, mesh({.columns = 400, .rows = 200, .draw_count = 10'000})},
      {"many-passes",
       "64 render passes of 128x128 that do not depend on each other, a lit mesh of 1,024 triangles in each",
       {128, 128},
       [] { return make_many_passes_scene({.columns = 32, .rows = 16}, 64); }},
      {"pass-clears", "a render pass that clears colour and depth, and draws nothing", kFullHd,
       layers(LayerKind::kLitFrontToBack, 0)},
      {"grow-16k", "lit-mesh with 16 k triangles", kHd, mesh({.columns = 128, .rows = 64})},
      {"grow-65k", "lit-mesh with 65 k triangles", kHd, mesh({.columns = 256, .rows = 128})},
      {"grow-1m", "lit-mesh with 1 M triangles", kHd, mesh({.columns = 1024, .rows = 512})},
      {"grow-360p", "16 lit layers front to back at a quarter of the pixels", {640, 360}, layers(LayerKind::kLitFrontToBack, 16)},
      {"grow-1440p",
       "16 lit layers front to back at four times the pixels",
       {2560, 1440},
       layers(LayerKind::kLitFrontToBack, 16)},
  };
  return scenes;
}

}  // namespace pineda::tools
