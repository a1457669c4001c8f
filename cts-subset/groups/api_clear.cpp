// api.image_clearing: clears outside and inside of render passes, of every format and range.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/compare.h"
#include "cts-subset/reference/formats.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

struct ClearValue {
  const char* name;
  std::array<double, 4> value;
};
constexpr ClearValue kFloatClears[] = {{"zero", {0, 0, 0, 0}},
                                       {"one", {1, 1, 1, 1}},
                                       {"middle", {0.25, 0.5, 0.75, 0.125}},
                                       {"outside", {-3, 2, 0.3, 100}},
                                       {"small", {0.001, 0.002, 0.003, 0.004}}};
constexpr ClearValue kIntegerClears[] = {{"zero", {0, 0, 0, 0}}, {"one", {1, 1, 1, 1}}, {"some", {3, 100, 7, 1}}};

VkClearColorValue to_vulkan(const FormatInfo& info, const ClearValue& value) {
  VkClearColorValue result{};
  for (size_t i = 0; i < 4; ++i) {
    if (info.is_integer()) {
      result.uint32[i] = static_cast<uint32_t>(value.value[i]);
    } else {
      result.float32[i] = static_cast<float>(value.value[i]);
    }
  }
  return result;
}

// What the clear's floats give in the format: rounding of a non-representable value may go either way.
void expect_all(const FormatInfo& info, const std::vector<std::byte>& texels, const ClearValue& value, const std::string& where) {
  Colour want;
  for (size_t i = 0; i < 4; ++i) want[i] = info.is_integer() ? value.value[i] : static_cast<float>(value.value[i]);
  for (size_t i = 0; i < texels.size(); i += info.bytes) {
    expect_colour(info, texels.data() + i, want, info.is_integer() ? 0 : 1, fmt::format("{}, texel {}", where, i / info.bytes));
  }
}

struct Range {
  const char* name;
  uint32_t level, levels, layer, layers;
};
constexpr Range kRanges[] = {{"all", 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS},
                             {"first_level", 0, 1, 0, VK_REMAINING_ARRAY_LAYERS},
                             {"last_level_of_middle_layer", 2, 1, 1, 1},
                             {"levels_1_and_up", 1, VK_REMAINING_MIP_LEVELS, 0, 2}};

void run_clear_image(Device& device, const FormatInfo& info, const ClearValue& value, const Range& range) {
  ImageDesc desc;
  desc.format = info.format;
  desc.extent = {11, 9, 1};
  desc.levels = 3, desc.layers = 3;
  const Image image = create_image(device, desc);
  const VkClearColorValue before{}, clear = to_vulkan(info, value);
  device.run([&](VkCommandBuffer commands) {
    const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    const VkImageSubresourceRange part{VK_IMAGE_ASPECT_COLOR_BIT, range.level, range.levels, range.layer, range.layers};
    transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearColorImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &before, 1, &whole);
    full_barrier(commands);
    vkCmdClearColorImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &clear, 1, &part);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  });
  const auto within = [](uint32_t at, uint32_t first, uint32_t count) { return at >= first && at - first < count; };
  for (uint32_t level = 0; level < 3; ++level) {
    for (uint32_t layer = 0; layer < 3; ++layer) {
      const bool cleared = within(level, range.level, range.levels) && within(layer, range.layer, range.layers);
      expect_all(info, download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, level, layer),
                 cleared ? value : kFloatClears[0], fmt::format("level {}, layer {}", level, layer));
    }
  }
}

