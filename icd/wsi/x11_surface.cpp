// VK_KHR_xcb_surface and VK_KHR_xlib_surface: both are a connection and a window.
#include "icd/instance.h"
#include "icd/wsi/surface.h"
#include "icd/wsi/x11_presenter.h"

namespace pineda::icd {
namespace {

class X11Surface : public Surface {
 public:
  X11Surface(const Allocator& from, const XcbLibrary& xcb, xcb_connection_t* connection, xcb_window_t window)
      : Surface(from), xcb_(xcb), connection_(connection), window_(window) {}

  VkResult current_extent(VkExtent2D* out) const override {
    X11Geometry geometry;
    if (!query_geometry(xcb_, connection_, window_, &geometry)) return VK_ERROR_SURFACE_LOST_KHR;
    *out = geometry.extent;
    return VK_SUCCESS;
  }
  // Immediate and mailbox are the same: the server has no frames to wait for, and takes each image whole.
  std::span<const VkPresentModeKHR> present_modes() const override {
    static constexpr VkPresentModeKHR kModes[] = {VK_PRESENT_MODE_FIFO_KHR, VK_PRESENT_MODE_MAILBOX_KHR,
                                                  VK_PRESENT_MODE_IMMEDIATE_KHR};
    return kModes;
  }
  VkCompositeAlphaFlagsKHR composite_alpha() const override {
    return VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR | VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
  }
  std::unique_ptr<Presenter> make_presenter(const PresentableImage& image) override {
    X11Geometry geometry;
    if (!query_geometry(xcb_, connection_, window_, &geometry)) return nullptr;
    return std::make_unique<X11Presenter>(xcb_, connection_, window_, geometry.depth, image);
  }

 private:
  const XcbLibrary& xcb_;
  xcb_connection_t* const connection_;
  const xcb_window_t window_;
};

// Pixels of 32 bits with 8 each of red, green and blue, blue lowest.
bool shows_bgra(const xcb_visualtype_t& visual) {
  const bool direct = visual._class == XCB_VISUAL_CLASS_TRUE_COLOR || visual._class == XCB_VISUAL_CLASS_DIRECT_COLOR;
  return direct && visual.red_mask == 0xFF0000 && visual.green_mask == 0xFF00 && visual.blue_mask == 0xFF;
}

bool find_visual(const XcbLibrary& xcb, xcb_connection_t* connection, xcb_visualid_t id) {
  for (auto screen = xcb.xcb_setup_roots_iterator(xcb.xcb_get_setup(connection)); screen.rem; xcb.xcb_screen_next(&screen)) {
    for (auto depth = xcb.xcb_screen_allowed_depths_iterator(screen.data); depth.rem; xcb.xcb_depth_next(&depth)) {
      if (depth.data->depth != 24 && depth.data->depth != 32) continue;
      for (auto visual = xcb.xcb_depth_visuals_iterator(depth.data); visual.rem; xcb.xcb_visualtype_next(&visual)) {
        if (visual.data->visual_id == id) return shows_bgra(*visual.data);
      }
    }
  }
  return false;
}

VkResult create_x11_surface(VkInstance instance, xcb_connection_t* connection, xcb_window_t window,
                            const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out) {
  *out = VK_NULL_HANDLE;
  const XcbLibrary* xcb = xcb_library();
  if (!xcb || !connection) {
    report(Severity::kError, "an X11 surface needs libxcb.so.1, and libX11-xcb.so.1 when it is made of an Xlib display");
    return VK_ERROR_INITIALIZATION_FAILED;
  }
  return create_surface<X11Surface>(from(instance)->allocator, callbacks, out, *xcb, connection, window);
}

}  // namespace

VkResult api::CreateXcbSurfaceKHR(VkInstance instance, const VkXcbSurfaceCreateInfoKHR* info,
                                  const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out) {
  return create_x11_surface(instance, info->connection, info->window, callbacks, out);
}

VkResult api::CreateXlibSurfaceKHR(VkInstance instance, const VkXlibSurfaceCreateInfoKHR* info,
                                   const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out) {
  const XcbLibrary* xcb = xcb_library();
  return create_x11_surface(instance, xcb ? xcb->connection_of(info->dpy) : nullptr, xcb_window_t(info->window), callbacks, out);
}

VkBool32 api::GetPhysicalDeviceXcbPresentationSupportKHR(VkPhysicalDevice, uint32_t, xcb_connection_t* connection,
                                                         xcb_visualid_t visual) {
  const XcbLibrary* xcb = xcb_library();
  return xcb && connection && find_visual(*xcb, connection, visual);
}

VkBool32 api::GetPhysicalDeviceXlibPresentationSupportKHR(VkPhysicalDevice device, uint32_t family, Display* display,
                                                          VisualID visual) {
  const XcbLibrary* xcb = xcb_library();
  xcb_connection_t* connection = xcb ? xcb->connection_of(display) : nullptr;
  return GetPhysicalDeviceXcbPresentationSupportKHR(device, family, connection, xcb_visualid_t(visual));
}

}  // namespace pineda::icd
