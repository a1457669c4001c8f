// pipeline.depth and pipeline.stencil: each format, comparison and operation, against the rules applied pixel by pixel.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;
constexpr uint32_t kPixels = kSize * kSize;

struct CompareOp {
  VkCompareOp value;
  const char* name;
};
constexpr CompareOp kCompareOps[] = {{VK_COMPARE_OP_NEVER, "never"},
                                     {VK_COMPARE_OP_LESS, "less"},
                                     {VK_COMPARE_OP_EQUAL, "equal"},
                                     {VK_COMPARE_OP_LESS_OR_EQUAL, "less_or_equal"},
                                     {VK_COMPARE_OP_GREATER, "greater"},
                                     {VK_COMPARE_OP_NOT_EQUAL, "not_equal"},
                                     {VK_COMPARE_OP_GREATER_OR_EQUAL, "greater_or_equal"},
                                     {VK_COMPARE_OP_ALWAYS, "always"}};

bool holds(VkCompareOp op, uint32_t left, uint32_t right) {
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return false;
    case VK_COMPARE_OP_LESS:
      return left < right;
    case VK_COMPARE_OP_EQUAL:
      return left == right;
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return left <= right;
    case VK_COMPARE_OP_GREATER:
      return left > right;
    case VK_COMPARE_OP_NOT_EQUAL:
      return left != right;
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return left >= right;
    default:
      return true;
  }
}

struct DepthFormat {
  VkFormat format;
  const char* name;
  double steps;  // of a fixed-point depth; 0: float
};
constexpr DepthFormat kDepthFormats[] = {{VK_FORMAT_D16_UNORM, "d16", 65535},
                                         {VK_FORMAT_X8_D24_UNORM_PACK32, "x8_d24", 16777215},
                                         {VK_FORMAT_D32_SFLOAT, "d32", 0},
                                         {VK_FORMAT_D24_UNORM_S8_UINT, "d24_s8", 16777215},
                                         {VK_FORMAT_D32_SFLOAT_S8_UINT, "d32_s8", 0}};

Image create_depth(Device& device, VkFormat format) {
  require(device.format(format).optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, "this depth format");
  ImageDesc desc;
  desc.format = format;
  desc.usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  return create_image(device, desc);
}

Image create_colour(Device& device) {
  ImageDesc desc;
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  return create_image(device, desc);
}

// Depths are multiples of 1/255: far apart for every format, and equal ones stay equal.
uint32_t stored_depth(uint32_t i) { return i; }
uint32_t new_depth(uint32_t i) { return (i % kSize * 7 + i / kSize * 13) % 256; }

Spirv depth_shader(const char* formula) {
  return compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                      fmt::format("layout(location = 0) out vec4 colour; void main() {{ uvec2 p = uvec2(gl_FragCoord.xy);"
                                  "gl_FragDepth = float({}) / 255.0; colour = vec4(1.0); }}",
                                  formula));
}

double depth_in(const DepthFormat& format, uint32_t word) {
  if (format.steps == 0) return std::bit_cast<float>(word);
  return (word & static_cast<uint32_t>(format.steps)) / format.steps;
}

struct DepthCase {
  CompareOp op;
  bool write = true, test = true;
  bool bounds = false;
  float min_bound = 0.25f, max_bound = 0.75f;
};

