// VK_EXT_headless_surface: a swapchain whose images nobody looks at.
#include <vector>

#include "icd/api.h"
#include "icd/instance.h"
#include "icd/wsi/surface.h"

namespace pineda::icd {
namespace {

class HeadlessPresenter : public Presenter {
 public:
  explicit HeadlessPresenter(const PresentableImage& image) : size_bytes_(image.size_bytes) {}

  uint8_t* add_image() override {
    images_.push_back(Mapping::make(size_bytes_));
    return images_.back() ? images_.back()->data() : nullptr;
  }
  VkResult show(uint32_t, bool) override { return VK_SUCCESS; }

 private:
  const size_t size_bytes_;
  std::vector<std::unique_ptr<Mapping>> images_;
};

class HeadlessSurface : public Surface {
 public:
  using Surface::Surface;

  VkResult current_extent(VkExtent2D* out) const override {
    *out = kAnyExtent;
    return VK_SUCCESS;
  }
  std::span<const VkPresentModeKHR> present_modes() const override {
    static constexpr VkPresentModeKHR kModes[] = {VK_PRESENT_MODE_FIFO_KHR, VK_PRESENT_MODE_MAILBOX_KHR,
                                                  VK_PRESENT_MODE_IMMEDIATE_KHR};
    return kModes;
  }
  VkCompositeAlphaFlagsKHR composite_alpha() const override { return VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR; }
  std::unique_ptr<Presenter> make_presenter(const PresentableImage& image) override {
    return std::make_unique<HeadlessPresenter>(image);
  }
};

}  // namespace

VkResult api::CreateHeadlessSurfaceEXT(VkInstance instance, const VkHeadlessSurfaceCreateInfoEXT*,
                                       const VkAllocationCallbacks* callbacks, VkSurfaceKHR* out) {
  return create_surface<HeadlessSurface>(from(instance)->allocator, callbacks, out);
}

}  // namespace pineda::icd
