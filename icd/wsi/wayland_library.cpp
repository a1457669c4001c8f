#include "icd/wsi/wayland_library.h"

#include <dlfcn.h>

#include <optional>

#define PINEDA_DEFINE(name) const wl_interface* pineda_##name = nullptr;
PINEDA_WAYLAND_INTERFACES(PINEDA_DEFINE)
#undef PINEDA_DEFINE

namespace pineda::icd {
namespace {

std::optional<WaylandLibrary> open_library() {
  WaylandLibrary wayland;
  void* library = dlopen("libwayland-client.so.0", RTLD_NOW | RTLD_LOCAL);
  if (!library) return std::nullopt;
  bool complete = true;
#define PINEDA_LOAD(name)                                                               \
  wayland.name##_ = reinterpret_cast<decltype(wayland.name##_)>(dlsym(library, #name)); \
  complete &= wayland.name##_ != nullptr;
  PINEDA_WAYLAND_FUNCTIONS(PINEDA_LOAD)
#undef PINEDA_LOAD
#define PINEDA_LOAD(name)                                                       \
  pineda_##name = reinterpret_cast<const wl_interface*>(dlsym(library, #name)); \
  complete &= pineda_##name != nullptr;
  PINEDA_WAYLAND_INTERFACES(PINEDA_LOAD)
#undef PINEDA_LOAD
  if (!complete) return std::nullopt;
  return wayland;
}

}  // namespace

const WaylandLibrary* wayland_library() {
  static const std::optional<WaylandLibrary> kLibrary = open_library();  // never closed: the application's is the same
  return kLibrary ? &*kLibrary : nullptr;
}

}  // namespace pineda::icd
