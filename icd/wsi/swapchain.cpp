#include "icd/wsi/swapchain.h"

#include <algorithm>
#include <chrono>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"
#include "icd/enumerate.h"
#include "icd/fence.h"
#include "icd/image.h"
#include "icd/semaphore.h"

namespace pineda::icd {
namespace {

constexpr uint64_t kFrame_ns = 1'000'000'000 / 60;

// Of an ordinary image: vkCreateImage with VkImageSwapchainCreateInfoKHR makes the same.
VkImageCreateInfo image_info(const VkSwapchainCreateInfoKHR& info) {
  const bool is_mutable = (info.flags & VK_SWAPCHAIN_CREATE_MUTABLE_FORMAT_BIT_KHR) != 0;
  return {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
          .flags = is_mutable ? VkImageCreateFlags(VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT) : 0,
          .imageType = VK_IMAGE_TYPE_2D,
          .format = info.imageFormat,
          .extent = {info.imageExtent.width, info.imageExtent.height, 1},
          .mipLevels = 1,
          .arrayLayers = info.imageArrayLayers,
          .samples = VK_SAMPLE_COUNT_1_BIT,
          .tiling = VK_IMAGE_TILING_OPTIMAL,
          .usage = info.imageUsage,
          .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
          .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
}

}  // namespace

VkResult Swapchain::check(Device&, const VkSwapchainCreateInfoKHR& info) {
  const auto known = [&](const VkSurfaceFormatKHR& format) { return format.format == info.imageFormat; };
  if (std::ranges::none_of(surface_formats(), known))
    return not_supported("vkCreateSwapchainKHR: the surface has no such format");
  if (info.imageArrayLayers != 1) return not_supported("vkCreateSwapchainKHR: images have one layer");
  const Surface& surface = *from(info.surface);
  if (std::ranges::find(surface.present_modes(), info.presentMode) == surface.present_modes().end()) {
    return not_supported("vkCreateSwapchainKHR: the surface has no such present mode");
  }
  VkExtent2D extent;
  return surface.current_extent(&extent);
}

Swapchain::Swapchain(const Allocator& from_allocator, Device& device, const VkSwapchainCreateInfoKHR& info)
    : Object(from_allocator),
      device_(device),
      fifo_(info.presentMode == VK_PRESENT_MODE_FIFO_KHR),
      handles_(HostAllocator<VkImage>(&allocator)),
      images_(HostAllocator<PresentedImage>(&allocator)) {
  created_ = add_images(info);
}

VkResult Swapchain::add_images(const VkSwapchainCreateInfoKHR& info) {
  const VkImageCreateInfo create = image_info(info);
  const uint32_t count = std::max(info.minImageCount, 2u);
  handles_.reserve(count);
  images_.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    VkImage handle = VK_NULL_HANDLE;
    const VkResult result = api::CreateImage(to_handle(&device_), &create, nullptr, &handle);
    if (result != VK_SUCCESS) return result;
    handles_.push_back(handle);
    if (!presenter_) {
      const Image& image = *from(handle);
      presenter_ = from(info.surface)
                       ->make_presenter({.extent = info.imageExtent,
                                         .row_pitch_bytes = image.layout().level[0].row_pitch_bytes,
                                         .size_bytes = image.size_bytes(),
                                         .has_alpha = info.compositeAlpha == VK_COMPOSITE_ALPHA_PRE_MULTIPLIED_BIT_KHR});
    }
    uint8_t* memory = presenter_ ? presenter_->add_image() : nullptr;
    if (!memory) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    from(handle)->bind(memory);
    images_.push_back({memory});
  }
  return VK_SUCCESS;
}

// Presentations are part of what the application waits for before it destroys; vkQueuePresentKHR has no fence to wait for, so
// those that are still queued are waited for here.
Swapchain::~Swapchain() {
  {
    std::unique_lock lock(mutex_);
    const auto none_queued = [&] {
      return std::ranges::none_of(images_, [](const PresentedImage& image) { return image.state == State::kQueued; });
    };
    while (!none_queued()) {
      lock.unlock();
      const bool helped = device_.scheduler.help();
      lock.lock();
      if (!helped) changed_.wait_for(lock, std::chrono::milliseconds(10), none_queued);
    }
  }
  for (VkImage image : handles_) api::DestroyImage(to_handle(&device_), image, nullptr);
}

bool Swapchain::find_free_locked(uint64_t now_ns, uint32_t* out) const {
  bool found = false;
  for (uint32_t i = 0; i < images_.size(); ++i) {
    const PresentedImage& image = images_[i];
    if (image.state != State::kFree || image.ready_ns > now_ns || presenter_->reads(i)) continue;
    if (found && images_[*out].ready_ns <= image.ready_ns) continue;
    *out = i;
    found = true;
  }
  return found;
}

VkResult Swapchain::acquire(uint64_t timeout_ns, uint32_t* out) {
  const uint64_t deadline_ns = deadline_after(timeout_ns);
  std::unique_lock lock(mutex_);
  for (;;) {
    if (device_.lost()) return VK_ERROR_DEVICE_LOST;
    if (status_ < 0) return status_;
    const uint64_t now_ns = monotonic_ns();
    if (find_free_locked(now_ns, out)) {
      images_[*out].state = State::kAcquired;
      return VK_SUCCESS;
    }
    if (now_ns >= deadline_ns) return timeout_ns == 0 ? VK_NOT_READY : VK_TIMEOUT;
    // Something frees an image: time, the window system, or the queue that shows it.
    uint64_t wake_ns = deadline_ns;
    bool window_system_reads = false;
    for (uint32_t i = 0; i < images_.size(); ++i) {
      if (images_[i].state != State::kFree) continue;
      if (images_[i].ready_ns > now_ns) wake_ns = std::min(wake_ns, images_[i].ready_ns);
      window_system_reads |= presenter_->reads(i);
    }
    if (window_system_reads) {
      lock.unlock();
      presenter_->wait_for_release(wake_ns);
      lock.lock();
      continue;
    }
    const uint64_t sleep_ns = std::min<uint64_t>(wake_ns - now_ns, 100'000'000);  // looks again at a loss of the device
    changed_.wait_for(lock, std::chrono::nanoseconds(sleep_ns));
  }
}

VkResult Swapchain::queue_image(uint32_t image) {
  const std::scoped_lock lock(mutex_);
  if (image < images_.size()) images_[image].state = State::kQueued;
  return status_;
}

void Swapchain::show(uint32_t image) {
  if (image >= images_.size()) return;
  const VkResult result = presenter_->show(image, fifo_);
  const uint64_t now_ns = monotonic_ns();
  {
    const std::scoped_lock lock(mutex_);
    if (fifo_ && presenter_->needs_pacing()) last_frame_ns_ = std::max(now_ns, last_frame_ns_ + kFrame_ns);
    images_[image].state = State::kFree;
    images_[image].ready_ns = fifo_ && presenter_->needs_pacing() ? last_frame_ns_ : now_ns;
    if (status_ == VK_SUCCESS) status_ = result;
  }
  changed_.notify_all();
}

void Swapchain::retire() {
  {
    const std::scoped_lock lock(mutex_);
    status_ = VK_ERROR_OUT_OF_DATE_KHR;
  }
  changed_.notify_all();
}

VkResult api::CreateSwapchainKHR(VkDevice device, const VkSwapchainCreateInfoKHR* info, const VkAllocationCallbacks* callbacks,
                                 VkSwapchainKHR* out) {
  if (info->oldSwapchain) from(info->oldSwapchain)->retire();  // "even if creation of the new swapchain fails"
  VkResult result = create_device_object<Swapchain>(device, info, callbacks, out);
  if (result == VK_SUCCESS) result = from(*out)->created();
  if (result == VK_SUCCESS || !*out) return result;
  DestroySwapchainKHR(device, *out, callbacks);
  *out = VK_NULL_HANDLE;
  return result;
}

void api::DestroySwapchainKHR(VkDevice device, VkSwapchainKHR swapchain, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, swapchain, callbacks);
}

VkResult api::GetSwapchainImagesKHR(VkDevice, VkSwapchainKHR swapchain, uint32_t* count, VkImage* out) {
  return enumerate(from(swapchain)->images(), count, out);
}

VkResult api::AcquireNextImageKHR(VkDevice, VkSwapchainKHR swapchain, uint64_t timeout_ns, VkSemaphore semaphore, VkFence fence,
                                  uint32_t* image) {
  return guarded([&] {
    const VkResult result = from(swapchain)->acquire(timeout_ns, image);
    if (result != VK_SUCCESS) return result;
    if (semaphore) from(semaphore)->signal_from_host(1);  // the image is free already
    if (fence) from(fence)->signal();
    return result;
  });
}

VkResult api::AcquireNextImage2KHR(VkDevice device, const VkAcquireNextImageInfoKHR* info, uint32_t* image) {
  return AcquireNextImageKHR(device, info->swapchain, info->timeout, info->semaphore, info->fence, image);
}

VkResult api::QueuePresentKHR(VkQueue queue, const VkPresentInfoKHR* info) {
  return guarded([&] { return from(queue)->device.scheduler.present(*from(queue), *info); });
}

}  // namespace pineda::icd
