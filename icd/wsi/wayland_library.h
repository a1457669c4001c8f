// libwayland-client, opened when the first Wayland surface is made. The protocol's inline functions (wayland-client-protocol.h)
// call wl_proxy_* and point to interface descriptions of the library; both are redirected to what was loaded.
#pragma once

#include <wayland-client-core.h>

namespace pineda::icd {

#define PINEDA_WAYLAND_FUNCTIONS(X)                                                                                \
  X(wl_proxy_marshal_flags)                                                                                        \
  X(wl_proxy_get_version)                                                                                          \
  X(wl_proxy_add_listener)                                                                                         \
  X(wl_proxy_destroy)                                                                                              \
  X(wl_proxy_set_queue) X(wl_proxy_create_wrapper) X(wl_proxy_wrapper_destroy) X(wl_proxy_set_user_data)           \
      X(wl_proxy_get_user_data) X(wl_display_create_queue) X(wl_event_queue_destroy) X(wl_display_roundtrip_queue) \
          X(wl_display_flush) X(wl_display_prepare_read_queue) X(wl_display_read_events) X(wl_display_cancel_read) \
              X(wl_display_dispatch_queue_pending) X(wl_display_get_fd)
#define PINEDA_WAYLAND_INTERFACES(X) \
  X(wl_registry_interface) X(wl_shm_interface) X(wl_shm_pool_interface) X(wl_buffer_interface) X(wl_callback_interface)

struct WaylandLibrary {
#define PINEDA_DECLARE(name) decltype(&::name) name##_ = nullptr;
  PINEDA_WAYLAND_FUNCTIONS(PINEDA_DECLARE)
#undef PINEDA_DECLARE
};

// Null when the library is missing.
const WaylandLibrary* wayland_library();

}  // namespace pineda::icd

// Set by wayland_library(). Global, because the protocol's header declares them once more under the names that the macros of
// wayland_protocol.h give.
extern "C" {
#define PINEDA_DECLARE(name) extern const wl_interface* pineda_##name;
PINEDA_WAYLAND_INTERFACES(PINEDA_DECLARE)
#undef PINEDA_DECLARE
}
