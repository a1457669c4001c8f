// Surfaces and swapchains: headless, and X11 windows under an Xvfb of the test's own, looked at through the server.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xcb/xcb.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "icd_client.h"
#define VK_USE_PLATFORM_XCB_KHR
#include <vulkan/vulkan_xcb.h>

namespace pineda::test {
namespace {

using std::chrono::steady_clock;

class WindowClient : public Client {
 public:
  WindowClient()
      : Client(nullptr,
               {VK_KHR_SURFACE_EXTENSION_NAME, VK_KHR_XCB_SURFACE_EXTENSION_NAME, VK_EXT_HEADLESS_SURFACE_EXTENSION_NAME,
                VK_KHR_GET_SURFACE_CAPABILITIES_2_EXTENSION_NAME},
               {VK_KHR_SWAPCHAIN_EXTENSION_NAME}) {}

  VkSurfaceKHR headless() {
    const VkHeadlessSurfaceCreateInfoEXT info{VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    VkSurfaceKHR out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateHeadlessSurfaceEXT)(instance, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroySurfaceKHR)(instance, out, nullptr); });
    return out;
  }
  VkSurfaceCapabilitiesKHR capabilities(VkSurfaceKHR surface) {
    VkSurfaceCapabilitiesKHR out{};
    EXPECT_EQ(VK(*this, GetPhysicalDeviceSurfaceCapabilitiesKHR)(physical, surface, &out), VK_SUCCESS);
    return out;
  }
  VkResult create(VkSurfaceKHR surface, VkExtent2D extent, VkSwapchainKHR* out, VkSwapchainKHR old = VK_NULL_HANDLE,
                  VkPresentModeKHR mode = VK_PRESENT_MODE_FIFO_KHR) {
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface;
    info.minImageCount = 2;
    info.imageFormat = VK_FORMAT_B8G8R8A8_UNORM;
    info.imageExtent = extent;
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.preTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode = mode;
    info.oldSwapchain = old;
    const VkResult made = VK(*this, CreateSwapchainKHR)(device, &info, nullptr, out);
    if (made == VK_SUCCESS) defer([this, handle = *out] { VK(*this, DestroySwapchainKHR)(device, handle, nullptr); });
    return made;
  }
  VkSemaphore semaphore() {
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateSemaphore)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroySemaphore)(device, out, nullptr); });
    return out;
  }
  std::vector<VkImage> images(VkSwapchainKHR swapchain) {
    uint32_t count = 0;
    EXPECT_EQ(VK(*this, GetSwapchainImagesKHR)(device, swapchain, &count, nullptr), VK_SUCCESS);
    std::vector<VkImage> out(count);
    EXPECT_EQ(VK(*this, GetSwapchainImagesKHR)(device, swapchain, &count, out.data()), VK_SUCCESS);
    return out;
  }
  // Acquires, clears to the colour (0xRRGGBB), presents.
  VkResult frame(VkSwapchainKHR swapchain, uint32_t rgb, VkSemaphore acquired, VkSemaphore drawn) {
    const std::vector<VkImage> of_swapchain = images(swapchain);
    uint32_t index = 0;
    const VkResult result = VK(*this, AcquireNextImageKHR)(device, swapchain, UINT64_MAX, acquired, VK_NULL_HANDLE, &index);
    if (result != VK_SUCCESS) return result;
    const VkCommandBuffer cb = command_buffer();
    begin(cb);
    const auto channel = [&](int shift) { return float((rgb >> shift) & 255) / 255.0f; };
    const VkClearColorValue color{{channel(16), channel(8), channel(0), 1}};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    const VkImage image = of_swapchain[index];
    transition(cb, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    VK(*this, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    transition(cb, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    EXPECT_EQ(VK(*this, EndCommandBuffer)(cb), VK_SUCCESS);
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
    const VkSubmitInfo submit_info{VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 1, &acquired, &stage, 1, &cb, 1, &drawn};
    EXPECT_EQ(VK(*this, QueueSubmit)(queue, 1, &submit_info, VK_NULL_HANDLE), VK_SUCCESS);
    const VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR, nullptr, 1, &drawn, 1, &swapchain, &index, nullptr};
    const VkResult presented = VK(*this, QueuePresentKHR)(queue, &present);
    EXPECT_EQ(VK(*this, QueueWaitIdle)(queue), VK_SUCCESS);
    VK(*this, FreeCommandBuffers)(device, pool, 1, &cb);
    return presented;
  }
};

TEST(IcdWindow, HeadlessImagesGoRound) {
  breaks_on_purpose({"VUID-VkAcquireNextImageInfoKHR-swapchain-01675"});
  WindowClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  const VkSurfaceKHR surface = client.headless();
  EXPECT_EQ(client.capabilities(surface).currentExtent.width, 0xFFFFFFFFu) << "the swapchain decides";
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(surface, {64, 32}, &swapchain), VK_SUCCESS);
  ASSERT_EQ(client.images(swapchain).size(), 2u);
  const VkSemaphore acquired = client.semaphore(), drawn = client.semaphore();
  for (uint32_t i = 0; i < 100; ++i) ASSERT_EQ(client.frame(swapchain, i, acquired, drawn), VK_SUCCESS);
  // Both acquired: no third.
  const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateFence)(client.device, &fence_info, nullptr, &fence), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyFence)(client.device, fence, nullptr); });
  uint32_t index[3];
  const auto acquire = [&](uint64_t timeout_ns, uint32_t* out) {
    const VkAcquireNextImageInfoKHR info{
        VK_STRUCTURE_TYPE_ACQUIRE_NEXT_IMAGE_INFO_KHR, nullptr, swapchain, timeout_ns, VK_NULL_HANDLE, fence, 1};
    return VK(client, AcquireNextImage2KHR)(client.device, &info, out);
  };
  ASSERT_EQ(acquire(UINT64_MAX, &index[0]), VK_SUCCESS);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, fence), VK_SUCCESS);
  EXPECT_EQ(VK(client, ResetFences)(client.device, 1, &fence), VK_SUCCESS);
  ASSERT_EQ(acquire(0, &index[1]), VK_SUCCESS);
  EXPECT_NE(index[0], index[1]);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, fence), VK_SUCCESS);
  EXPECT_EQ(VK(client, ResetFences)(client.device, 1, &fence), VK_SUCCESS);
  EXPECT_EQ(acquire(0, &index[2]), VK_NOT_READY);
  const auto start = steady_clock::now();
  EXPECT_EQ(acquire(10'000'000, &index[2]), VK_TIMEOUT);
  EXPECT_GE(steady_clock::now() - start, std::chrono::milliseconds(10));
  // A second swapchain takes the surface over.
  VkSwapchainKHR second = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(surface, {64, 64}, &second, swapchain), VK_SUCCESS);
  EXPECT_EQ(acquire(0, &index[2]), VK_ERROR_OUT_OF_DATE_KHR);
  EXPECT_EQ(client.frame(second, 7, acquired, drawn), VK_SUCCESS);
}

