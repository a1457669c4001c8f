#include "tools/scenes/backdrop.h"

#include <cstdint>

#include "shaders/backdrop_frag.h"
#include "shaders/backdrop_vert.h"

namespace pineda::tools {

Backdrop::Backdrop(VkContext& context, const RenderTarget& target, const Colours& colours) : colours_(colours) {
  const VkPushConstantRange range{VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(Colours)};
  layout_ = create_pipeline_layout(context, {}, {&range, 1});
  pipeline_ = create_graphics_pipeline(context, target,
                                       {.vertex_shader = backdrop_vert, .fragment_shader = backdrop_frag, .layout = layout_});
}

void Backdrop::draw(VkCommandBuffer commands) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(Colours), &colours_);
  vkCmdDraw(commands, 3, 1, 0, 0);
}

}  // namespace pineda::tools
