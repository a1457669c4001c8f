// api.copy_and_blit: copies between buffers and images of every format, regions with pitches and offsets, blits.
#include <fmt/format.h>

#include <algorithm>
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

std::vector<std::byte> random_bytes(Random& random, size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random.below(256));
  return bytes;
}

void run_buffer_copies(Device& device, const std::vector<VkBufferCopy>& regions) {
  Random random("buffers");
  const std::vector<std::byte> content = random_bytes(random, 4096);
  const Buffer source = create_buffer(device, std::span(content));
  const Buffer destination = create_buffer(device, 4096, kAnyBuffer, 0xCD);
  device.run([&](VkCommandBuffer commands) {
    vkCmdCopyBuffer(commands, source.handle, destination.handle, static_cast<uint32_t>(regions.size()), regions.data());
    full_barrier(commands);
  });
  std::vector<std::byte> want(4096, std::byte{0xCD});
  for (const VkBufferCopy& r : regions) std::memcpy(want.data() + r.dstOffset, content.data() + r.srcOffset, r.size);
  for (size_t i = 0; i < want.size(); ++i) expect(want[i] == destination.mapped[i], fmt::format("byte {}", i));
}

void run_fill(Device& device, VkDeviceSize offset, VkDeviceSize size, uint32_t word) {
  const Buffer buffer = create_buffer(device, 1022, kAnyBuffer, 0xCD);  // VK_WHOLE_SIZE rounds down to words
  device.run([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer.handle, offset, size, word);
    full_barrier(commands);
  });
  const VkDeviceSize end = size == VK_WHOLE_SIZE ? 1020 : offset + size;
  for (VkDeviceSize i = 0; i < 1022; ++i) {
    const auto want = i >= offset && i < end ? std::byte(word >> (i % 4 * 8)) : std::byte{0xCD};
    expect(buffer.mapped[i] == want, fmt::format("byte {}", i));
  }
}

void run_update(Device& device, VkDeviceSize offset, VkDeviceSize size) {
  Random random("update");
  std::vector<std::byte> content = random_bytes(random, size);
  const std::vector<std::byte> want = content;
  const Buffer buffer = create_buffer(device, offset + size + 4, kAnyBuffer, 0xCD);
  device.run([&](VkCommandBuffer commands) {
    vkCmdUpdateBuffer(commands, buffer.handle, offset, size, content.data());
    std::ranges::fill(content, std::byte{0});  // the data was copied when the command was recorded
    full_barrier(commands);
  });
  for (VkDeviceSize i = 0; i < buffer.size_bytes; ++i) {
    const std::byte w = i >= offset && i < offset + size ? want[i - offset] : std::byte{0xCD};
    expect(buffer.mapped[i] == w, fmt::format("byte {}", i));
  }
}

// A region of an image written from a buffer with its own pitch, and read back with another one.
struct RegionCase {
  const char* name;
  VkOffset3D offset;
  VkExtent3D extent;
  uint32_t row_texels, height_texels;  // of the buffer; 0: tight
  VkDeviceSize buffer_offset_texels;
};
constexpr RegionCase kRegions[] = {
    {"whole", {0, 0, 0}, {19, 13, 1}, 0, 0, 0},      {"one_texel", {7, 5, 0}, {1, 1, 1}, 0, 0, 3},
    {"column", {18, 0, 0}, {1, 13, 1}, 0, 0, 0},     {"row", {0, 12, 0}, {19, 1, 1}, 0, 0, 1},
    {"padded_rows", {2, 3, 0}, {9, 7, 1}, 23, 0, 0}, {"padded_both", {5, 1, 0}, {11, 4, 1}, 12, 9, 4},
};

