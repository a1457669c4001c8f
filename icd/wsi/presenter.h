// The window system's side of one swapchain: memory for its images that the window system can read, and the act of showing one.
#pragma once

#include <cstdint>
#include <memory>

#include "icd/vulkan_api.h"

namespace pineda::icd {

// What the images of a swapchain have in common.
struct PresentableImage {
  VkExtent2D extent;
  uint32_t row_pitch_bytes;
  VkDeviceSize size_bytes;
  bool has_alpha;  // the window system blends with it
};

class Presenter {
 public:
  virtual ~Presenter() = default;

  // Adds an image; null when there is no memory.
  virtual uint8_t* add_image() = 0;
  // Gives the image to the window system. VK_SUCCESS, VK_ERROR_OUT_OF_DATE_KHR (shown, but the window has another size now) or
  // VK_ERROR_SURFACE_LOST_KHR. `wait_for_frame`: not before the one shown last has been on the screen. One thread at a time.
  virtual VkResult show(uint32_t image, bool wait_for_frame) = 0;

  // Whether the window system still reads the image.
  virtual bool reads(uint32_t) const { return false; }
  // Sleeps until reads() may have changed or the deadline (CLOCK_MONOTONIC) has passed. Any thread.
  virtual void wait_for_release(uint64_t /*deadline_ns*/) {}
  // Whether it is the swapchain's task to keep FIFO to a rate, because the window system takes images at any.
  virtual bool needs_pacing() const { return false; }
};

// Anonymous memory with a file descriptor, so that another process can map it.
class Mapping {
 public:
  static std::unique_ptr<Mapping> make(size_t size_bytes);  // null on failure
  ~Mapping();
  Mapping(const Mapping&) = delete;

  uint8_t* data() const { return data_; }
  int fd() const { return fd_; }

 private:
  Mapping(uint8_t* data, size_t size_bytes, int fd) : data_(data), size_bytes_(size_bytes), fd_(fd) {}

  uint8_t* data_;
  size_t size_bytes_;
  int fd_;
};

}  // namespace pineda::icd
