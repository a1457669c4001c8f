#include "tools/bench/rows.h"

#include <vector>

#include "tools/bench/compute_rows.h"
#include "tools/bench/grid_scenes.h"
#include "tools/bench/latency_rows.h"
#include "tools/bench/layer_scenes.h"
#include "tools/error.h"
#include "tools/scene.h"
#include "tools/scene_registry.h"
#include "tools/stopwatch.h"

namespace pineda::tools {
namespace {

constexpr VkExtent2D kFullHd{1920, 1080}, kHd{1280, 720};

class SceneRow final : public BenchRow {
 public:
  SceneRow(VkContext& context, VkExtent2D extent, std::unique_ptr<Scene> scene) : context_(context), scene_(std::move(scene)) {
    scene_->prepare(context, extent);
    commands_ = context.record([&](VkCommandBuffer commands) { scene_->record(commands); });
  }
  ~SceneRow() override { context_.release(commands_); }

  double run_sample() override {
    const Stopwatch watch;
    context_.submit_and_wait(commands_);
    return watch.elapsed_ms();
  }

 private:
  VkContext& context_;
  std::unique_ptr<Scene> scene_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

template <typename MakeScene>
auto scene_row(MakeScene make_scene) {
  return [make_scene](VkContext& context, VkExtent2D extent) -> std::unique_ptr<BenchRow> {
    return std::make_unique<SceneRow>(context, extent, make_scene());
  };
}

// Scenes that each stress one part of a driver. A new row is one line here.
void add_throughput_rows(std::vector<BenchRowInfo>& rows) {
  const auto layers = [](LayerKind kind, uint32_t count) { return scene_row([=] { return make_layer_scene(kind, count); }); };
  const auto mesh = [](const LitMeshOptions& options) { return scene_row([=] { return make_lit_mesh_scene(options); }); };
  rows.push_back({"opaque-layers", "8 opaque colour layers", kFullHd, layers(LayerKind::kOpaque, 8)});
  rows.push_back({"blended-layers", "8 blended layers", kFullHd, layers(LayerKind::kBlended, 8)});
  rows.push_back({"trilinear-layers", "4 trilinear layers", kFullHd, layers(LayerKind::kTrilinear, 4)});
  rows.push_back({"lit-layers", "16 lit layers front to back", kHd, layers(LayerKind::kLitFrontToBack, 16)});
  rows.push_back({"tiny-triangles", "1 M tiny triangles with depth", kFullHd, mesh({.columns = 1000, .rows = 500})});
  rows.push_back({"lit-mesh", "262 k triangle lit mesh", kHd, mesh({.columns = 512, .rows = 256})});
  rows.push_back(
      {"depth-only", "depth of 1 M triangles", {2048, 2048}, mesh({.columns = 1000, .rows = 500, .depth_only = true})});
  rows.push_back({"many-draws", "10,000 draws of 16 triangles", kHd, mesh({.columns = 400, .rows = 200, .draw_count = 10'000})});
  rows.push_back({"saxpy", "SAXPY of 8 M floats", {0, 0}, make_saxpy_row});
}

std::vector<BenchRowInfo> make_rows() {
  std::vector<BenchRowInfo> rows{
      {"startup", "instance and device in a fresh process", {0, 0}, nullptr},
      {"empty-submit", "empty submit and fence wait", {0, 0}, make_empty_submit_row},
      {"tiny-draw", "lit mesh of 1,024 triangles, 128x128", {128, 128}, scene_row([] {
         return make_lit_mesh_scene({.columns = 32, .rows = 16});
       })},
      {"cold-compute", "new compute pipeline to its first result", {0, 0}, make_cold_compute_row},
      {"cold-graphics", "new graphics pipeline to its first pixel", {64, 64}, make_cold_graphics_row},
  };
  for (const SceneInfo& scene : known_scenes()) {
    const std::string name = scene.name;
    rows.push_back({name, std::string("scene: ") + scene.title, kFullHd, scene_row([name] { return create_scene(name); })});
  }
  add_throughput_rows(rows);
  return rows;
}

}  // namespace

std::span<const BenchRowInfo> bench_rows() {
  static const std::vector<BenchRowInfo> rows = make_rows();
  return rows;
}

std::unique_ptr<BenchRow> create_bench_row(const std::string& name, VkContext& context, VkExtent2D extent) {
  for (const BenchRowInfo& row : bench_rows()) {
    if (row.name == name && row.create) return row.create(context, extent);
  }
  fail("no benchmark row '{}'", name);
}

}  // namespace pineda::tools
