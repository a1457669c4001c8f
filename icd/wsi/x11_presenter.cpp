#include "icd/wsi/x11_presenter.h"

#include <sys/ipc.h>
#include <sys/shm.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace pineda::icd {
namespace {

constexpr uint32_t kTexelBytes = 4;

// Replies and errors of XCB are malloc'ed.
template <typename T>
using Reply = std::unique_ptr<T, decltype([](T* reply) { std::free(reply); })>;

bool server_shares(const XcbLibrary& xcb, xcb_connection_t* connection) {
  if (!xcb.shm_id) return false;
  const xcb_query_extension_reply_t* extension = xcb.xcb_get_extension_data(connection, xcb.shm_id);
  return extension && extension->present;
}

}  // namespace

bool query_geometry(const XcbLibrary& xcb, xcb_connection_t* connection, xcb_window_t window, X11Geometry* out) {
  const Reply<xcb_get_geometry_reply_t> reply(
      xcb.xcb_get_geometry_reply(connection, xcb.xcb_get_geometry(connection, window), nullptr));
  if (!reply) return false;
  *out = {{reply->width, reply->height}, reply->depth};
  return true;
}

X11Presenter::X11Presenter(const XcbLibrary& xcb, xcb_connection_t* connection, xcb_window_t window, uint8_t depth,
                           const PresentableImage& image)
    : xcb_(xcb),
      connection_(connection),
      window_(window),
      depth_(depth),
      image_(image),
      gc_(xcb.xcb_generate_id(connection)),
      can_share_(server_shares(xcb, connection)) {
  const uint32_t no_exposures = 0;
  xcb_.ignore_errors(connection_,
                     xcb_.xcb_create_gc_checked(connection_, gc_, window_, XCB_GC_GRAPHICS_EXPOSURES, &no_exposures));
}

X11Presenter::~X11Presenter() {
  for (const Image& image : images_) {
    if (!image.segment) continue;
    xcb_.ignore_errors(connection_, xcb_.xcb_shm_detach_checked(connection_, image.segment));
    shmdt(image.data);
  }
  xcb_.ignore_errors(connection_, xcb_.xcb_free_gc_checked(connection_, gc_));
  xcb_.xcb_flush(connection_);
}

// A System V segment: every server knows them. It is marked for removal at once, so it goes with the last process that has it.
bool X11Presenter::add_shared(Image* out) {
  const int id = shmget(IPC_PRIVATE, image_.size_bytes, IPC_CREAT | 0600);
  if (id < 0) return false;
  void* data = shmat(id, nullptr, 0);
  bool attached = data != reinterpret_cast<void*>(-1);
  if (attached) {
    *out = {static_cast<uint8_t*>(data), xcb_.xcb_generate_id(connection_), nullptr};
    const auto cookie = xcb_.xcb_shm_attach_checked(connection_, out->segment, uint32_t(id), 1);
    // A server on another machine or in another IPC namespace cannot.
    attached = !Reply<xcb_generic_error_t>(xcb_.xcb_request_check(connection_, cookie));
    if (!attached) shmdt(data);
  }
  shmctl(id, IPC_RMID, nullptr);
  return attached;
}

uint8_t* X11Presenter::add_image() {
  Image image{};
  can_share_ = can_share_ && add_shared(&image);
  if (!can_share_) {
    image = {nullptr, 0, Mapping::make(image_.size_bytes)};
    if (!image.unshared) return nullptr;
    image.data = image.unshared->data();
  }
  images_.push_back(std::move(image));
  return images_.back().data;
}

// In as many requests as the server's limit asks for; rows without padding, as Z pixmaps of 32 bits per pixel have none.
void X11Presenter::put_through_socket(const uint8_t* pixels) {
  const size_t row_bytes = size_t(image_.extent.width) * kTexelBytes;
  const size_t limit_bytes = size_t(xcb_.xcb_get_maximum_request_length(connection_)) * 4 - sizeof(xcb_put_image_request_t) - 4;
  const auto rows_at_once = uint32_t(std::max<size_t>(limit_bytes / row_bytes, 1));
  std::vector<uint8_t> packed;
  for (uint32_t y = 0; y < image_.extent.height; y += rows_at_once) {
    const uint32_t rows = std::min(rows_at_once, image_.extent.height - y);
    packed.resize(rows * row_bytes);
    for (uint32_t row = 0; row < rows; ++row) {
      std::memcpy(packed.data() + row * row_bytes, pixels + size_t(y + row) * image_.row_pitch_bytes, row_bytes);
    }
    xcb_.ignore_errors(connection_, xcb_.xcb_put_image_checked(connection_, XCB_IMAGE_FORMAT_Z_PIXMAP, window_, gc_,
                                                               uint16_t(image_.extent.width), uint16_t(rows), 0, int16_t(y), 0,
                                                               depth_, uint32_t(packed.size()), packed.data()));
  }
}

VkResult X11Presenter::show(uint32_t index, bool) {
  const Image& image = images_[index];
  if (image.segment) {
    xcb_.ignore_errors(connection_,
                       xcb_.xcb_shm_put_image_checked(connection_, window_, gc_, uint16_t(image_.row_pitch_bytes / kTexelBytes),
                                                      uint16_t(image_.extent.height), 0, 0, uint16_t(image_.extent.width),
                                                      uint16_t(image_.extent.height), 0, 0, depth_, XCB_IMAGE_FORMAT_Z_PIXMAP, 0,
                                                      image.segment, 0));
  } else {
    put_through_socket(image.data);
  }
  // The reply comes after the server has read the image: from then on it may be drawn to again.
  X11Geometry now;
  if (!query_geometry(xcb_, connection_, window_, &now)) return VK_ERROR_SURFACE_LOST_KHR;
  const bool same = now.extent.width == image_.extent.width && now.extent.height == image_.extent.height;
  return same ? VK_SUCCESS : VK_ERROR_OUT_OF_DATE_KHR;
}

}  // namespace pineda::icd
