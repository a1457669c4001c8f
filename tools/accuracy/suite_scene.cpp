#include "tools/accuracy/suite_scene.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "shaders/suite_frag.h"
#include "shaders/suite_vert.h"
#include "tools/accuracy/suite.h"
#include "tools/error.h"
#include "tools/stopwatch.h"
#include "tools/vk/pipelines.h"
#include "tools/vk/resources.h"

namespace pineda::tools {

using nlohmann::json;

json run_suite_scene(VkContext& context, const json& command) {
  const SuiteScene& scene = require_suite_scene(command.at("scene").get<std::string>());
  const uint32_t samples = command.at("samples");
  if (!(context.sample_counts() & samples)) return {{"supported", false}};
  const auto attachments = scene.depth ? RenderTarget::Attachments::kColourDepth : RenderTarget::Attachments::kColour;
  const RenderTarget target(context, {command.at("width"), command.at("height")}, attachments, samples,
                            VK_FORMAT_R32G32B32A32_SFLOAT);
  const std::vector<SuiteVertex> vertices = scene.triangles();
  const Buffer buffer = create_buffer(context, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  const VkSpecializationMapEntry entry{0, 0, sizeof(int32_t)};
  const int32_t number = scene.shader;
  const VkSpecializationInfo specialization{1, &entry, sizeof number, &number};
  const PipelineLayoutHandle layout = create_pipeline_layout(context, {}, {});
  const PipelineHandle pipeline =
      create_graphics_pipeline(context, target,
                               {.vertex_shader = suite_vert,
                                .fragment_shader = suite_frag,
                                .vertex_bindings = {{0, sizeof(SuiteVertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(SuiteVertex, place)},
                                                      {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(SuiteVertex, data)}},
                                .depth_test = scene.depth,
                                .depth_write = scene.depth,
                                .alpha_blend = scene.blend,
                                .layout = layout,
                                .specialization = &specialization,
                                .vertex_specialization = &specialization});
  const VkCommandBuffer commands = context.record([&](VkCommandBuffer recording) {
    const VkDeviceSize offset = 0;
    const VkBuffer vertex_buffer = buffer.handle;
    target.begin(recording, {0, 0, 0, 1});
    vkCmdBindPipeline(recording, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    vkCmdBindVertexBuffers(recording, 0, 1, &vertex_buffer, &offset);
    vkCmdDraw(recording, static_cast<uint32_t>(vertices.size()), 1, 0, 0);
    vkCmdEndRenderPass(recording);
  });

  constexpr size_t kFewestFrames = 6;  // beyond what the first one waits for
  const size_t frame_count = command.at("frames");
  const double budget_ms = command.at("budget_ms");
  std::vector<double> frames_ms;
  const Stopwatch total;
  do {
    const Stopwatch frame;
    context.submit_and_wait(commands);
    frames_ms.push_back(frame.elapsed_ms());
  } while (frames_ms.size() < frame_count && (total.elapsed_ms() < budget_ms || frames_ms.size() < kFewestFrames));
  context.release(commands);

  const std::vector<float> floats = read_back_floats(context, target.colour());
  const std::string path = command.at("floats");
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(floats.data()), static_cast<std::streamsize>(floats.size() * sizeof(float)));
  file.close();
  if (!file) fail("{}: cannot be written", path);
  return {{"supported", true}, {"frames_ms", frames_ms}};
}

}  // namespace pineda::tools
