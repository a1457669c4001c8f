#include "tools/bench/transfer_rows.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <thread>

#include "tools/error.h"
#include "tools/stopwatch.h"
#include "tools/vk/resources.h"

namespace pineda::tools {
namespace {

// Copies and clears move 64 MiB, more than caches keep.
constexpr uint32_t kSide = 4096;
constexpr uint32_t kBytes = 4 * kSide * kSide;
constexpr VkExtent3D kWhole{kSide, kSide, 1};
constexpr VkImageUsageFlags kBothWays = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
constexpr VkImageSubresourceLayers kColourLayers{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};

uint32_t noise(uint32_t i) { return (i * 0x9e3779b9u) ^ (i * 0x846ca68bu) >> 13; }

// What a row needs: two buffers and two images, of which it uses what it wants.
struct Objects {
  Buffer from, to;
  Image2D source, target;
};

struct Transfer {
  VkExtent2D source{}, target{};  // images; none when empty
  VkFormat source_format = VK_FORMAT_R8G8B8A8_UNORM, target_format = VK_FORMAT_R8G8B8A8_UNORM;
  uint32_t target_levels = 1;
  bool from_buffer = false, to_buffer = false;  // of kBytes
  std::function<void(VkCommandBuffer, const Objects&)> record;
  bool checks_buffer = false;  // `to` must end up as `from`
};

class TransferRow final : public BenchRow {
 public:
  TransferRow(VkContext& context, const Transfer& transfer) : context_(context), checks_(transfer.checks_buffer) {
    constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    objects_.from = create_buffer(context, kBytes, kUsage);
    auto* const words = reinterpret_cast<uint32_t*>(objects_.from.mapped);
    for (uint32_t i = 0; i < kBytes / 4; ++i) words[i] = noise(i);
    if (transfer.to_buffer) {
      objects_.to = create_buffer(context, kBytes, kUsage);
      std::memset(objects_.to.mapped, 1, kBytes);  // pages that nobody has touched would be cheaper to read
    }
    if (transfer.source.width) objects_.source = create_image(context, transfer.source, 1, transfer.source_format, kBothWays);
    if (transfer.target.width) {
      objects_.target = create_image(context, transfer.target, transfer.target_levels, transfer.target_format, kBothWays);
    }
    context.run_once([&](VkCommandBuffer commands) {
      if (transfer.source.width) fill_source(commands, transfer);
      if (transfer.target.width) move_to_general(commands, objects_.target, transfer.target_format);
    });
    commands_ = context.record([&](VkCommandBuffer commands) { transfer.record(commands, objects_); });
    context.submit_and_wait(commands_);
    if (checks_) check();
  }
  ~TransferRow() override { context_.release(commands_); }

  double run_sample() override {
    const Stopwatch watch;
    context_.submit_and_wait(commands_);
    return watch.elapsed_ms();
  }

 private:
  static void move_to_general(VkCommandBuffer commands, const Image2D& image, VkFormat format) {
    const bool depth = format == VK_FORMAT_D32_SFLOAT;
    const VkImageMemoryBarrier barrier{
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
        .newLayout = kGeneral,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image.handle,
        .subresourceRange = {depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0, image.mip_levels, 0, 1}};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr,
                         1, &barrier);
  }

  void fill_source(VkCommandBuffer commands, const Transfer& transfer) {
    move_to_general(commands, objects_.source, transfer.source_format);
    const VkBufferImageCopy region{.imageSubresource = kColourLayers,
                                   .imageExtent = {transfer.source.width, transfer.source.height, 1}};
    vkCmdCopyBufferToImage(commands, objects_.from.handle, objects_.source.handle, kGeneral, 1, &region);
  }

  void check() const {
    if (std::memcmp(objects_.from.mapped, objects_.to.mapped, kBytes) != 0) fail("a copy does not hold what was copied");
  }

  VkContext& context_;
  bool checks_;
  Objects objects_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

// The host's own copies and fills, on as many threads as there are cores. They are the same work in every driver's process.
class HostRow final : public BenchRow {
 public:
  explicit HostRow(bool copies) : copies_(copies), from_(kBytes, 1), to_(kBytes, 2) {}

