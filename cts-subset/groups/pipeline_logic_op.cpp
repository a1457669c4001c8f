// pipeline.logic_op: the sixteen operations on integer and normalised formats; other formats ignore them.
#include <fmt/format.h>

#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/formats.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

struct LogicOp {
  VkLogicOp value;
  const char* name;
  uint32_t (*apply)(uint32_t s, uint32_t d);
};

constexpr LogicOp kLogicOps[] = {
    {VK_LOGIC_OP_CLEAR, "clear", [](uint32_t, uint32_t) { return 0u; }},
    {VK_LOGIC_OP_AND, "and", [](uint32_t s, uint32_t d) { return s & d; }},
    {VK_LOGIC_OP_AND_REVERSE, "and_reverse", [](uint32_t s, uint32_t d) { return s & ~d; }},
    {VK_LOGIC_OP_COPY, "copy", [](uint32_t s, uint32_t) { return s; }},
    {VK_LOGIC_OP_AND_INVERTED, "and_inverted", [](uint32_t s, uint32_t d) { return ~s & d; }},
    {VK_LOGIC_OP_NO_OP, "no_op", [](uint32_t, uint32_t d) { return d; }},
    {VK_LOGIC_OP_XOR, "xor", [](uint32_t s, uint32_t d) { return s ^ d; }},
    {VK_LOGIC_OP_OR, "or", [](uint32_t s, uint32_t d) { return s | d; }},
    {VK_LOGIC_OP_NOR, "nor", [](uint32_t s, uint32_t d) { return ~(s | d); }},
    {VK_LOGIC_OP_EQUIVALENT, "equivalent", [](uint32_t s, uint32_t d) { return ~(s ^ d); }},
    {VK_LOGIC_OP_INVERT, "invert", [](uint32_t, uint32_t d) { return ~d; }},
    {VK_LOGIC_OP_OR_REVERSE, "or_reverse", [](uint32_t s, uint32_t d) { return s | ~d; }},
    {VK_LOGIC_OP_COPY_INVERTED, "copy_inverted", [](uint32_t s, uint32_t) { return ~s; }},
    {VK_LOGIC_OP_OR_INVERTED, "or_inverted", [](uint32_t s, uint32_t d) { return ~s | d; }},
    {VK_LOGIC_OP_NAND, "nand", [](uint32_t s, uint32_t d) { return ~(s & d); }},
    {VK_LOGIC_OP_SET, "set", [](uint32_t, uint32_t) { return ~0u; }},
};

constexpr VkFormat kFormats[] = {VK_FORMAT_R8_UINT,
                                 VK_FORMAT_R8G8B8A8_UINT,
                                 VK_FORMAT_R16G16_UINT,
                                 VK_FORMAT_R32_UINT,
                                 VK_FORMAT_R32G32B32A32_UINT,
                                 VK_FORMAT_R8G8B8A8_UNORM,
                                 VK_FORMAT_R16_UNORM,
                                 VK_FORMAT_B8G8R8A8_UNORM,
                                 VK_FORMAT_R5G6B5_UNORM_PACK16,
                                 VK_FORMAT_A2B10G10R10_UNORM_PACK32};

constexpr uint32_t kSize = 16;

// Source and destination texels are random bits; the shader gets the source as numbers that convert to just these bits.
void run(Device& device, const FormatInfo& info, const LogicOp& op) {
  require(device.caps().features.logicOp, "logicOp");
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, "rendering to this format");
  Random random(op.name);
  std::vector<std::byte> destination(kSize * kSize * info.bytes), source(destination.size());
  for (std::byte& b : destination) b = static_cast<std::byte>(random.below(256));
  for (std::byte& b : source) b = static_cast<std::byte>(random.below(256));
  ImageDesc desc;
  desc.format = info.format;
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image image = create_image(device, desc);
  upload(device, image, destination, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);

  std::vector<uint32_t> numbers(kSize * kSize * 4);
  for (size_t i = 0; i < kSize * kSize; ++i) {
    const Colour colour = decode(info, source.data() + i * info.bytes);
    for (size_t c = 0; c < 4; ++c) {
      const float as_float = static_cast<float>(colour[c]);
      numbers[i * 4 + c] = info.is_integer() ? static_cast<uint32_t>(colour[c]) : std::bit_cast<uint32_t>(as_float);
    }
  }
  const Buffer colours = create_buffer(device, numbers);
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment = compile_glsl(
      VK_SHADER_STAGE_FRAGMENT_BIT,
      fmt::format("layout(binding = 0, std430) readonly buffer B {{ uvec4 colours[]; }};\n"
                  "layout(location = 0) out {} colour;\n"
                  "void main() {{ uvec4 c = colours[uint(gl_FragCoord.y) * 16u + uint(gl_FragCoord.x)]; colour = {}; }}",
                  info.is_integer() ? "uvec4" : "vec4", info.is_integer() ? "c" : "uintBitsToFloat(c)"));
  state.logic_op = op.value;
  state.resources.descriptors.push_back(storage_buffer(0, colours));
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_LOAD, {}});
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const std::vector<std::byte> result = download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  for (size_t i = 0; i < result.size(); ++i) {
    const uint32_t want = op.apply(std::to_integer<uint32_t>(source[i]), std::to_integer<uint32_t>(destination[i])) & 0xFF;
    expect(std::to_integer<uint32_t>(result[i]) == want,
           fmt::format("byte {}: {:#x} {} {:#x} gave {:#x}, not {:#x}", i, std::to_integer<int>(source[i]), op.name,
                       std::to_integer<int>(destination[i]), std::to_integer<int>(result[i]), want));
  }
}

}  // namespace

void register_pipeline_logic_op() {
  for (const VkFormat format : kFormats) {
    for (const LogicOp& op : kLogicOps) {
      const FormatInfo& info = info_of(format);
      add_case("pipeline.logic_op", fmt::format("{}.{}", info.name, op.name), "29.2 Logical Operations",
               [&info, &op](Device& device) { run(device, info, op); });
    }
  }
}

}  // namespace pineda::cts
