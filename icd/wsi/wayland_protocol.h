// The protocol's inline functions, calling the library that wayland_library() has opened. Only for .cpp files.
#pragma once

#include "icd/wsi/wayland_library.h"

#define wl_proxy_marshal_flags (*pineda::icd::wayland_library()->wl_proxy_marshal_flags_)
#define wl_proxy_get_version (*pineda::icd::wayland_library()->wl_proxy_get_version_)
#define wl_proxy_add_listener (*pineda::icd::wayland_library()->wl_proxy_add_listener_)
#define wl_proxy_destroy (*pineda::icd::wayland_library()->wl_proxy_destroy_)
#define wl_proxy_set_user_data (*pineda::icd::wayland_library()->wl_proxy_set_user_data_)
#define wl_proxy_get_user_data (*pineda::icd::wayland_library()->wl_proxy_get_user_data_)
#define wl_registry_interface (*pineda_wl_registry_interface)
#define wl_shm_interface (*pineda_wl_shm_interface)
#define wl_shm_pool_interface (*pineda_wl_shm_pool_interface)
#define wl_buffer_interface (*pineda_wl_buffer_interface)
#define wl_callback_interface (*pineda_wl_callback_interface)

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wparentheses"  // "extern const struct wl_interface (*pointer)" is how the macros are meant
#include <wayland-client-protocol.h>
#pragma GCC diagnostic pop