// An image of the application's own on the memory of a swapchain's (VkBindImageMemorySwapchainInfoKHR).
TEST(IcdWindow, ImagesAliasTheSwapchains) {
  WindowClient client;
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(client.headless(), {16, 16}, &swapchain), VK_SUCCESS);
  const VkSemaphore acquired = client.semaphore();
  const std::vector<VkImage> of_swapchain = client.images(swapchain);
  uint32_t index = 0;
  ASSERT_EQ(VK(client, AcquireNextImageKHR)(client.device, swapchain, UINT64_MAX, acquired, VK_NULL_HANDLE, &index), VK_SUCCESS);
  const VkImage own = of_swapchain[index];
  const VkImageSwapchainCreateInfoKHR chain{VK_STRUCTURE_TYPE_IMAGE_SWAPCHAIN_CREATE_INFO_KHR, nullptr, swapchain};
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, &chain};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = VK_FORMAT_B8G8R8A8_UNORM;
  info.extent = {16, 16, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  VkImage alias = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &alias), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyImage)(client.device, alias, nullptr); });
  const VkBindImageMemorySwapchainInfoKHR bind_chain{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_SWAPCHAIN_INFO_KHR, nullptr, swapchain,
                                                     index};
  const VkBindImageMemoryInfo bind{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_INFO, &bind_chain, alias, VK_NULL_HANDLE, 0};
  ASSERT_EQ(VK(client, BindImageMemory2)(client.device, 1, &bind), VK_SUCCESS);
  const auto buffer = client.buffer(16 * 16 * 4);
  client.run([&](VkCommandBuffer cb) {
    const VkClearColorValue color{{1, 0, 0.2f, 1}};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    for (const VkImage image : {own, alias}) {
      client.transition(cb, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    }
    VK(client, CmdClearColorImage)(cb, own, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    client.barrier(cb);
    const VkBufferImageCopy copy{0, 0, 0, color_layers(), {}, {16, 16, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, alias, VK_IMAGE_LAYOUT_GENERAL, buffer.handle, 1, &copy);
  });
  EXPECT_EQ(buffer.as<uint32_t>()[37], 0xFFFF0033u);
}

// An X server without a screen, on a display number that it chooses itself. `without`: an extension that it is to lack.
class XServer {
 public:
  explicit XServer(const char* without = nullptr) {
    int ready[2];
    if (access("/usr/bin/Xvfb", X_OK) != 0 || pipe(ready) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      const std::string fd = std::to_string(ready[1]);
      std::vector<const char*> arguments{"Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp"};
      if (without) arguments.insert(arguments.end(), {"-extension", without});
      arguments.push_back(nullptr);
      if (!std::getenv("PINEDA_TEST_VERBOSE")) (void)!freopen("/dev/null", "w", stderr);
      execv("/usr/bin/Xvfb", const_cast<char* const*>(arguments.data()));
      _exit(127);
    }
    close(ready[1]);
    char text[16] = {};
    if (read(ready[0], text, sizeof(text) - 1) > 0)
      connection_ = xcb_connect((":" + std::to_string(std::atoi(text))).c_str(), nullptr);
    close(ready[0]);
  }
  ~XServer() {
    if (connection_) xcb_disconnect(connection_);
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }

  xcb_connection_t* connection() const { return connection_; }

  xcb_window_t window(uint16_t width, uint16_t height) {
    const xcb_screen_t* screen = xcb_setup_roots_iterator(xcb_get_setup(connection_)).data;
    const xcb_window_t out = xcb_generate_id(connection_);
    xcb_create_window(connection_, XCB_COPY_FROM_PARENT, out, screen->root, 0, 0, width, height, 0, XCB_WINDOW_CLASS_INPUT_OUTPUT,
                      screen->root_visual, 0, nullptr);
    xcb_map_window(connection_, out);
    xcb_flush(connection_);
    return out;
  }
  void resize(xcb_window_t window, uint32_t width, uint32_t height) {
    const uint32_t values[] = {width, height};
    xcb_configure_window(connection_, window, XCB_CONFIG_WINDOW_WIDTH | XCB_CONFIG_WINDOW_HEIGHT, values);
    xcb_flush(connection_);
  }
  // 0xRRGGBB on the screen.
  uint32_t pixel(xcb_window_t window, int16_t x, int16_t y) {
    const auto cookie = xcb_get_image(connection_, XCB_IMAGE_FORMAT_Z_PIXMAP, window, x, y, 1, 1, ~0u);
    const std::unique_ptr<xcb_get_image_reply_t, decltype(&std::free)> reply(xcb_get_image_reply(connection_, cookie, nullptr),
                                                                             &std::free);
    uint32_t value = 0;
    if (reply) std::memcpy(&value, xcb_get_image_data(reply.get()), 4);
    return value & 0xFFFFFF;
  }

 private:
  pid_t process_ = -1;
  xcb_connection_t* connection_ = nullptr;
};

class IcdX11 : public testing::TestWithParam<const char*> {};

TEST_P(IcdX11, FramesAreOnTheScreenAndResizingIsTold) {
  XServer server(GetParam());
  if (!server.connection() || xcb_connection_has_error(server.connection())) GTEST_SKIP() << "Xvfb is not installed";
  WindowClient client;
  const xcb_window_t window = server.window(150, 100);
  const VkXcbSurfaceCreateInfoKHR info{VK_STRUCTURE_TYPE_XCB_SURFACE_CREATE_INFO_KHR, nullptr, 0, server.connection(), window};
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateXcbSurfaceKHR)(client.instance, &info, nullptr, &surface), VK_SUCCESS);
  client.defer([&] { VK(client, DestroySurfaceKHR)(client.instance, surface, nullptr); });
  EXPECT_EQ(VK(client, GetPhysicalDeviceXcbPresentationSupportKHR)(
                client.physical, 0, server.connection(),
                xcb_setup_roots_iterator(xcb_get_setup(server.connection())).data->root_visual),
            VK_TRUE);
  EXPECT_EQ(client.capabilities(surface).currentExtent.width, 150u);
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(surface, {150, 100}, &swapchain), VK_SUCCESS);
  const VkSemaphore acquired = client.semaphore(), drawn = client.semaphore();
  for (uint32_t rgb : {0xFF0000u, 0x123456u, 0x00FF80u}) {
    ASSERT_EQ(client.frame(swapchain, rgb, acquired, drawn), VK_SUCCESS);
    EXPECT_EQ(server.pixel(window, 0, 0), rgb);
    EXPECT_EQ(server.pixel(window, 149, 99), rgb);
  }
  // FIFO: twelve frames are eleven intervals of 1/60 s, of which the images in hand may save two.
  const auto start = steady_clock::now();
  for (uint32_t i = 0; i < 12; ++i) ASSERT_EQ(client.frame(swapchain, i, acquired, drawn), VK_SUCCESS);
  EXPECT_GE(steady_clock::now() - start, std::chrono::milliseconds(9 * 1000 / 60));
  // The frame after a change of size is shown; from then on the swapchain is out of date.
  server.resize(window, 200, 120);
  EXPECT_EQ(client.frame(swapchain, 0xABCDEF, acquired, drawn), VK_SUCCESS);
  EXPECT_EQ(client.frame(swapchain, 0xABCDEF, acquired, drawn), VK_ERROR_OUT_OF_DATE_KHR);
  EXPECT_EQ(client.capabilities(surface).currentExtent.height, 120u);
  VkSwapchainKHR second = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(surface, {200, 120}, &second, swapchain, VK_PRESENT_MODE_IMMEDIATE_KHR), VK_SUCCESS);
  ASSERT_EQ(client.frame(second, 0x0F1E2D, acquired, drawn), VK_SUCCESS);
  EXPECT_EQ(server.pixel(window, 199, 119), 0x0F1E2Du);
  // Neither waits for a screen: as many frames as in the second that FIFO would need take no time.
  VkSwapchainKHR third = VK_NULL_HANDLE;
  ASSERT_EQ(client.create(surface, {200, 120}, &third, second, VK_PRESENT_MODE_MAILBOX_KHR), VK_SUCCESS);
  for (uint32_t i = 0; i < 60; ++i) ASSERT_EQ(client.frame(third, i, acquired, drawn), VK_SUCCESS);
  EXPECT_EQ(server.pixel(window, 100, 60), 59u);
  ASSERT_EQ(client.create(surface, {200, 120}, &second, third, VK_PRESENT_MODE_IMMEDIATE_KHR), VK_SUCCESS);
  // Unmapped (minimised): frames go nowhere, without an error. Destroyed: the surface is lost.
  xcb_unmap_window(server.connection(), window);
  EXPECT_EQ(client.frame(second, 1, acquired, drawn), VK_SUCCESS);
  xcb_destroy_window(server.connection(), window);
  xcb_flush(server.connection());
  EXPECT_EQ(client.frame(second, 1, acquired, drawn), VK_SUCCESS) << "the frame that finds out";
  EXPECT_EQ(client.frame(second, 1, acquired, drawn), VK_ERROR_SURFACE_LOST_KHR);
  VkSurfaceCapabilitiesKHR capabilities;
  EXPECT_EQ(VK(client, GetPhysicalDeviceSurfaceCapabilitiesKHR)(client.physical, surface, &capabilities),
            VK_ERROR_SURFACE_LOST_KHR);
  // Errors of the driver's requests are its own: Xlib would end the process for one.
  xcb_flush(server.connection());
  while (xcb_generic_event_t* event = xcb_poll_for_event(server.connection())) {
    EXPECT_NE(event->response_type, 0) << "error " << int(reinterpret_cast<xcb_generic_error_t*>(event)->error_code);
    std::free(event);
  }
}

// With MIT-SHM the server reads the images in place; without, they go through the socket.
INSTANTIATE_TEST_SUITE_P(Window, IcdX11, testing::Values(nullptr, "MIT-SHM"),
                         [](const auto& info) { return std::string(info.param ? "socket" : "shared_memory"); });

}  // namespace
}  // namespace pineda::test
