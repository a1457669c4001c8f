// All extensions and features that the driver advertises, for the devices of tests.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <list>
#include <string>
#include <vector>

namespace pineda::test {

// The names of one enumeration and those that are asked for besides, each once.
class ExtensionNames {
 public:
  template <typename Enumerate>  // as vkEnumerateInstanceExtensionProperties without its first parameter
  ExtensionNames(const Enumerate& enumerate, std::initializer_list<const char*> asked) {
    uint32_t count = 0;
    enumerate(&count, static_cast<VkExtensionProperties*>(nullptr));
    std::vector<VkExtensionProperties> all(count);
    if (count > 0) enumerate(&count, all.data());
    for (const VkExtensionProperties& extension : all) add(extension.extensionName);
    for (const char* name : asked) add(name);
    for (const std::string& name : names_) pointers_.push_back(name.c_str());
  }
  uint32_t count() const { return static_cast<uint32_t>(pointers_.size()); }
  const char* const* data() const { return pointers_.data(); }

 private:
  void add(const char* name) {
    for (const std::string& have : names_) {
      if (have == name) return;
    }
    names_.emplace_back(name);
  }

  std::list<std::string> names_;  // which stay where they are
  std::vector<const char*> pointers_;
};

// A chain of every feature structure that the driver knows, with what it has.
class FeatureChain {
 public:
  FeatureChain(PFN_vkGetPhysicalDeviceFeatures2 query, VkPhysicalDevice physical) {
    for (size_t i = 0; i < std::size(kTypes); ++i)
      blocks_[i] = {kTypes[i], i + 1 < std::size(kTypes) ? &blocks_[i + 1] : nullptr};
    core_.pNext = &blocks_;
    query(physical, &core_);
  }
  FeatureChain(const FeatureChain&) = delete;
  const void* head() const { return &core_; }

 private:
  // Feature structures are one VkBool32 after the other; this has room for the longest.
  struct Block {
    VkStructureType type;
    void* next;
    VkBool32 values[32];
  };

  static constexpr VkStructureType kTypes[] = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VARIABLE_POINTERS_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SAMPLER_YCBCR_CONVERSION_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DRAW_PARAMETERS_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGELESS_FRAMEBUFFER_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_HOST_QUERY_RESET_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CUSTOM_BORDER_COLOR_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_4444_FORMATS_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_CLIP_ENABLE_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FAULT_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_2D_VIEW_OF_3D_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_INDEX_TYPE_UINT8_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_LINE_RASTERIZATION_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROVOKING_VERTEX_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_8BIT_STORAGE_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_UNIFORM_BUFFER_STANDARD_LAYOUT_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_INT64_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_FLOAT_FEATURES_EXT,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_INTEGER_DOT_PRODUCT_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_SUBGROUP_EXTENDED_TYPES_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_TERMINATE_INVOCATION_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DEMOTE_TO_HELPER_INVOCATION_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_MEMORY_MODEL_FEATURES,
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ZERO_INITIALIZE_WORKGROUP_MEMORY_FEATURES,
  };

  Block blocks_[std::size(kTypes)] = {};
  VkPhysicalDeviceFeatures2 core_{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
};

}  // namespace pineda::test
