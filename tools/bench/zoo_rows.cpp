#include "tools/bench/zoo_rows.h"

#include <array>
#include <cstring>
#include <span>

#include "shaders/zoo_blur_comp.h"
#include "shaders/zoo_blur_frag.h"
#include "shaders/zoo_edges_comp.h"
#include "shaders/zoo_edges_frag.h"
#include "shaders/zoo_fog_comp.h"
#include "shaders/zoo_fog_frag.h"
#include "shaders/zoo_fractal_comp.h"
#include "shaders/zoo_fractal_frag.h"
#include "shaders/zoo_hue_comp.h"
#include "shaders/zoo_hue_frag.h"
#include "shaders/zoo_lambert_comp.h"
#include "shaders/zoo_lambert_frag.h"
#include "shaders/zoo_noise_comp.h"
#include "shaders/zoo_noise_frag.h"
#include "shaders/zoo_normal_map_comp.h"
#include "shaders/zoo_normal_map_frag.h"
#include "shaders/zoo_pbr_comp.h"
#include "shaders/zoo_pbr_frag.h"
#include "shaders/zoo_phong_comp.h"
#include "shaders/zoo_phong_frag.h"
#include "shaders/zoo_raymarch_comp.h"
#include "shaders/zoo_raymarch_frag.h"
#include "shaders/zoo_shadow_comp.h"
#include "shaders/zoo_shadow_frag.h"
#include "shaders/zoo_tonemap_comp.h"
#include "shaders/zoo_tonemap_frag.h"
#include "shaders/zoo_toon_comp.h"
#include "shaders/zoo_toon_frag.h"
#include "shaders/zoo_vert.h"
#include "shaders/zoo_voronoi_comp.h"
#include "shaders/zoo_voronoi_frag.h"
#include "shaders/zoo_water_comp.h"
#include "shaders/zoo_water_frag.h"
#include "tools/error.h"
#include "tools/image.h"
#include "tools/stopwatch.h"
#include "tools/vk/pipelines.h"

