// VK_KHR_get_memory_requirements2 and VK_KHR_bind_memory2, core in 1.1: the commands of 1.0 with chains.
#include "icd/api.h"
#include "icd/chain.h"
#include "icd/image.h"
#include "icd/object.h"
#include "icd/wsi/swapchain.h"

namespace pineda::icd {
namespace {

// Every resource can be anywhere in an allocation; one of its own gains nothing.
void fill_dedicated(void* chain) {
  auto* to = find_in_chain<VkMemoryDedicatedRequirements>(chain, VK_STRUCTURE_TYPE_MEMORY_DEDICATED_REQUIREMENTS);
  if (to) to->prefersDedicatedAllocation = to->requiresDedicatedAllocation = VK_FALSE;
}

}  // namespace

void api::GetBufferMemoryRequirements2(VkDevice device, const VkBufferMemoryRequirementsInfo2* info, VkMemoryRequirements2* out) {
  GetBufferMemoryRequirements(device, info->buffer, &out->memoryRequirements);
  fill_dedicated(out->pNext);
}

void api::GetImageMemoryRequirements2(VkDevice device, const VkImageMemoryRequirementsInfo2* info, VkMemoryRequirements2* out) {
  GetImageMemoryRequirements(device, info->image, &out->memoryRequirements);
  fill_dedicated(out->pNext);
}

void api::GetImageSparseMemoryRequirements2(VkDevice, const VkImageSparseMemoryRequirementsInfo2*, uint32_t* count,
                                            VkSparseImageMemoryRequirements2*) {
  *count = 0;
}

VkResult api::BindBufferMemory2(VkDevice device, uint32_t count, const VkBindBufferMemoryInfo* infos) {
  for (uint32_t i = 0; i < count; ++i) {
    const VkResult result = BindBufferMemory(device, infos[i].buffer, infos[i].memory, infos[i].memoryOffset);
    if (result != VK_SUCCESS) return result;
  }
  return VK_SUCCESS;
}

VkResult api::BindImageMemory2(VkDevice device, uint32_t count, const VkBindImageMemoryInfo* infos) {
  for (uint32_t i = 0; i < count; ++i) {
    const auto* chain =
        find_in_chain<VkBindImageMemorySwapchainInfoKHR>(infos[i].pNext, VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_SWAPCHAIN_INFO_KHR);
    if (chain && chain->swapchain) {
      from(infos[i].image)->bind(from(chain->swapchain)->memory(chain->imageIndex));
      continue;
    }
    const VkResult result = BindImageMemory(device, infos[i].image, infos[i].memory, infos[i].memoryOffset);
    if (result != VK_SUCCESS) return result;
  }
  return VK_SUCCESS;
}

}  // namespace pineda::icd