void run_clear_depth(Device& device, VkFormat format, VkImageAspectFlags aspects, float depth, uint32_t stencil) {
  ImageDesc desc;
  desc.format = format;
  desc.extent = {13, 7, 1};
  desc.usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  const Image image = create_image(device, desc);
  const VkImageAspectFlags all = aspects_of(format);
  require((all & aspects) == aspects, "the aspect");
  const VkClearDepthStencilValue before{0.25f, 0x3C}, clear{depth, stencil};
  device.run([&](VkCommandBuffer commands) {
    const VkImageSubresourceRange whole{all, 0, 1, 0, 1}, part{aspects, 0, 1, 0, 1};
    transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearDepthStencilImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &before, 1, &whole);
    full_barrier(commands);
    vkCmdClearDepthStencilImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &clear, 1, &part);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  });
  if (all & VK_IMAGE_ASPECT_DEPTH_BIT) {
    const double want = aspects & VK_IMAGE_ASPECT_DEPTH_BIT ? depth : 0.25;
    const std::vector<std::byte> got =
        download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, 0, VK_IMAGE_ASPECT_DEPTH_BIT);
    const uint32_t bytes = texel_bytes(format);
    for (size_t i = 0; i < got.size(); i += bytes) {
      uint32_t word = 0;
      std::memcpy(&word, got.data() + i, bytes);
      float as_float;
      std::memcpy(&as_float, &word, 4);
      const bool is_float = format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
      const double max = bytes == 2 ? 65535 : 16777215;
      const double value = is_float ? as_float : (bytes == 2 ? word : word & 0xFFFFFF) / max;
      expect(std::abs(value - want) <= (is_float ? 0 : 1 / max), fmt::format("depth {}, not {}", value, want));
    }
  }
  if (all & VK_IMAGE_ASPECT_STENCIL_BIT) {
    const uint32_t want = aspects & VK_IMAGE_ASPECT_STENCIL_BIT ? stencil & 0xFF : 0x3C;
    for (const std::byte b : download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, 0, VK_IMAGE_ASPECT_STENCIL_BIT)) {
      expect(std::to_integer<uint32_t>(b) == want, fmt::format("stencil {}, not {}", std::to_integer<int>(b), want));
    }
  }
}

// Rectangles inside a render pass, of each of two attachments, after a draw and before another one.
void run_clear_attachments(Device& device, const FormatInfo& info, const std::vector<VkRect2D>& rects, uint32_t attachment) {
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, "rendering to this format");
  constexpr uint32_t kSize = 20;
  ImageDesc desc;
  desc.format = info.format;
  desc.extent = {kSize, kSize, 1};
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image images[2] = {create_image(device, desc), create_image(device, desc)};
  Target target;
  for (const Image& image : images) target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  const ClearValue& value = info.is_integer() ? kIntegerClears[2] : kFloatClears[2];
  DrawState state;
  state.vertex = fullscreen_vertex();
  const char* type = info.is_integer() ? (info.is_signed() ? "ivec4" : "uvec4") : "vec4";
  state.fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, fmt::format("layout(location = 0) out {0} a; layout(location = 1) out {0} b;"
                                                             "void main() {{ a = {0}(1); b = {0}(1); }}",
                                                             type));
  DrawState clearing = state;
  clearing.scissors = {{{{0, 0}, {1, 1}}}};  // clears are not scissored
  clearing.draw = [&](VkCommandBuffer commands) {
    vkCmdDraw(commands, 3, 1, 0, 0);
    VkClearAttachment clear{VK_IMAGE_ASPECT_COLOR_BIT, attachment, {.color = to_vulkan(info, value)}};
    std::vector<VkClearRect> list;
    for (const VkRect2D& r : rects) list.push_back({r, 0, 1});
    vkCmdClearAttachments(commands, 1, &clear, static_cast<uint32_t>(list.size()), list.data());
  };
  Pass pass(device, target);
  pass.add(state);
  pass.add(clearing);
  pass.run();
  for (uint32_t i = 0; i < 2; ++i) {
    const std::vector<std::byte> got = download(device, images[i], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    for (uint32_t at = 0; at < kSize * kSize; ++at) {
      const uint32_t x = at % kSize, y = at / kSize;
      bool cleared = false;
      for (const VkRect2D& r : rects) {
        cleared |= x >= static_cast<uint32_t>(r.offset.x) && x < r.offset.x + r.extent.width &&
                   y >= static_cast<uint32_t>(r.offset.y) && y < r.offset.y + r.extent.height;
      }
      cleared &= i == attachment;
      const Colour want = cleared ? Colour{value.value[0], value.value[1], value.value[2], value.value[3]} : Colour{1, 1, 1, 1};
      expect_colour(info, got.data() + at * info.bytes, want, info.is_integer() ? 0 : 1,
                    fmt::format("attachment {}, {}, {}", i, x, y));
    }
  }
}

}  // namespace