namespace pineda::tools {
namespace {

struct Shader {
  Spirv fragment, compute;
};
const Shader kShaders[] = {
    {zoo_blur_frag, zoo_blur_comp},         {zoo_edges_frag, zoo_edges_comp},
    {zoo_fog_frag, zoo_fog_comp},           {zoo_fractal_frag, zoo_fractal_comp},
    {zoo_hue_frag, zoo_hue_comp},           {zoo_lambert_frag, zoo_lambert_comp},
    {zoo_noise_frag, zoo_noise_comp},       {zoo_normal_map_frag, zoo_normal_map_comp},
    {zoo_pbr_frag, zoo_pbr_comp},           {zoo_phong_frag, zoo_phong_comp},
    {zoo_raymarch_frag, zoo_raymarch_comp}, {zoo_shadow_frag, zoo_shadow_comp},
    {zoo_tonemap_frag, zoo_tonemap_comp},   {zoo_toon_frag, zoo_toon_comp},
    {zoo_voronoi_frag, zoo_voronoi_comp},   {zoo_water_frag, zoo_water_comp},
};

constexpr VkExtent2D kExtent{64, 64};
constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;

struct SceneData {  // as Scene in frame.glsl
  float view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.1f, 0.2f, 0.3f, 1};
  float eye[4] = {0, 0, 4, 1};
  float light[4][4] = {{1, 2, 3, 1}, {-2, 1, 2, 0.8f}, {0.5f, -1, 1, 0.5f}, {2, 0.2f, 0.4f, 0.7f}};
  float tint[4] = {0.9f, 0.6f, 0.3f, 0.1f};
  float time[4] = {1.25f, 0, 0, 0};
};

Image make_picture() {
  Image image{.width = 64, .height = 64, .rgba = {}};
  for (uint32_t i = 0; i < 64 * 64; ++i) {
    for (const uint32_t step : {3u, 5u, 7u}) image.rgba.push_back(static_cast<uint8_t>(i * step + (i >> 6) * 11));
    image.rgba.push_back(255);
  }
  return image;
}

class ZooRow final : public BenchRow {
 public:
  ZooRow(VkContext& context, ZooStage stage, ZooCache cache)
      : context_(context),
        stage_(stage),
        target_(context, kExtent, RenderTarget::Attachments::kColour),
        descriptors_(context, 1, 1),
        sampler_(create_trilinear_sampler(context)) {
    const Image picture = make_picture();
    picture_ = create_texture(context, {&picture, 1}, kFormat);
    const SceneData scene;
    scene_ = create_buffer(context, std::as_bytes(std::span(&scene, 1)), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    colours_ = create_buffer(context, kExtent.width * kExtent.height * 16, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    constexpr VkShaderStageFlags kBoth = VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    const std::array<Binding, 3> bindings{Binding{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kBoth},
                                          Binding{1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kBoth},
                                          Binding{2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT}};
    set_layout_ = create_set_layout(context, bindings);
    set_ = descriptors_.allocate(set_layout_);
    descriptors_.write_buffer(set_, 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, scene_);
    descriptors_.write_texture(set_, 1, picture_, sampler_);
    descriptors_.write_buffer(set_, 2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, colours_);
    const VkDescriptorSetLayout set_layout = set_layout_;
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {});
    if (cache == ZooCache::kPipelineCache) fill_cache();
  }

  double run_sample() override {
    const Stopwatch watch;
    const std::vector<PipelineHandle> pipelines = create();
    context_.run_once([&](VkCommandBuffer commands) { use(commands, pipelines); });
    return watch.elapsed_ms();
  }

  std::optional<MeanColour> mean_colour() override {
    if (stage_ == ZooStage::kCompute) return compute_mean();
    const Image image = read_back(context_, target_.colour());
    MeanColour sum{};
    for (size_t i = 0; i < image.rgba.size(); ++i) sum[i % 4] += image.rgba[i];
    for (double& channel : sum) channel /= static_cast<double>(image.width) * image.height;
    return sum;
  }

 private:
  MeanColour compute_mean() const {
    const auto* values = reinterpret_cast<const float*>(colours_.mapped);
    MeanColour sum{};
    const uint32_t pixels = kExtent.width * kExtent.height;
    for (uint32_t i = 0; i < 4 * pixels; ++i) sum[i % 4] += 255 * std::min(std::max(values[i], 0.0f), 1.0f) / pixels;
    return sum;
  }

  std::vector<PipelineHandle> create() {
    std::vector<PipelineHandle> pipelines;
    for (const Shader& shader : kShaders) {
      if (stage_ == ZooStage::kCompute) {
        pipelines.push_back(create_compute_pipeline(context_, shader.compute, layout_, nullptr, cache_));
      } else {
        pipelines.push_back(create_graphics_pipeline(
            context_, target_,
            {.vertex_shader = zoo_vert, .fragment_shader = shader.fragment, .layout = layout_, .cache = cache_}));
      }
    }
    return pipelines;
  }

  // The last pipeline's picture stays.
  void use(VkCommandBuffer commands, const std::vector<PipelineHandle>& pipelines) {
    const bool compute = stage_ == ZooStage::kCompute;
    const VkPipelineBindPoint point = compute ? VK_PIPELINE_BIND_POINT_COMPUTE : VK_PIPELINE_BIND_POINT_GRAPHICS;
    if (!compute) target_.begin(commands, {0, 0, 0, 1});
    vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set_, 0, nullptr);
    for (const PipelineHandle& pipeline : pipelines) {
      vkCmdBindPipeline(commands, point, pipeline);
      if (compute) {
        vkCmdDispatch(commands, kExtent.width / 8, kExtent.height / 8, 1);
        make_visible_to_host(commands, colours_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
      } else {
        vkCmdDraw(commands, 3, 1, 0, 0);
      }
    }
    if (!compute) vkCmdEndRenderPass(commands);
  }

  // The cache goes through its data, as in an application that kept it in a file.
  void fill_cache() {
    const auto make = [&](std::span<const std::byte> data) {
      VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
      info.initialDataSize = data.size();
      info.pInitialData = data.data();
      VkPipelineCache cache = VK_NULL_HANDLE;
      check(vkCreatePipelineCache(context_.device(), &info, nullptr, &cache), "vkCreatePipelineCache");
      return PipelineCacheHandle(context_.device(), cache);
    };
    cache_ = make({});
    run_sample();
    size_t size_bytes = 0;
    check(vkGetPipelineCacheData(context_.device(), cache_, &size_bytes, nullptr), "vkGetPipelineCacheData");
    std::vector<std::byte> data(size_bytes);
    check(vkGetPipelineCacheData(context_.device(), cache_, &size_bytes, data.data()), "vkGetPipelineCacheData");
    cache_ = make(data);
  }

  VkContext& context_;
  const ZooStage stage_;
  RenderTarget target_;
  DescriptorAllocator descriptors_;
  SamplerHandle sampler_;
  Image2D picture_;
  Buffer scene_, colours_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineCacheHandle cache_;
};

}  // namespace

std::unique_ptr<BenchRow> make_zoo_row(VkContext& context, ZooStage stage, ZooCache cache) {
  return std::make_unique<ZooRow>(context, stage, cache);
}

}  // namespace pineda::tools
