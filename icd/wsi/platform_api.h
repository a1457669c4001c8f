// The structures and commands of the window systems' extensions. Their headers name types of Xlib, XCB and Wayland; the few that
// they need are declared here, so that no window system has to be installed where they are used by name only.
#pragma once

#include <type_traits>

#include "icd/vulkan_api.h"

using Display = struct _XDisplay;
using Window = unsigned long;
using VisualID = unsigned long;
struct xcb_connection_t;
using xcb_window_t = uint32_t;
using xcb_visualid_t = uint32_t;

#include <vulkan/vulkan_wayland.h>
#include <vulkan/vulkan_xcb.h>
#include <vulkan/vulkan_xlib.h>

namespace pineda::icd::api {

#define PINEDA_PLATFORM_INSTANCE(name, gate) std::remove_pointer_t<PFN_vk##name> name;
#define PINEDA_PLATFORM_PHYSICAL(name, gate) std::remove_pointer_t<PFN_vk##name> name;
#include "icd/commands.inc"

}  // namespace pineda::icd::api