void register_api_clear() {
  for (const FormatInfo& info : colour_formats()) {
    const std::span<const ClearValue> values =
        info.is_integer() ? std::span<const ClearValue>(kIntegerClears) : std::span<const ClearValue>(kFloatClears);
    for (const ClearValue& value : values) {
      add_case("api.image_clearing.color", fmt::format("{}.{}", info.name, value.name),
               "18.1 Clearing Images Outside a Render Pass",
               [&info, &value](Device& device) { run_clear_image(device, info, value, kRanges[0]); });
    }
  }
  for (const Range& range : kRanges) {
    for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32_UINT, VK_FORMAT_R16G16B16A16_SFLOAT}) {
      const FormatInfo& info = info_of(format);
      add_case("api.image_clearing.color", fmt::format("range_{}_{}", range.name, info.name),
               "18.1 Clearing Images Outside a Render Pass", [&](Device& device) {
                 run_clear_image(device, info, info.is_integer() ? kIntegerClears[2] : kFloatClears[2], range);
               });
    }
  }
  static constexpr std::pair<VkFormat, const char*> kDepths[] = {{VK_FORMAT_D16_UNORM, "d16"},
                                                                 {VK_FORMAT_X8_D24_UNORM_PACK32, "x8_d24"},
                                                                 {VK_FORMAT_D32_SFLOAT, "d32"},
                                                                 {VK_FORMAT_S8_UINT, "s8"},
                                                                 {VK_FORMAT_D24_UNORM_S8_UINT, "d24_s8"},
                                                                 {VK_FORMAT_D32_SFLOAT_S8_UINT, "d32_s8"},
                                                                 {VK_FORMAT_D16_UNORM_S8_UINT, "d16_s8"}};
  for (const auto& [format, name] : kDepths) {
    for (const VkImageAspectFlags aspects : {1, 2, 3}) {
      const VkImageAspectFlags mask =
          (aspects & 1 ? VK_IMAGE_ASPECT_DEPTH_BIT : 0) | (aspects & 2 ? VK_IMAGE_ASPECT_STENCIL_BIT : 0);
      if ((aspects_of(format) & mask) != mask) continue;
      for (const auto& [depth, stencil] : {std::pair{0.0f, 0u}, {1.0f, 255u}, {0.7f, 0x5Au}}) {
        add_case("api.image_clearing.depth_stencil", fmt::format("{}_aspects_{}_{}_{}", name, aspects, depth, stencil),
                 "18.1 Clearing Images Outside a Render Pass",
                 [=, format = format, depth = depth, stencil = stencil](Device& device) {
                   run_clear_depth(device, format, mask, depth, stencil);
                 });
      }
    }
  }
  const std::vector<std::pair<const char*, std::vector<VkRect2D>>> rects = {{"whole", {{{0, 0}, {20, 20}}}},
                                                                            {"part", {{{3, 4}, {9, 5}}}},
                                                                            {"two", {{{0, 0}, {5, 5}}, {{10, 12}, {10, 8}}}},
                                                                            {"texel", {{{19, 19}, {1, 1}}}}};
  for (const VkFormat format :
       {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32G32B32A32_UINT, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8_SINT,
        VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R5G6B5_UNORM_PACK16}) {
    for (const auto& [name, list] : rects) {
      for (const uint32_t attachment : {0u, 1u}) {
        const FormatInfo& info = info_of(format);
        add_case("api.image_clearing.attachments", fmt::format("{}_{}_{}", info.name, name, attachment),
                 "18.2 Clearing Images Inside a Render Pass",
                 [&info, list = list, attachment](Device& device) { run_clear_attachments(device, info, list, attachment); });
      }
    }
  }
}

}  // namespace pineda::cts
