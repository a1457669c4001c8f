// The driver's tests under the Khronos validation layer (`./run validate`). With PINEDA_TEST_VALIDATE=core, or =sync for
// synchronization validation too, every instance of a test is the loader's with the layer in it, and a test fails when the layer
// says anything that the test does not expect by name, or does not say what it expects. Without the variable nothing here acts.
#pragma once

#include <vulkan/vulkan_core.h>

#include <initializer_list>

namespace pineda::test {

// Whether tests run under the layer.
bool is_validating();

// What the test does against the rules on purpose, to see that the driver stays safe or gives the right error: the identifiers of
// the rules ("VUID-vkCmdDraw-None-02697") that the layer must find broken, each at least once, before the test ends. Hazards
// ("SYNC-HAZARD-…") are expected of synchronization validation only.
void breaks_on_purpose(std::initializer_list<const char*> rules);

// The test makes the driver lose its device. The layer does not take that as the end of what was submitted, as the specification
// does ("Lost Device"), and says of each object destroyed afterwards that it were in use.
void loses_device();

// The loader's vkCreateInstance and vkDestroyInstance with the layer and a messenger added.
VkResult create_validated_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                                   const VkAllocationCallbacks* callbacks, VkInstance* instance);
void destroy_validated_instance(PFN_vkGetInstanceProcAddr get, VkInstance instance, const VkAllocationCallbacks* callbacks);

}  // namespace pineda::test
