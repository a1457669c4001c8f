// VkSurfaceKHR: a window, or nothing at all (headless). One subclass for each window system.
#pragma once

#include <memory>
#include <span>

#include "icd/object.h"
#include "icd/wsi/presenter.h"

namespace pineda::icd {

class Surface : public Object {
 public:
  explicit Surface(const Allocator& from) : Object(from) {}
  virtual ~Surface() = default;

  // An extent that is not fixed by a window; applications choose.
  static constexpr VkExtent2D kAnyExtent{0xFFFFFFFFu, 0xFFFFFFFFu};

  // Of the window now; VK_ERROR_SURFACE_LOST_KHR when it is gone.
  virtual VkResult current_extent(VkExtent2D* out) const = 0;
  virtual std::span<const VkPresentModeKHR> present_modes() const = 0;
  virtual VkCompositeAlphaFlagsKHR composite_alpha() const = 0;
  // Null when the window system does not answer.
  virtual std::unique_ptr<Presenter> make_presenter(const PresentableImage& image) = 0;

  VkResult capabilities(VkSurfaceCapabilitiesKHR* out) const;
};

// Formats that all window systems here take.
std::span<const VkSurfaceFormatKHR> surface_formats();
VkImageUsageFlags presentable_usage();

// vkCreate*SurfaceKHR: constructs T(allocator, args...).
template <typename T, typename... Args>
VkResult create_surface(const Allocator& parent, const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out, const Args&... args) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    Surface* surface = make_object<T>(Allocator(callbacks, parent), VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, args...).release();
    *out = to_handle(surface);
    return VK_SUCCESS;
  });
}

}  // namespace pineda::icd
