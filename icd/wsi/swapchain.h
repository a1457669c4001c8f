// VkSwapchainKHR: images in memory that the window system reads, and the rules by which they go round: free, acquired by the
// application, queued for presentation, shown.
//
// There is no thread here. Whoever executes for the queue (scheduler.h) shows an image when the semaphores of vkQueuePresentKHR
// are signalled; vkAcquireNextImageKHR waits until an image may be drawn to again. Where the window system takes images at any
// rate, FIFO holds each one back for a frame of 1/60 s after the one before it.
#pragma once

#include <condition_variable>
#include <mutex>

#include "icd/object.h"
#include "icd/wsi/surface.h"

namespace pineda::icd {

class Image;

class Swapchain : public Object {
 public:
  static VkResult check(Device& device, const VkSwapchainCreateInfoKHR& info);
  Swapchain(const Allocator& from, Device& device, const VkSwapchainCreateInfoKHR& info);
  ~Swapchain();

  VkResult created() const { return created_; }  // other than VK_SUCCESS: memory was missing, here or in the window system
  std::span<const VkImage> images() const { return handles_; }
  uint8_t* memory(uint32_t image) const { return images_[image].memory; }

  // VK_SUCCESS, VK_NOT_READY, VK_TIMEOUT, VK_ERROR_OUT_OF_DATE_KHR, VK_ERROR_SURFACE_LOST_KHR, VK_ERROR_DEVICE_LOST.
  VkResult acquire(uint64_t timeout_ns, uint32_t* image);
  // Of vkQueuePresentKHR: what is known now. The image leaves the application.
  VkResult queue_image(uint32_t image);
  // Executes what queue_image announced.
  void show(uint32_t image);
  // Another swapchain has taken the surface: nothing more is acquired.
  void retire();

 private:
  enum class State { kFree, kAcquired, kQueued };
  struct PresentedImage {
    uint8_t* memory;
    State state = State::kFree;
    uint64_t ready_ns = 0;  // when a free image may be acquired
  };

  VkResult add_images(const VkSwapchainCreateInfoKHR& info);
  bool find_free_locked(uint64_t now_ns, uint32_t* image) const;

  Device& device_;
  const bool fifo_;
  std::unique_ptr<Presenter> presenter_;
  VkResult created_ = VK_SUCCESS;
  HostVector<VkImage> handles_;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  HostVector<PresentedImage> images_;
  uint64_t last_frame_ns_ = 0;
  VkResult status_ = VK_SUCCESS;
};

}  // namespace pineda::icd
