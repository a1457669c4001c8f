#include "icd/wsi/xcb_library.h"

#include <dlfcn.h>

#include <optional>

namespace pineda::icd {
namespace {

template <typename Function>
bool load(void* library, const char* name, Function* out) {
  *out = library ? reinterpret_cast<Function>(dlsym(library, name)) : nullptr;
  return *out != nullptr;
}

std::optional<XcbLibrary> open_library() {
  XcbLibrary xcb;
  void* core = dlopen("libxcb.so.1", RTLD_NOW | RTLD_LOCAL);
  bool complete = true;
#define PINEDA_LOAD(name) complete &= load(core, #name, &xcb.name);
  PINEDA_XCB_FUNCTIONS(PINEDA_LOAD)
  if (!complete) return std::nullopt;
  void* shm = dlopen("libxcb-shm.so.0", RTLD_NOW | RTLD_LOCAL);
#undef PINEDA_LOAD
#define PINEDA_LOAD(name) complete &= load(shm, #name, &xcb.name);
  PINEDA_XCB_SHM_FUNCTIONS(PINEDA_LOAD)
  if (complete) load(shm, "xcb_shm_id", &xcb.shm_id);
#undef PINEDA_LOAD
  return xcb;
}

}  // namespace

const XcbLibrary* xcb_library() {
  static const std::optional<XcbLibrary> kLibrary = open_library();  // never closed: the application's is the same
  return kLibrary ? &*kLibrary : nullptr;
}

xcb_connection_t* XcbLibrary::connection_of(Display* display) const {
  using GetConnection = xcb_connection_t* (*)(Display*);
  static const auto kGet = [] {
    GetConnection get = nullptr;
    load(dlopen("libX11-xcb.so.1", RTLD_NOW | RTLD_LOCAL), "XGetXCBConnection", &get);
    return get;
  }();
  return kGet ? kGet(display) : nullptr;
}

}  // namespace pineda::icd
