// A scene: fixed work that is prepared once and recorded into one command buffer, the same for every driver.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/vk/context.h"
#include "tools/vk/pipelines.h"
#include "tools/vk/resources.h"

namespace pineda::tools {

class Scene {
 public:
  virtual ~Scene() = default;
  virtual void prepare(VkContext& context, VkExtent2D extent) = 0;  // pipelines, buffers, textures; throws ToolError
  virtual void record(VkCommandBuffer commands) const = 0;          // one frame
  virtual const Image2D& picture() const = 0;                       // in TRANSFER_SRC_OPTIMAL after the frame
  virtual std::vector<std::string> notes() const { return {}; }     // e.g. a texture that was not found
};

// A scene that is one render pass over one target.
class RenderScene : public Scene {
 public:
  explicit RenderScene(RenderTarget::Attachments attachments = RenderTarget::Attachments::kColour) : attachments_(attachments) {}

  // Before prepare():
  void set_samples(uint32_t samples) { samples_ = samples; }  // of a pixel
  void set_depth_format(VkFormat format) { depth_format_ = format; }

  void prepare(VkContext& context, VkExtent2D extent) final {
    target_ = std::make_unique<RenderTarget>(context, extent, attachments_, samples_, VK_FORMAT_R8G8B8A8_UNORM, depth_format_);
    create(context, *target_);
  }
  void record(VkCommandBuffer commands) const final {
    target_->begin(commands, clear_colour());
    draw(commands);
    vkCmdEndRenderPass(commands);
  }
  const Image2D& picture() const final { return target_->colour(); }

 protected:
  virtual void create(VkContext& context, const RenderTarget& target) = 0;
  virtual void draw(VkCommandBuffer commands) const = 0;
  virtual std::array<float, 4> clear_colour() const { return {0, 0, 0, 1}; }

 private:
  RenderTarget::Attachments attachments_;
  uint32_t samples_ = 1;
  VkFormat depth_format_ = VK_FORMAT_UNDEFINED;  // the usual one
  std::unique_ptr<RenderTarget> target_;
};

// A RenderScene, with `samples` samples a pixel.
inline std::unique_ptr<Scene> with_samples(std::unique_ptr<Scene> scene, uint32_t samples) {
  dynamic_cast<RenderScene&>(*scene).set_samples(samples);
  return scene;
}
// A RenderScene, whose depth attachment has another format.
inline std::unique_ptr<Scene> with_depth_format(std::unique_ptr<Scene> scene, VkFormat format) {
  dynamic_cast<RenderScene&>(*scene).set_depth_format(format);
  return scene;
}

}  // namespace pineda::tools
