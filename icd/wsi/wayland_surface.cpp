// VK_KHR_wayland_surface: images are wl_shm buffers, which the compositor reads in place.
//
// The application's wl_display is shared: everything here lives in an event queue of its own, and events are read by the protocol
// of wl_display_prepare_read_queue, so application and driver may both wait for the socket.
#include <poll.h>

#include <array>
#include <atomic>
#include <vector>

#include "icd/instance.h"
#include "icd/notifier.h"
#include "icd/wsi/platform_api.h"
#include "icd/wsi/surface.h"
#include "icd/wsi/wayland_protocol.h"

namespace pineda::icd {
namespace {

constexpr uint32_t kShmVersion = 1;
// A compositor sends no frame events for a window that nobody sees; presenting goes on at this rate then.
constexpr uint64_t kHiddenFrame_ns = 200'000'000;

class WaylandPresenter : public Presenter {
 public:
  WaylandPresenter(const WaylandLibrary& wayland, wl_display* display, wl_surface* surface, const PresentableImage& image);
  ~WaylandPresenter() override;
  bool complete() const { return shm_ != nullptr; }

  uint8_t* add_image() override;
  VkResult show(uint32_t image, bool wait_for_frame) override;
  bool reads(uint32_t image) const override { return images_[image]->busy.load(std::memory_order_acquire); }
  void wait_for_release(uint64_t deadline_ns) override { (void)read_events(deadline_ns); }

 private:
  struct Image {
    std::unique_ptr<Mapping> memory;
    wl_buffer* buffer;
    std::atomic<bool> busy{false};
  };

  bool read_events(uint64_t deadline_ns);
  void wait_for_frame_event();

  static void on_global(void* self, wl_registry* registry, uint32_t name, const char* interface, uint32_t version);
  static void on_global_remove(void*, wl_registry*, uint32_t) {}
  static void on_format(void*, wl_shm*, uint32_t) {}
  static void on_release(void* image, wl_buffer*) { static_cast<Image*>(image)->busy.store(false, std::memory_order_release); }
  static void on_frame(void* self, wl_callback* callback, uint32_t);

