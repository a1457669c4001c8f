// Declares every command of commands.inc with the signature of its PFN_vk type; each is defined in the file of its concept.
#pragma once

#include <type_traits>

#include "icd/vulkan_api.h"

namespace pineda::icd::api {

#define PINEDA_GLOBAL(name) std::remove_pointer_t<PFN_vk##name> name;
#define PINEDA_INSTANCE(name, gate) std::remove_pointer_t<PFN_vk##name> name;
#define PINEDA_PHYSICAL(name, gate) std::remove_pointer_t<PFN_vk##name> name;
#define PINEDA_DEVICE(name, gate) std::remove_pointer_t<PFN_vk##name> name;
#define PINEDA_COMMAND(name) std::remove_pointer_t<PFN_vkCmd##name> Cmd##name;
#include "icd/commands.inc"

}  // namespace pineda::icd::api
