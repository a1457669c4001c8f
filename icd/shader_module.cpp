#include "icd/shader_module.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

VkResult api::CreateShaderModule(VkDevice device, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                 VkShaderModule* out) {
  return create_device_object<ShaderModule>(device, info, callbacks, out);
}

void api::DestroyShaderModule(VkDevice device, VkShaderModule module, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, module, callbacks);
}

}  // namespace pineda::icd