  const WaylandLibrary& wayland_;
  wl_display* const display_;
  const PresentableImage image_;
  wl_event_queue* queue_ = nullptr;
  wl_surface* surface_ = nullptr;  // a wrapper, so that frame events come to queue_
  wl_shm* shm_ = nullptr;
  std::vector<std::unique_ptr<Image>> images_;  // listeners point to them
  std::atomic<wl_callback*> frame_{nullptr};    // of the last commit, until the compositor has shown it
};

WaylandPresenter::WaylandPresenter(const WaylandLibrary& wayland, wl_display* display, wl_surface* surface,
                                   const PresentableImage& image)
    : wayland_(wayland), display_(display), image_(image), queue_(wayland.wl_display_create_queue_(display)) {
  static constexpr wl_registry_listener kRegistry{&on_global, &on_global_remove};
  const auto wrap = [&](void* object) {
    void* wrapper = wayland_.wl_proxy_create_wrapper_(object);
    wayland_.wl_proxy_set_queue_(static_cast<wl_proxy*>(wrapper), queue_);
    return wrapper;
  };
  surface_ = static_cast<wl_surface*>(wrap(surface));
  auto* display_wrapper = static_cast<wl_display*>(wrap(display));
  wl_registry* registry = wl_display_get_registry(display_wrapper);
  wayland_.wl_proxy_wrapper_destroy_(display_wrapper);
  wl_registry_add_listener(registry, &kRegistry, this);
  wayland_.wl_display_roundtrip_queue_(display_, queue_);
  wl_registry_destroy(registry);
}

WaylandPresenter::~WaylandPresenter() {
  if (wl_callback* callback = frame_.load()) wl_callback_destroy(callback);
  for (const auto& image : images_) wl_buffer_destroy(image->buffer);
  if (shm_) wl_shm_destroy(shm_);
  wayland_.wl_proxy_wrapper_destroy_(surface_);
  wayland_.wl_display_flush_(display_);
  wayland_.wl_event_queue_destroy_(queue_);
}

void WaylandPresenter::on_global(void* self, wl_registry* registry, uint32_t name, const char* interface, uint32_t) {
  static constexpr wl_shm_listener kShm{&on_format};
  auto& presenter = *static_cast<WaylandPresenter*>(self);
  if (presenter.shm_ || std::string_view(interface) != "wl_shm") return;
  presenter.shm_ = static_cast<wl_shm*>(wl_registry_bind(registry, name, &wl_shm_interface, kShmVersion));
  wl_shm_add_listener(presenter.shm_, &kShm, nullptr);
}

uint8_t* WaylandPresenter::add_image() {
  static constexpr wl_buffer_listener kBuffer{&on_release};
  auto image = std::make_unique<Image>();
  image->memory = Mapping::make(image_.size_bytes);
  if (!image->memory) return nullptr;
  // XRGB8888 and ARGB8888 are the formats that every compositor has.
  const uint32_t format = image_.has_alpha ? WL_SHM_FORMAT_ARGB8888 : WL_SHM_FORMAT_XRGB8888;
  wl_shm_pool* pool = wl_shm_create_pool(shm_, image->memory->fd(), int32_t(image_.size_bytes));
  image->buffer = wl_shm_pool_create_buffer(pool, 0, int32_t(image_.extent.width), int32_t(image_.extent.height),
                                            int32_t(image_.row_pitch_bytes), format);
  wl_shm_pool_destroy(pool);
  wl_buffer_add_listener(image->buffer, &kBuffer, image.get());
  images_.push_back(std::move(image));
  return images_.back()->memory->data();
}

void WaylandPresenter::on_frame(void* self, wl_callback* callback, uint32_t) {
  auto& presenter = *static_cast<WaylandPresenter*>(self);
  wl_callback* expected = callback;
  presenter.frame_.compare_exchange_strong(expected, nullptr);
  wl_callback_destroy(callback);
}

// Dispatches what has come, or waits for something to come. False when the connection is broken.
bool WaylandPresenter::read_events(uint64_t deadline_ns) {
  if (wayland_.wl_display_prepare_read_queue_(display_, queue_) != 0) {
    return wayland_.wl_display_dispatch_queue_pending_(display_, queue_) >= 0;
  }
  wayland_.wl_display_flush_(display_);
  const uint64_t now_ns = monotonic_ns();
  // Another thread may read and dispatch what this one waits for; a short sleep looks again.
  constexpr uint64_t kLookAgain_ns = 10'000'000;
  const uint64_t wait_ns = std::min(deadline_ns > now_ns ? deadline_ns - now_ns : 0, kLookAgain_ns);
  pollfd socket{wayland_.wl_display_get_fd_(display_), POLLIN, 0};
  const timespec timeout{0, long(wait_ns)};
  if (ppoll(&socket, 1, &timeout, nullptr) > 0) {
    if (wayland_.wl_display_read_events_(display_) < 0) return false;
  } else {
    wayland_.wl_display_cancel_read_(display_);
  }
  return wayland_.wl_display_dispatch_queue_pending_(display_, queue_) >= 0;
}

void WaylandPresenter::wait_for_frame_event() {
  const uint64_t deadline_ns = monotonic_ns() + kHiddenFrame_ns;
  while (frame_.load() && monotonic_ns() < deadline_ns && read_events(deadline_ns)) {
  }
  if (wl_callback* late = frame_.exchange(nullptr)) wl_callback_destroy(late);
}

VkResult WaylandPresenter::show(uint32_t index, bool wait_for_frame) {
  static constexpr wl_callback_listener kFrame{&on_frame};
  wait_for_frame ? wait_for_frame_event() : void(read_events(0));
  Image& image = *images_[index];
  image.busy.store(true, std::memory_order_release);
  if (wl_callback* old = frame_.exchange(nullptr)) wl_callback_destroy(old);
  wl_callback* callback = wl_surface_frame(surface_);
  frame_.store(callback);
  wl_callback_add_listener(callback, &kFrame, this);
  wl_surface_attach(surface_, image.buffer, 0, 0);
  wl_surface_damage(surface_, 0, 0, INT32_MAX, INT32_MAX);
  wl_surface_commit(surface_);
  return wayland_.wl_display_flush_(display_) >= 0 || errno == EAGAIN ? VK_SUCCESS : VK_ERROR_SURFACE_LOST_KHR;
}

class WaylandSurface : public Surface {
 public:
  WaylandSurface(const Allocator& from, const WaylandLibrary& wayland, wl_display* display, wl_surface* surface)
      : Surface(from), wayland_(wayland), display_(display), surface_(surface) {}

  VkResult current_extent(VkExtent2D* out) const override {
    *out = kAnyExtent;  // the swapchain's extent becomes the window's
    return VK_SUCCESS;
  }
  std::span<const VkPresentModeKHR> present_modes() const override {
    static constexpr VkPresentModeKHR kModes[] = {VK_PRESENT_MODE_FIFO_KHR, VK_PRESENT_MODE_MAILBOX_KHR};
    return kModes;
  }
  VkCompositeAlphaFlagsKHR composite_alpha() const override {
    return VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR | VK_COMPOSITE_ALPHA_PRE_MULTIPLIED_BIT_KHR;
  }
  std::unique_ptr<Presenter> make_presenter(const PresentableImage& image) override {
    auto presenter = std::make_unique<WaylandPresenter>(wayland_, display_, surface_, image);
    if (!presenter->complete()) return nullptr;
    return presenter;
  }

 private:
  const WaylandLibrary& wayland_;
  wl_display* const display_;
  wl_surface* const surface_;
};

}  // namespace

VkResult api::CreateWaylandSurfaceKHR(VkInstance instance, const VkWaylandSurfaceCreateInfoKHR* info,
                                      const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out) {
  *out = VK_NULL_HANDLE;
  const WaylandLibrary* wayland = wayland_library();
  if (!wayland) {
    report(Severity::kError, "a Wayland surface needs libwayland-client.so.0");
    return VK_ERROR_INITIALIZATION_FAILED;
  }
  return create_surface<WaylandSurface>(from(instance)->allocator, callbacks, out, *wayland, info->display, info->surface);
}

VkBool32 api::GetPhysicalDeviceWaylandPresentationSupportKHR(VkPhysicalDevice, uint32_t, wl_display*) {
  return wayland_library() != nullptr;
}

}  // namespace pineda::icd