void run_depth(Device& device, const DepthFormat& format, const DepthCase& c) {
  require(!c.bounds || device.caps().features.depthBounds, "depthBounds");
  const Image depth = create_depth(device, format.format), colour = create_colour(device);
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  target.depth_stencil = Attachment{&depth, VK_ATTACHMENT_LOAD_OP_CLEAR, {.depthStencil = {1.0f, 0}}};
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment = depth_shader("p.x + p.y * 16u");
  state.depth_stencil.depthTestEnable = state.depth_stencil.depthWriteEnable = VK_TRUE;
  state.blend = {VkPipelineColorBlendAttachmentState{}};  // the first draw writes depth only
  Pass pass(device, target);
  pass.add(state);
  state.fragment = depth_shader("(p.x * 7u + p.y * 13u) % 256u");
  state.depth_stencil.depthTestEnable = c.test;
  state.depth_stencil.depthWriteEnable = c.write;
  state.depth_stencil.depthCompareOp = c.op.value;
  state.depth_stencil.depthBoundsTestEnable = c.bounds;
  state.depth_stencil.minDepthBounds = c.min_bound;
  state.depth_stencil.maxDepthBounds = c.max_bound;
  state.blend.clear();
  pass.add(state);
  pass.run();
  const auto colours = download_as<uint32_t>(device, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const auto bytes = download(device, depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, 0, VK_IMAGE_ASPECT_DEPTH_BIT);
  const size_t texel_size = bytes.size() / kPixels;
  for (uint32_t i = 0; i < kPixels; ++i) {
    const double stored = stored_depth(i) / 255.0;
    const bool inside = !c.bounds || (stored >= c.min_bound && stored <= c.max_bound);
    const bool pass_test = inside && (!c.test || holds(c.op.value, new_depth(i), stored_depth(i)));
    expect((colours[i] != 0) == pass_test, fmt::format("pixel {}: depth {} {} {} {}", i, new_depth(i), c.op.name, stored_depth(i),
                                                       pass_test ? "failed" : "passed"));
    uint32_t word = 0;
    std::memcpy(&word, bytes.data() + i * texel_size, texel_size);
    const double want = (pass_test && c.write && c.test ? new_depth(i) : stored_depth(i)) / 255.0;
    const double step = format.steps ? 1 / format.steps : 0x1p-23;
    expect(std::abs(depth_in(format, word) - want) <= step,
           fmt::format("pixel {}: depth {}, not {}", i, depth_in(format, word), want));
  }
}

struct StencilOp {
  VkStencilOp value;
  const char* name;
};
constexpr StencilOp kStencilOps[] = {{VK_STENCIL_OP_KEEP, "keep"},
                                     {VK_STENCIL_OP_ZERO, "zero"},
                                     {VK_STENCIL_OP_REPLACE, "replace"},
                                     {VK_STENCIL_OP_INCREMENT_AND_CLAMP, "increment_and_clamp"},
                                     {VK_STENCIL_OP_DECREMENT_AND_CLAMP, "decrement_and_clamp"},
                                     {VK_STENCIL_OP_INVERT, "invert"},
                                     {VK_STENCIL_OP_INCREMENT_AND_WRAP, "increment_and_wrap"},
                                     {VK_STENCIL_OP_DECREMENT_AND_WRAP, "decrement_and_wrap"}};

uint32_t apply(VkStencilOp op, uint32_t stored, uint32_t reference) {
  switch (op) {
    case VK_STENCIL_OP_KEEP:
      return stored;
    case VK_STENCIL_OP_ZERO:
      return 0;
    case VK_STENCIL_OP_REPLACE:
      return reference & 0xFF;
    case VK_STENCIL_OP_INCREMENT_AND_CLAMP:
      return std::min(stored + 1, 255u);
    case VK_STENCIL_OP_DECREMENT_AND_CLAMP:
      return stored ? stored - 1 : 0;
    case VK_STENCIL_OP_INVERT:
      return ~stored & 0xFF;
    case VK_STENCIL_OP_INCREMENT_AND_WRAP:
      return (stored + 1) & 0xFF;
    default:
      return (stored - 1) & 0xFF;
  }
}

struct StencilCase {
  CompareOp compare;
  StencilOp fail, pass, depth_fail;
  uint32_t reference = 100, compare_mask = 0xFF, write_mask = 0xFF;
  bool back_face = false;
};

constexpr VkFormat kStencilFormats[] = {VK_FORMAT_S8_UINT, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT_S8_UINT};
constexpr const char* kStencilNames[] = {"s8", "d24_s8", "d32_s8"};

// Stencil values 0..255, one for each pixel; the left half fails the depth test where there is one.
void run_stencil(Device& device, VkFormat format, const StencilCase& c) {
  const Image depth = create_depth(device, format), colour = create_colour(device);
  const bool has_depth = format != VK_FORMAT_S8_UINT;
  std::vector<std::byte> values(kPixels);
  for (uint32_t i = 0; i < kPixels; ++i) values[i] = static_cast<std::byte>(i);
  if (has_depth) {
    std::vector<float> depths(kPixels, 0.5f);
    if (format == VK_FORMAT_D24_UNORM_S8_UINT) {
      std::vector<uint32_t> fixed(kPixels, 1u << 23);
      upload(device, depth, std::as_bytes(std::span(fixed)), 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_IMAGE_ASPECT_DEPTH_BIT);
    } else {
      upload(device, depth, std::as_bytes(std::span(depths)), 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_IMAGE_ASPECT_DEPTH_BIT);
    }
  }
  const Buffer staging = create_buffer(device, std::span<const std::byte>(values));
  device.run([&](VkCommandBuffer commands) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_STENCIL_BIT, 0, 0, 1};
    copy.imageExtent = {kSize, kSize, 1};
    transition(commands, depth, has_depth ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, depth.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, depth, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  });
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  target.depth_stencil = Attachment{&depth, VK_ATTACHMENT_LOAD_OP_LOAD, {}};
  DrawState state;
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                              fmt::format("void main() {{ int i = {}; vec2 p = vec2(i & 1, i >> 1) * 4.0 - 1.0;"
                                          "gl_Position = vec4(p, p.x < 2.0 ? 0.25 : 1.25, 1.0); }}",  // depth 0.5 at x = 0
                                          c.back_face ? "2 - gl_VertexIndex" : "gl_VertexIndex"));
  state.fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 colour; void main() { colour = vec4(1.0); }");
  state.rasterization.depthClampEnable = device.caps().features.depthClamp;
  state.depth_stencil.depthTestEnable = has_depth;
  state.depth_stencil.depthCompareOp = VK_COMPARE_OP_GREATER;
  state.depth_stencil.stencilTestEnable = VK_TRUE;
  const VkStencilOpState used{c.fail.value,   c.pass.value, c.depth_fail.value, c.compare.value,
                              c.compare_mask, c.write_mask, c.reference};
  const VkStencilOpState unused{VK_STENCIL_OP_ZERO, VK_STENCIL_OP_ZERO, VK_STENCIL_OP_ZERO, VK_COMPARE_OP_NEVER, 0xFF, 0xFF, 1};
  // With vertices (-1,-1), (3,-1), (-1,3) and y pointing down, the area is positive in the specification's sense: clockwise is
  // front.
  state.depth_stencil.front = c.back_face ? unused : used;
  state.depth_stencil.back = c.back_face ? used : unused;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const auto colours = download_as<uint32_t>(device, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const auto stencils =
      download_as<uint8_t>(device, depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, 0, VK_IMAGE_ASPECT_STENCIL_BIT);
  for (uint32_t i = 0; i < kPixels; ++i) {
    const bool stencil_pass = holds(c.compare.value, c.reference & c.compare_mask, i & c.compare_mask);
    const bool depth_pass = !has_depth || i % kSize >= kSize / 2;
    const StencilOp& op = !stencil_pass ? c.fail : depth_pass ? c.pass : c.depth_fail;
    const uint32_t want = (apply(op.value, i, c.reference) & c.write_mask) | (i & ~c.write_mask);
    expect((colours[i] != 0) == (stencil_pass && depth_pass), fmt::format("pixel {}: {}", i, colours[i] ? "drawn" : "not drawn"));
    expect(stencils[i] == want, fmt::format("stencil {} became {}, not {} ({})", i, stencils[i], want, op.name));
  }
}

}  // namespace

