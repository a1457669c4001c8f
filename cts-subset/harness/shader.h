// GLSL and SPIR-V assembly to modules, at run time: most cases generate their shaders from a table.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pineda::cts {

using Spirv = std::vector<uint32_t>;

// `#version 450` is put in front. Throws std::logic_error with glslang's log: a mistake of the case, not of the driver.
// `spirv_minor`: 0 for Vulkan 1.0, 3 for 1.1 (subgroups).
Spirv compile_glsl(VkShaderStageFlagBits stage, std::string_view source, int spirv_minor = 0);
Spirv assemble(std::string_view assembly, int spirv_minor = 0);

}  // namespace pineda::cts
