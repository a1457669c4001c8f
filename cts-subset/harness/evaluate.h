// Runs a piece of GLSL on many inputs, in any stage.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {

using Words4 = std::array<uint32_t, 4>;
struct Arguments {
  Words4 a{}, b{}, c{};
};

struct Snippet {
  std::string functions;  // at global scope, extensions included
  std::string body;       // reads uvec4 a, b, c; writes uvec4 r
  int spirv_minor = 0;
  std::vector<Descriptor> descriptors;  // at bindings from 2 on
};

// One result for each of up to 256 inputs. The vertex stage hands its result to the fragment stage as a flat varying.
std::vector<Words4> evaluate(Device& device, VkShaderStageFlagBits stage, const Snippet& snippet,
                             const std::vector<Arguments>& inputs);

struct StageName {
  VkShaderStageFlagBits stage;
  const char* name;
};
inline constexpr StageName kStages[] = {
    {VK_SHADER_STAGE_VERTEX_BIT, "vertex"}, {VK_SHADER_STAGE_FRAGMENT_BIT, "fragment"}, {VK_SHADER_STAGE_COMPUTE_BIT, "compute"}};

}  // namespace pineda::cts