  double run_sample() override {
    const Stopwatch watch;
    const size_t count = std::max(1u, std::thread::hardware_concurrency()), part = kBytes / count;
    std::vector<std::jthread> threads;
    for (size_t i = 1; i < count; ++i) threads.emplace_back([this, i, part] { run(i * part, part); });
    run(0, part);
    threads.clear();
    return watch.elapsed_ms();
  }

 private:
  void run(size_t first, size_t bytes) {
    if (copies_) {
      std::memcpy(&to_[first], &from_[first], bytes);
    } else {
      std::memset(&to_[first], static_cast<int>(first & 15), bytes);
    }
  }

  bool copies_;
  std::vector<uint8_t> from_, to_;
};

void record_mip_chain(VkCommandBuffer commands, const Objects& objects) {
  const VkImageCopy whole{kColourLayers, {}, kColourLayers, {}, {2048, 2048, 1}};
  vkCmdCopyImage(commands, objects.source.handle, kGeneral, objects.target.handle, kGeneral, 1, &whole);
  for (uint32_t level = 1; level < objects.target.mip_levels; ++level) {
    const VkMemoryBarrier barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                  .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
    const int32_t from = 2048 >> (level - 1), to = 2048 >> level;
    const VkImageBlit blit{{VK_IMAGE_ASPECT_COLOR_BIT, level - 1, 0, 1},
                           {{}, {from, from, 1}},
                           {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1},
                           {{}, {to, to, 1}}};
    vkCmdBlitImage(commands, objects.target.handle, kGeneral, objects.target.handle, kGeneral, 1, &blit, VK_FILTER_LINEAR);
  }
}

std::function<void(VkCommandBuffer, const Objects&)> record_blit(VkExtent2D from, VkExtent2D to, VkFilter filter) {
  return [=](VkCommandBuffer commands, const Objects& objects) {
    const auto corner = [](VkExtent2D e) { return VkOffset3D{static_cast<int32_t>(e.width), static_cast<int32_t>(e.height), 1}; };
    const VkImageBlit blit{kColourLayers, {{}, corner(from)}, kColourLayers, {{}, corner(to)}};
    vkCmdBlitImage(commands, objects.source.handle, kGeneral, objects.target.handle, kGeneral, 1, &blit, filter);
  };
}

void record_colour_clear(VkCommandBuffer commands, const Objects& objects) {
  const VkClearColorValue colour{{0.25f, 0.5f, 0.75f, 1}};
  const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdClearColorImage(commands, objects.target.handle, kGeneral, &colour, 1, &all);
}

void record_depth_clear(VkCommandBuffer commands, const Objects& objects) {
  const VkClearDepthStencilValue value{0.5f, 0};
  const VkImageSubresourceRange all{VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1};
  vkCmdClearDepthStencilImage(commands, objects.target.handle, kGeneral, &value, 1, &all);
}

}  // namespace

void add_transfer_rows(std::vector<BenchRowInfo>& rows) {
  const auto add = [&](const char* name, const char* description, const Transfer& transfer) {
    rows.push_back({name, description, {0, 0}, [transfer](VkContext& context, VkExtent2D) -> std::unique_ptr<BenchRow> {
                      return std::make_unique<TransferRow>(context, transfer);
                    }});
  };
  const auto host = [&](const char* name, const char* description, bool copies) {
    rows.push_back({name, description, {0, 0}, [copies](VkContext&, VkExtent2D) -> std::unique_ptr<BenchRow> {
                      return std::make_unique<HostRow>(copies);
                    }});
    rows.back().in_mean = false;
  };
  constexpr VkExtent2D kSquare{kSide, kSide}, kFullHd{1920, 1080}, kHd{1280, 720};
  constexpr VkBufferImageCopy kRegion{.imageSubresource = kColourLayers, .imageExtent = kWhole};
  host("host-memcpy", "64 MiB by memcpy on every core, no driver", true);
  host("host-memset", "64 MiB by memset on every core, no driver", false);
  add("copy-buffer", "64 MiB from buffer to buffer",
      {.to_buffer = true,
       .record =
           [](VkCommandBuffer commands, const Objects& o) {
             const VkBufferCopy region{0, 0, kBytes};
             vkCmdCopyBuffer(commands, o.from.handle, o.to.handle, 1, &region);
           },
       .checks_buffer = true});
  add("copy-to-image", "64 MiB from a buffer to an image",
      {.target = kSquare, .record = [kRegion](VkCommandBuffer commands, const Objects& o) {
         vkCmdCopyBufferToImage(commands, o.from.handle, o.target.handle, kGeneral, 1, &kRegion);
       }});
  add("copy-to-buffer", "64 MiB from an image to a buffer",
      {.source = kSquare,
       .to_buffer = true,
       .record = [kRegion](
                     VkCommandBuffer commands,
                     const Objects& o) { vkCmdCopyImageToBuffer(commands, o.source.handle, kGeneral, o.to.handle, 1, &kRegion); },
       .checks_buffer = true});
  add("copy-image", "64 MiB from image to image",
      {.source = kSquare, .target = kSquare, .record = [](VkCommandBuffer commands, const Objects& o) {
         const VkImageCopy region{kColourLayers, {}, kColourLayers, {}, kWhole};
         vkCmdCopyImage(commands, o.source.handle, kGeneral, o.target.handle, kGeneral, 1, &region);
       }});
  add("fill-buffer", "64 MiB of a buffer filled", {.to_buffer = true, .record = [](VkCommandBuffer commands, const Objects& o) {
                                                     vkCmdFillBuffer(commands, o.to.handle, 0, kBytes, 0x01020304);
                                                   }});
  add("clear-colour", "64 MiB of RGBA8 cleared", {.target = kSquare, .record = record_colour_clear});
  add("clear-depth", "64 MiB of 32-bit depth cleared",
      {.target = kSquare, .target_format = VK_FORMAT_D32_SFLOAT, .record = record_depth_clear});
  add("blit-down", "linear blit of RGBA8, 1920x1080 to 1280x720",
      {.source = kFullHd, .target = kHd, .record = record_blit(kFullHd, kHd, VK_FILTER_LINEAR)});
  add("blit-up", "linear blit of RGBA8, 1280x720 to 1920x1080",
      {.source = kHd, .target = kFullHd, .record = record_blit(kHd, kFullHd, VK_FILTER_LINEAR)});
  add("blit-nearest", "nearest blit of RGBA8, 1280x720 to 1920x1080",
      {.source = kHd, .target = kFullHd, .record = record_blit(kHd, kFullHd, VK_FILTER_NEAREST)});
  add("blit-swap", "blit from RGBA8 to BGRA8, 1920x1080",
      {.source = kFullHd,
       .target = kFullHd,
       .target_format = VK_FORMAT_B8G8R8A8_UNORM,
       .record = record_blit(kFullHd, kFullHd, VK_FILTER_NEAREST)});
  add("blit-convert", "blit from RGBA8 to 16-bit floats, 1920x1080",
      {.source = kFullHd,
       .target = kFullHd,
       .target_format = VK_FORMAT_R16G16B16A16_SFLOAT,
       .record = record_blit(kFullHd, kFullHd, VK_FILTER_NEAREST)});
  add("blit-srgb", "linear blit of sRGB, 1920x1080 to 1280x720",
      {.source = kFullHd,
       .target = kHd,
       .source_format = VK_FORMAT_R8G8B8A8_SRGB,
       .target_format = VK_FORMAT_R8G8B8A8_SRGB,
       .record = record_blit(kFullHd, kHd, VK_FILTER_LINEAR)});
  add("mip-levels", "11 mip levels of 2048x2048 RGBA8 by blits",
      {.source = {2048, 2048}, .target = {2048, 2048}, .target_levels = 12, .record = record_mip_chain});
}

}  // namespace pineda::tools
