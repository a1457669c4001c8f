// libxcb, opened when the first X11 surface is made: where there is no X11 the driver works without it. An application that has a
// window has the library loaded already.
#pragma once

// xcb.h has no namespace of its own; this is the only header of the driver that includes it.
#include <xcb/shm.h>
#include <xcb/xcb.h>

#include "icd/wsi/platform_api.h"

namespace pineda::icd {

#define PINEDA_XCB_FUNCTIONS(X)                                                                                \
  X(xcb_get_geometry)                                                                                          \
  X(xcb_get_geometry_reply)                                                                                    \
  X(xcb_get_setup)                                                                                             \
  X(xcb_setup_roots_iterator)                                                                                  \
  X(xcb_screen_next)                                                                                           \
  X(xcb_screen_allowed_depths_iterator) X(xcb_depth_next) X(xcb_depth_visuals_iterator) X(xcb_visualtype_next) \
      X(xcb_generate_id) X(xcb_create_gc_checked) X(xcb_free_gc_checked) X(xcb_put_image_checked)              \
          X(xcb_get_maximum_request_length) X(xcb_flush) X(xcb_request_check) X(xcb_discard_reply) X(xcb_get_extension_data)
#define PINEDA_XCB_SHM_FUNCTIONS(X) X(xcb_shm_attach_checked) X(xcb_shm_detach_checked) X(xcb_shm_put_image_checked)

struct XcbLibrary {
#define PINEDA_DECLARE(name) decltype(&::name) name = nullptr;
  PINEDA_XCB_FUNCTIONS(PINEDA_DECLARE)
  PINEDA_XCB_SHM_FUNCTIONS(PINEDA_DECLARE)
#undef PINEDA_DECLARE
  xcb_extension_t* shm_id = nullptr;  // null: no libxcb-shm, images go through the socket

  // For requests whose errors concern nobody: a window may be gone at any time, and an error that is not caught ends in the
  // application's event queue, where Xlib's own handler ends the process.
  void ignore_errors(xcb_connection_t* connection, xcb_void_cookie_t cookie) const {
    xcb_discard_reply(connection, cookie.sequence);
  }
  xcb_connection_t* connection_of(Display* display) const;  // null when libX11-xcb is missing
};

// Null when libxcb is missing.
const XcbLibrary* xcb_library();

}  // namespace pineda::icd
