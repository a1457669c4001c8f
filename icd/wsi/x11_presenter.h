// Shows images in an X11 window: with MIT-SHM, where the server reads them in place, or through the socket.
#pragma once

#include <vector>

#include "icd/wsi/presenter.h"
#include "icd/wsi/xcb_library.h"

namespace pineda::icd {

// Of a window that exists; false when it is gone.
struct X11Geometry {
  VkExtent2D extent;
  uint8_t depth;
};
bool query_geometry(const XcbLibrary& xcb, xcb_connection_t* connection, xcb_window_t window, X11Geometry* out);

class X11Presenter : public Presenter {
 public:
  X11Presenter(const XcbLibrary& xcb, xcb_connection_t* connection, xcb_window_t window, uint8_t depth,
               const PresentableImage& image);
  ~X11Presenter() override;

  uint8_t* add_image() override;
  VkResult show(uint32_t image, bool wait_for_frame) override;
  bool needs_pacing() const override { return true; }

 private:
  struct Image {
    uint8_t* data;
    xcb_shm_seg_t segment;              // 0: not shared
    std::unique_ptr<Mapping> unshared;  // memory of its own then
  };

  bool add_shared(Image* out);
  void put_through_socket(const uint8_t* pixels);

  const XcbLibrary& xcb_;
  xcb_connection_t* const connection_;
  const xcb_window_t window_;
  const uint8_t depth_;
  const PresentableImage image_;
  xcb_gcontext_t gc_;
  bool can_share_;
  std::vector<Image> images_;
};

}  // namespace pineda::icd