void register_pipeline_depth_stencil() {
  constexpr const char* kDepth = "28.11 Depth Test, 28.8 Depth Bounds Test";
  for (const DepthFormat& format : kDepthFormats) {
    const auto add = [&](const std::string& name, const DepthCase& c) {
      add_case("pipeline.depth", fmt::format("{}.{}", format.name, name), kDepth,
               [&format, c](Device& device) { run_depth(device, format, c); });
    };
    for (const CompareOp& op : kCompareOps) {
      add(op.name, {op});
      add(std::string(op.name) + "_no_write", {op, false});
      add(std::string(op.name) + "_bounds", {op, true, true, true});
    }
    add("test_off_writes_nothing", {kCompareOps[1], true, false});
    add("bounds_without_test", {kCompareOps[1], true, false, true});
  }
  constexpr const char* kStencil = "28.10 Stencil Test";
  for (size_t f = 0; f < std::size(kStencilFormats); ++f) {
    const VkFormat format = kStencilFormats[f];
    const auto add = [&](const std::string& name, const StencilCase& c) {
      add_case("pipeline.stencil", fmt::format("{}.{}", kStencilNames[f], name), kStencil,
               [format, c](Device& device) { run_stencil(device, format, c); });
    };
    for (size_t o = 0; o < std::size(kStencilOps); ++o) {
      const StencilOp &first = kStencilOps[o], &second = kStencilOps[(o + 3) % 8], &third = kStencilOps[(o + 5) % 8];
      for (const CompareOp& compare : kCompareOps) {
        add(fmt::format("fail_{}.pass_{}.depth_{}.{}", first.name, second.name, third.name, compare.name),
            {compare, first, second, third});
      }
      add(fmt::format("masks.{}", first.name), {kCompareOps[3], first, second, third, 0x5A, 0x3C, 0x77});
      add(fmt::format("back_face.{}", first.name), {kCompareOps[4], first, second, third, 77, 0xFF, 0xFF, true});
    }
  }
}

}  // namespace pineda::cts
