// The background of the lit scenes: a full-screen triangle, drawn first, without depth.
#pragma once

#include <array>

#include "tools/scene.h"

namespace pineda::tools {

class Backdrop {
 public:
  struct Colours {
    std::array<float, 4> centre, edge;
  };
  Backdrop(VkContext& context, const RenderTarget& target, const Colours& colours);
  void draw(VkCommandBuffer commands) const;

 private:
  Colours colours_;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
};

}  // namespace pineda::tools
