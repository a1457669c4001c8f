// Vulkan's declarations for this folder, without prototypes: the driver defines these commands and must never call the loader's.
#pragma once

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <vulkan/vulkan_core.h>
