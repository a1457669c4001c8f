#include "tools/bench/rows.h"

#include <vector>

#include "tools/bench/bench_scenes.h"
#include "tools/bench/compute_rows.h"
#include "tools/bench/kernel_rows.h"
#include "tools/bench/latency_rows.h"
#include "tools/bench/transfer_rows.h"
#include "tools/bench/zoo_rows.h"
#include "tools/error.h"
#include "tools/scene.h"
#include "tools/scene_registry.h"
#include "tools/stopwatch.h"

namespace pineda::tools {
namespace {

constexpr VkExtent2D kFullHd{1920, 1080};

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
  std::optional<MeanColour> mean_colour() override {
    if (!scene_->picture().handle) return std::nullopt;  // depth only
    const Image image = read_back(context_, scene_->picture());
    MeanColour sum{};
    for (size_t i = 0; i < image.rgba.size(); ++i) sum[i % 4] += image.rgba[i];
    for (double& channel : sum) channel /= static_cast<double>(image.width) * image.height;
    return sum;
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

std::vector<BenchRowInfo> make_rows() {
  std::vector<BenchRowInfo> rows{
      {"startup", "instance and device in a fresh process", {0, 0}, nullptr},
      {"empty-submit", "submit of an empty command buffer, fence wait", {0, 0}, make_empty_submit_row},
      {"cold-compute", "new compute pipeline to its first result", {0, 0}, make_cold_compute_row},
      {"cold-graphics", "new graphics pipeline to its first pixel", {64, 64}, make_cold_graphics_row},
  };
  const auto zoo = [](ZooStage stage, ZooCache cache) {
    return [=](VkContext& context, VkExtent2D) { return make_zoo_row(context, stage, cache); };
  };
  rows.push_back({"cold-16-graphics",
                  "16 different graphics pipelines, each to its first pixel",
                  {0, 0},
                  zoo(ZooStage::kGraphics, ZooCache::kNone)});
  rows.push_back({"cold-16-compute",
                  "16 different compute pipelines, each to its first result",
                  {0, 0},
                  zoo(ZooStage::kCompute, ZooCache::kNone)});
  rows.push_back({"warm-16-graphics",
                  "the 16 graphics pipelines from a VkPipelineCache",
                  {0, 0},
                  zoo(ZooStage::kGraphics, ZooCache::kPipelineCache)});
  rows.push_back({"warm-16-compute",
                  "the 16 compute pipelines from a VkPipelineCache",
                  {0, 0},
                  zoo(ZooStage::kCompute, ZooCache::kPipelineCache)});
  rows.push_back({"disk-16-graphics",
                  "the 16 graphics pipelines from the cache on disk",
                  {0, 0},
                  zoo(ZooStage::kGraphics, ZooCache::kNone),
                  true});
  rows.push_back({"disk-16-compute",
                  "the 16 compute pipelines from the cache on disk",
                  {0, 0},
                  zoo(ZooStage::kCompute, ZooCache::kNone),
                  true});
  for (const SceneInfo& scene : known_scenes()) {
    const std::string name = scene.name;
    rows.push_back({name, std::string("scene: ") + scene.title, kFullHd, scene_row([name] { return create_scene(name); })});
  }
  for (const BenchScene& scene : bench_scenes()) {
    rows.push_back({scene.name, scene.description, scene.extent, scene_row(scene.create)});
  }
  add_transfer_rows(rows);
  rows.push_back({"saxpy", "SAXPY of 8 M floats", {0, 0}, make_saxpy_row});
  rows.push_back({"sgemm", "512x512 matrix product, tiles in shared memory", {0, 0}, make_sgemm_row});
  rows.push_back({"transcendentals", "84 M transcendental functions", {0, 0}, make_transcendentals_row});
  rows.push_back({"histogram", "256 bins of 4 M values, shared and global atomics", {0, 0}, make_histogram_row});
  rows.push_back({"reduce", "sums of 8 M values, trees in shared memory", {0, 0}, make_reduce_row});
  rows.push_back({"scan", "prefix sums of 2 M values in blocks of 256", {0, 0}, make_scan_row});
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
