// A scene of the accuracy suite on a Vulkan driver: four floats a pixel, so that nothing is rounded to 8 bits.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/vk/context.h"

namespace pineda::tools {

// The worker's command {"command": "suite_render", "scene", "samples", "width", "height", "frames", "budget_ms", "floats": file
// to write} -> frames_ms[]; {"supported": false} when the driver has no such sample count.
nlohmann::json run_suite_scene(VkContext& context, const nlohmann::json& command);

}  // namespace pineda::tools
