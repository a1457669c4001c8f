// Runs shaders given as text on the driver: compute, or vertex and fragment over a small target.
#pragma once

#include "icd_pipeline_client.h"
#include "shader_tools.h"

namespace pineda::test {

using tests::tools::assembly;
using tests::tools::glsl;
using Words = std::vector<uint32_t>;

// Parts of a module in assembly for 16 invocations that read one storage buffer, %in (binding 0), and write another, %out: arrays
// of %element. %id is the built-in that tells invocations apart; %uint has to be declared before the variables.
inline std::string buffers_head(const std::string& built_in, const std::string& modes, uint32_t stride_bytes) {
  return R"(
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %id
OpExecutionMode %main LocalSize 16 1 1
)" + modes +
         "\nOpDecorate %id BuiltIn " + built_in + "\nOpDecorate %array ArrayStride " + std::to_string(stride_bytes) + R"(
OpDecorate %block BufferBlock
OpMemberDecorate %block 0 Offset 0
OpDecorate %in DescriptorSet 0
OpDecorate %in Binding 0
OpDecorate %out DescriptorSet 0
OpDecorate %out Binding 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
)";
}
inline std::string buffers_variables(const std::string& element, const std::string& id_type) {
  return "%array = OpTypeRuntimeArray " + element + R"(
%block = OpTypeStruct %array
%pblock = OpTypePointer Uniform %block
%pelement = OpTypePointer Uniform )" +
         element + "\n%pid = OpTypePointer Input " + id_type + R"(
%in = OpVariable %pblock Uniform
%out = OpVariable %pblock Uniform
%id = OpVariable %pid Input
)";
}

inline constexpr uint32_t kTargetSize = 16;  // pixels a side
inline constexpr VkFormat kTargetFormat = VK_FORMAT_R32G32B32A32_UINT;

class ShaderClient : public PipelineClient {
 public:
  using PipelineClient::PipelineClient;

  // One descriptor of set 0, at the binding of its place in the list.
  struct Binding {
    VkDescriptorType type;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    VkDeviceSize range_bytes = VK_WHOLE_SIZE;
  };
  static Binding storage(const Buffer& b, VkDeviceSize range_bytes = VK_WHOLE_SIZE) {
    return {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, b.handle, VK_NULL_HANDLE, VK_NULL_HANDLE, range_bytes};
  }

  // Set 0 and push constants of 128 bytes for what is run next.
  void bind(const std::vector<Binding>& bindings) {
    std::vector<VkDescriptorSetLayoutBinding> rows;
    for (const Binding& b : bindings)
      rows.push_back({static_cast<uint32_t>(rows.size()), b.type, 1, VK_SHADER_STAGE_ALL, nullptr});
    const VkDescriptorSetLayout set_layout = PipelineClient::set_layout(rows);
    layout_ = pipeline_layout(set_layout, 128);
    std::vector<VkDescriptorPoolSize> sizes;
    for (const Binding& b : bindings) sizes.push_back({b.type, 1});
    const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr,     0, 1,
                                          static_cast<uint32_t>(sizes.size()),           sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    ASSERT_EQ(VK(*this, CreateDescriptorPool)(device, &info, nullptr, &pool), VK_SUCCESS);
    defer([this, pool] { VK(*this, DestroyDescriptorPool)(device, pool, nullptr); });
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1, &set_layout};
    ASSERT_EQ(VK(*this, AllocateDescriptorSets)(device, &allocate, &set_), VK_SUCCESS);
    for (uint32_t i = 0; i < bindings.size(); ++i) {
      const VkDescriptorBufferInfo buffer{bindings[i].buffer, 0, bindings[i].range_bytes};
      const VkDescriptorImageInfo image{VK_NULL_HANDLE, bindings[i].view, VK_IMAGE_LAYOUT_GENERAL};
      const VkWriteDescriptorSet write{
          VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set_, i, 0, 1, bindings[i].type, &image, &buffer, &bindings[i].texels};
      VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
    }
  }

  VkResult compute(const Words& words, uint32_t groups, const void* push = nullptr, uint32_t push_bytes = 0) {
    VkPipeline pipeline = VK_NULL_HANDLE;
    const VkResult result = compute_pipeline(layout_, module(words), nullptr, &pipeline);
    if (result != VK_SUCCESS) return result;
    run([&](VkCommandBuffer cb) {
      VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(*this, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
      if (push_bytes != 0) VK(*this, CmdPushConstants)(cb, layout_, VK_SHADER_STAGE_ALL, 0, push_bytes, push);
      VK(*this, CmdDispatch)(cb, groups, 1, 1);
    });
    return result;
  }

  // Draws `vertices` vertices (triangles, or points) over a target of kTargetSize² pixels; `target` (4 words a pixel) gets what
  // the fragment shader wrote, if given.
  VkResult draw(const Words& vertex, const Words& fragment, uint32_t vertices, Words* target = nullptr,
                VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST) {
    const Attachment attachment{kTargetFormat, VK_ATTACHMENT_LOAD_OP_CLEAR};
    constexpr uint32_t kFirst = 0;
    const VkRenderPass pass = render_pass({&attachment, 1}, {&kFirst, 1});
    const VkExtent2D extent{kTargetSize, kTargetSize};
    const VkImage color = image(kTargetFormat, {kTargetSize, kTargetSize, 1}, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    const VkFramebuffer frame = framebuffer(pass, {view(color, kTargetFormat)}, extent);
    VkPipeline pipeline = VK_NULL_HANDLE;
    const VkResult result = graphics_pipeline({.layout = layout_,
                                               .pass = pass,
                                               .vertex = module(vertex),
                                               .fragment = module(fragment),
                                               .topology = topology,
                                               .reads_vertices = false},
                                              &pipeline);
    if (result != VK_SUCCESS) return result;
    const Buffer out = buffer(kTargetSize * kTargetSize * 16);
    run([&](VkCommandBuffer cb) {
      begin_pass(cb, pass, frame, {{0, 0}, extent}, {VkClearValue{}});
      VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
      if (set_) VK(*this, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
      const VkViewport viewport{0, 0, kTargetSize, kTargetSize, 0, 1};
      const VkRect2D scissor{{0, 0}, extent};
      VK(*this, CmdSetViewport)(cb, 0, 1, &viewport);
      VK(*this, CmdSetScissor)(cb, 0, 1, &scissor);
      VK(*this, CmdDraw)(cb, vertices, 1, 0, 0);
      VK(*this, CmdEndRenderPass)(cb);
      const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {kTargetSize, kTargetSize, 1}};
      VK(*this, CmdCopyImageToBuffer)(cb, color, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    if (target) target->assign(out.as<uint32_t>(), out.as<uint32_t>() + kTargetSize * kTargetSize * 4);
    return result;
  }

  // A triangle over everything.
  static Words covering_vertex() {
    return glsl(VK_SHADER_STAGE_VERTEX_BIT,
                "void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1, 0, 1); }");
  }

 private:
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace pineda::test