void run_image_region(Device& device, const FormatInfo& info, const RegionCase& c) {
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_TRANSFER_DST_BIT ||
              device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT,
          "images of this format");
  Random random(c.name);
  ImageDesc desc;
  desc.format = info.format;
  desc.extent = {19, 13, 1};
  const Image image = create_image(device, desc);
  std::vector<std::byte> want = random_bytes(random, 19 * 13 * info.bytes);
  upload(device, image, want, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const uint32_t row = c.row_texels ? c.row_texels : c.extent.width;
  const size_t texels = c.buffer_offset_texels + size_t{row} * (c.height_texels ? c.height_texels : c.extent.height);
  const std::vector<std::byte> content = random_bytes(random, texels * info.bytes);
  const Buffer source = create_buffer(device, std::span(content));
  const Buffer back = create_buffer(device, texels * info.bytes, kAnyBuffer, 0xCD);
  VkBufferImageCopy copy{c.buffer_offset_texels * info.bytes,  c.row_texels, c.height_texels,
                         {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, c.offset,     c.extent};
  if (copy.bufferOffset % 4) copy.bufferOffset = 0;  // queues of other kinds than graphics and compute want multiples of 4
  device.run([&](VkCommandBuffer commands) {
    vkCmdCopyBufferToImage(commands, source.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    vkCmdCopyImageToBuffer(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, back.handle, 1, &copy);
    full_barrier(commands);
  });
  std::vector<std::byte> want_back(texels * info.bytes, std::byte{0xCD});
  for (uint32_t y = 0; y < c.extent.height; ++y) {
    const size_t at = copy.bufferOffset + size_t{y} * row * info.bytes, bytes = c.extent.width * info.bytes;
    std::memcpy(want.data() + ((c.offset.y + y) * 19 + c.offset.x) * info.bytes, content.data() + at, bytes);
    std::memcpy(want_back.data() + at, content.data() + at, bytes);
  }
  expect(!std::memcmp(back.mapped, want_back.data(), want_back.size()), "the buffer read back differs");
  const std::vector<std::byte> got = download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  expect(got == want, "the image differs");
}

// Image to image: formats of one size class, a region at other offsets, other levels and layers.
void run_image_to_image(Device& device, VkFormat from_format, VkFormat to_format, uint32_t level, uint32_t layer) {
  const FormatInfo& from_info = info_of(from_format);
  const FormatInfo& to_info = info_of(to_format);
  for (const FormatInfo* info : {&from_info, &to_info})
    require(device.format(info->format).optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "images of this format");
  Random random(fmt::format("{}{}", from_info.name, to_info.name));
  ImageDesc desc;
  desc.format = from_format;
  desc.extent = {32, 24, 1};
  desc.levels = 3, desc.layers = 3;
  const Image from = create_image(device, desc);
  desc.format = to_format;
  desc.extent = {21, 22, 1};
  desc.levels = 1, desc.layers = 2;
  const Image to = create_image(device, desc);
  upload(device, from, random_bytes(random, 32 * 24 * from_info.bytes), 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const VkExtent3D size = from.level_extent(level);
  const std::vector<std::byte> content = random_bytes(random, size.width * size.height * from_info.bytes);
  upload(device, from, content, level, layer, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  std::vector<std::byte> want = random_bytes(random, 21 * 22 * to_info.bytes);
  upload(device, to, want, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  upload(device, to, want, 0, 1, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const VkImageCopy region{
      {VK_IMAGE_ASPECT_COLOR_BIT, level, layer, 1}, {1, 2, 0}, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 1}, {9, 11, 0}, {5, 3, 1}};
  device.run([&](VkCommandBuffer commands) {
    vkCmdCopyImage(commands, from.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   1, &region);
  });
  for (uint32_t y = 0; y < 3; ++y) {
    std::memcpy(want.data() + ((11 + y) * 21 + 9) * to_info.bytes, content.data() + ((2 + y) * size.width + 1) * from_info.bytes,
                5 * from_info.bytes);
  }
  expect(download(device, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, 1) == want, "the destination differs");
}

// Slices of a 3D image against layers of a 2D array.
void run_slices(Device& device, bool to_3d) {
  Random random("slices");
  ImageDesc desc;
  desc.format = VK_FORMAT_R32_UINT;
  desc.extent = {6, 5, 4};
  desc.type = VK_IMAGE_TYPE_3D;
  desc.view_type = VK_IMAGE_VIEW_TYPE_3D;
  const Image volume = create_image(device, desc);
  desc.extent = {6, 5, 1};
  desc.type = VK_IMAGE_TYPE_2D;
  desc.layers = 4;
  const Image layers = create_image(device, desc);
  require(device.caps().api_version >= VK_API_VERSION_1_1 || device.has_extension(VK_KHR_MAINTENANCE_1_EXTENSION_NAME),
          "maintenance1");
  const std::vector<std::byte> content = random_bytes(random, 6 * 5 * 4 * 4);
  const Buffer out = create_buffer(device, content.size());
  const Buffer in = create_buffer(device, std::span(content));
  const VkImageSubresourceLayers whole_3d{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, whole_2d{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 4};
  const Image& first = to_3d ? layers : volume;
  const Image& second = to_3d ? volume : layers;
  const auto whole = [&](const Image& image) {
    return VkBufferImageCopy{0, 0, 0, &image == &volume ? whole_3d : whole_2d, {0, 0, 0}, image.desc.extent};
  };
  device.run([&](VkCommandBuffer commands) {
    for (const Image* image : {&first, &second})
      transition(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const VkBufferImageCopy copy_in = whole(first), copy_out = whole(second);
    vkCmdCopyBufferToImage(commands, in.handle, first.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy_in);
    transition(commands, first, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkImageCopy copy{to_3d ? whole_2d : whole_3d, {0, 0, 0}, to_3d ? whole_3d : whole_2d, {0, 0, 0}, {6, 5, 4}};
    vkCmdCopyImage(commands, first.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, second.handle,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, second, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    vkCmdCopyImageToBuffer(commands, second.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out.handle, 1, &copy_out);
    full_barrier(commands);
  });
  expect(!std::memcmp(out.mapped, content.data(), content.size()), "slices and layers differ");
}

// Blits: the destination's texel centre, scaled into the source ("Image Copies with Scaling").
struct BlitCase {
  VkFormat from, to;
  VkFilter filter;
  std::array<int32_t, 4> source, destination;  // x0 y0 x1 y1
};
constexpr int32_t kFromSize = 17, kToSize = 23;

// sRGB may be decoded to within half of a code, where the curve is steepest 2.27 / 255 / 2 (the specification leaves it open;
// this is what Direct3D 11's functional specification demands).
double decode_slack(const FormatInfo& info) { return info.channels[0].numeric == Numeric::kSrgb ? 0.00445 : 0; }

void run_blit(Device& device, const BlitCase& c) {
  const FormatInfo& from_info = info_of(c.from);
  const FormatInfo& to_info = info_of(c.to);
  const VkFormatFeatureFlags need =
      VK_FORMAT_FEATURE_BLIT_SRC_BIT | (c.filter == VK_FILTER_LINEAR ? VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT : 0);
  require((device.format(c.from).optimalTilingFeatures & need) == need, "blits from this format");
  require(device.format(c.to).optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_DST_BIT, "blits to this format");
  Random random(fmt::format("{}{}", from_info.name, to_info.name));
  ImageDesc desc;
  desc.format = c.from;
  desc.extent = {kFromSize, kFromSize, 1};
  const Image from = create_image(device, desc);
  desc.format = c.to;
  desc.extent = {kToSize, kToSize, 1};
  const Image to = create_image(device, desc);
  std::vector<std::byte> texels(kFromSize * kFromSize * from_info.bytes);
  for (size_t i = 0; i < texels.size(); i += from_info.bytes) {
    Colour colour;
    for (double& v : colour) v = from_info.is_integer() ? random.below(100) : random.unit();
    encode(from_info, colour, texels.data() + i);
  }
  upload(device, from, texels, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const std::vector<std::byte> before(kToSize * kToSize * to_info.bytes);
  upload(device, to, before, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const auto& [sx0, sy0, sx1, sy1] = c.source;
  const auto& [dx0, dy0, dx1, dy1] = c.destination;
  const VkImageBlit region{{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                           {{sx0, sy0, 0}, {sx1, sy1, 1}},
                           {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                           {{dx0, dy0, 0}, {dx1, dy1, 1}}};
  device.run([&](VkCommandBuffer commands) {
    vkCmdBlitImage(commands, from.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                   1, &region, c.filter);
  });
  const std::vector<std::byte> got = download(device, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const auto texel = [&](int x, int y) {
    x = std::clamp(x, 0, kFromSize - 1), y = std::clamp(y, 0, kFromSize - 1);
    return decode(from_info, texels.data() + static_cast<size_t>(y * kFromSize + x) * from_info.bytes);
  };
  const auto scale = [](double d, int32_t d0, int32_t d1, int32_t s0, int32_t s1) {
    return (d - d0) * (s1 - s0) / (d1 - d0) + s0;
  };
  for (int y = 0; y < kToSize; ++y) {
    for (int x = 0; x < kToSize; ++x) {
      const std::byte* at = got.data() + static_cast<size_t>(y * kToSize + x) * to_info.bytes;
      const std::string where = fmt::format("texel {}, {}", x, y);
      if (x < std::min(dx0, dx1) || x >= std::max(dx0, dx1) || y < std::min(dy0, dy1) || y >= std::max(dy0, dy1)) {
        expect(std::all_of(at, at + to_info.bytes, [](std::byte b) { return b == std::byte{0}; }), where + " was written");
        continue;
      }
      const double u = scale(x + 0.5, dx0, dx1, sx0, sx1), v = scale(y + 0.5, dy0, dy1, sy0, sy1);
      if (c.filter == VK_FILTER_NEAREST) {
        if (std::abs(u - std::round(u)) < 1e-4 || std::abs(v - std::round(v)) < 1e-4) continue;  // between two texels
        expect_colour(to_info, at, texel(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v))),
                      to_info.is_integer() ? 0 : 2 + decode_slack(from_info) / step_of(to_info.channels[0], 1.0 / 64), where);
      } else {
        const double fu = u - 0.5, fv = v - 0.5, wx = fu - std::floor(fu), wy = fv - std::floor(fv);
        const int ix = static_cast<int>(std::floor(fu)), iy = static_cast<int>(std::floor(fv));
        Colour want{};
        for (int k = 0; k < 4; ++k) {
          const Colour t = texel(ix + (k & 1), iy + (k >> 1));
          for (size_t i = 0; i < 4; ++i) want[i] += t[i] * ((k & 1) ? wx : 1 - wx) * ((k >> 1) ? wy : 1 - wy);
        }
        // Each of the two weights has subTexelPrecisionBits and may be cut off there.
        const double slack = 2 * std::exp2(-static_cast<double>(device.limits().subTexelPrecisionBits)) + decode_slack(from_info);
        expect_colour(to_info, at, want, 1.5 + slack / step_of(to_info.channels[0], 1.0 / 64), where);
      }
    }
  }
}

}  // namespace

void register_api_copy() {
  constexpr const char* kBuffers = "19.2 Copying Data Between Buffers";
  const std::vector<std::pair<const char*, std::vector<VkBufferCopy>>> copies = {
      {"whole", {{0, 0, 4096}}},
      {"one_byte", {{17, 4095, 1}}},
      {"odd", {{3, 5, 1001}}},
      {"two", {{0, 100, 50}, {2000, 0, 99}}},
      {"many", {{1, 2, 3}, {10, 20, 30}, {100, 200, 300}, {1000, 2000, 1500}}}};
  for (const auto& [name, regions] : copies) {
    add_case("api.copy_and_blit.buffer_to_buffer", name, kBuffers,
             [regions = regions](Device& device) { run_buffer_copies(device, regions); });
  }
  for (const auto& [offset, size] :
       {std::pair<VkDeviceSize, VkDeviceSize>{0, VK_WHOLE_SIZE}, {4, VK_WHOLE_SIZE}, {0, 4}, {12, 500}, {1016, 4}}) {
    for (const uint32_t word : {0u, 0x01020304u, 0xFFFFFFFFu}) {
      add_case("api.fill_and_update_buffer", fmt::format("fill_{}_{}_{:x}", offset, size == VK_WHOLE_SIZE ? 0 : size, word),
               "18.4 Filling Buffers",
               [=, offset = offset, size = size](Device& device) { run_fill(device, offset, size, word); });
    }
  }
  for (const auto& [offset, size] : {std::pair<VkDeviceSize, VkDeviceSize>{0, 4}, {8, 100}, {4, 65536}}) {
    add_case("api.fill_and_update_buffer", fmt::format("update_{}_{}", offset, size), "18.5 Updating Buffers",
             [offset = offset, size = size](Device& device) { run_update(device, offset, size); });
  }
  for (const FormatInfo& info : colour_formats()) {
    for (const RegionCase& c : kRegions) {
      add_case("api.copy_and_blit.buffer_and_image", fmt::format("{}.{}", info.name, c.name),
               "19.4 Copying Data Between Buffers and Images", [&](Device& device) { run_image_region(device, info, c); });
    }
  }
  constexpr const char* kImages = "19.3 Copying Data Between Images";
  const std::vector<std::vector<VkFormat>> classes = {
      {VK_FORMAT_R8_UNORM, VK_FORMAT_R8_UINT, VK_FORMAT_R8_SNORM},
      {VK_FORMAT_R8G8_UNORM, VK_FORMAT_R16_SFLOAT, VK_FORMAT_R5G6B5_UNORM_PACK16},
      {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32_SFLOAT, VK_FORMAT_R16G16_UINT, VK_FORMAT_B8G8R8A8_SRGB},
      {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32_UINT},
      {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32G32B32A32_UINT}};
  for (const auto& formats : classes) {
    for (const VkFormat from : formats) {
      for (const VkFormat to : formats) {
        for (const auto& [level, layer] : {std::pair{0u, 0u}, {1u, 2u}}) {
          add_case("api.copy_and_blit.image_to_image",
                   fmt::format("{}_to_{}_level_{}_layer_{}", info_of(from).name, info_of(to).name, level, layer), kImages,
                   [=, level = level, layer = layer](Device& device) { run_image_to_image(device, from, to, level, layer); });
        }
      }
    }
  }
  for (const bool to_3d : {false, true}) {
    add_case("api.copy_and_blit.image_to_image", to_3d ? "layers_to_slices" : "slices_to_layers", kImages,
             [to_3d](Device& device) { run_slices(device, to_3d); });
  }
  static constexpr std::pair<const char*, std::array<int32_t, 8>> kBlits[] = {
      {"same_size", {0, 0, 17, 17, 3, 3, 20, 20}}, {"up", {0, 0, 17, 17, 0, 0, 23, 23}},
      {"down", {0, 0, 17, 17, 5, 6, 12, 15}},      {"mirror_x", {0, 0, 17, 17, 20, 0, 3, 23}},
      {"mirror_y", {2, 15, 16, 1, 1, 1, 20, 20}},  {"part", {4, 5, 9, 11, 2, 3, 21, 19}},
      {"one_texel", {8, 8, 9, 9, 0, 0, 23, 23}}};
  static constexpr std::pair<VkFormat, VkFormat> kPairs[] = {
      {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM},      {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM},
      {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R5G6B5_UNORM_PACK16}, {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM},
      {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32G32B32A32_SFLOAT}, {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT},
      {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R8_UNORM},  {VK_FORMAT_R32_UINT, VK_FORMAT_R8_UINT},
      {VK_FORMAT_R8G8B8A8_SNORM, VK_FORMAT_R16G16B16A16_SFLOAT}, {VK_FORMAT_B10G11R11_UFLOAT_PACK32, VK_FORMAT_R8G8B8A8_UNORM}};
  for (const auto& [from, to] : kPairs) {
    for (const auto& [name, r] : kBlits) {
      for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
        if (filter == VK_FILTER_LINEAR && info_of(from).is_integer()) continue;
        const BlitCase c{from, to, filter, {r[0], r[1], r[2], r[3]}, {r[4], r[5], r[6], r[7]}};
        add_case("api.copy_and_blit.blit_image",
                 fmt::format("{}_to_{}.{}_{}", info_of(from).name, info_of(to).name, name,
                             filter == VK_FILTER_LINEAR ? "linear" : "nearest"),
                 "19.5 Image Copies with Scaling", [c](Device& device) { run_blit(device, c); });
      }
    }
  }
}

}  // namespace pineda::cts
