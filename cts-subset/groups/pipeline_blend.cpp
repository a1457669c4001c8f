// pipeline.blend: every factor and operation, on every format that the driver blends, against the equations in double precision.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/blend.h"
#include "cts-subset/reference/compare.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;
constexpr const char* kSection = "29.1 Blending: 29.1.1 Blend Factors, 29.1.3 Blend Operations";

struct Factor {
  VkBlendFactor value;
  const char* name;
  bool dual_source = false;
};

constexpr Factor kFactors[] = {
    {VK_BLEND_FACTOR_ZERO, "zero"},
    {VK_BLEND_FACTOR_ONE, "one"},
    {VK_BLEND_FACTOR_SRC_COLOR, "src_color"},
    {VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR, "one_minus_src_color"},
    {VK_BLEND_FACTOR_DST_COLOR, "dst_color"},
    {VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR, "one_minus_dst_color"},
    {VK_BLEND_FACTOR_SRC_ALPHA, "src_alpha"},
    {VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, "one_minus_src_alpha"},
    {VK_BLEND_FACTOR_DST_ALPHA, "dst_alpha"},
    {VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA, "one_minus_dst_alpha"},
    {VK_BLEND_FACTOR_CONSTANT_COLOR, "constant_color"},
    {VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR, "one_minus_constant_color"},
    {VK_BLEND_FACTOR_CONSTANT_ALPHA, "constant_alpha"},
    {VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA, "one_minus_constant_alpha"},
    {VK_BLEND_FACTOR_SRC_ALPHA_SATURATE, "src_alpha_saturate"},
    {VK_BLEND_FACTOR_SRC1_COLOR, "src1_color", true},
    {VK_BLEND_FACTOR_ONE_MINUS_SRC1_COLOR, "one_minus_src1_color", true},
    {VK_BLEND_FACTOR_SRC1_ALPHA, "src1_alpha", true},
    {VK_BLEND_FACTOR_ONE_MINUS_SRC1_ALPHA, "one_minus_src1_alpha", true},
};

struct Operation {
  VkBlendOp value;
  const char* name;
};
constexpr Operation kOperations[] = {{VK_BLEND_OP_ADD, "add"},
                                     {VK_BLEND_OP_SUBTRACT, "subtract"},
                                     {VK_BLEND_OP_REVERSE_SUBTRACT, "reverse_subtract"},
                                     {VK_BLEND_OP_MIN, "min"},
                                     {VK_BLEND_OP_MAX, "max"}};

constexpr std::array<float, 4> kConstants{0.25f, 0.625f, 0.875f, 0.4375f};

// Colours in multiples of 1/16, so that the shader's floats are exact.
Colour source_colour(uint32_t x, uint32_t y) {
  return {x / 16.0, y / 16.0, ((x + y) % 17) / 16.0, ((x * 5 + y * 3) % 17) / 16.0};
}
Colour second_colour(uint32_t x, uint32_t y) {
  return {y / 16.0, ((x * 7 + y) % 17) / 16.0, x / 16.0, ((x + 11 * y) % 17) / 16.0};
}

Spirv source_shader(bool dual) {
  std::string outputs = "layout(location = 0) out vec4 colour;\n", stores;
  if (dual) {
    outputs = "layout(location = 0, index = 0) out vec4 colour;\nlayout(location = 0, index = 1) out vec4 second;\n";
    stores = "second = vec4(p.y, (p.x * 7u + p.y) % 17u, p.x, (p.x + 11u * p.y) % 17u) / 16.0;";
  }
  return compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                      outputs +
                          "void main() { uvec2 p = uvec2(gl_FragCoord.xy);"
                          "colour = vec4(p.x, p.y, (p.x + p.y) % 17u, (p.x * 5u + p.y * 3u) % 17u) / 16.0;" +
                          stores + "}");
}

struct Equation {
  Factor source, destination;
  Operation operation;
  Factor source_alpha, destination_alpha;
  Operation operation_alpha;
};

VkPipelineColorBlendAttachmentState state_of(const Equation& e) {
  return {VK_TRUE,
          e.source.value,
          e.destination.value,
          e.operation.value,
          e.source_alpha.value,
          e.destination_alpha.value,
          e.operation_alpha.value,
          0xF};
}

void run(Device& device, const FormatInfo& info, const Equation& equation) {
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT,
          "blending to this format");
  const bool dual = equation.source.dual_source || equation.destination.dual_source;
  require(!dual || device.caps().features.dualSrcBlend, "dualSrcBlend");

  std::vector<std::byte> destination(kSize * kSize * info.bytes);
  Random random(info.name);
  for (size_t i = 0; i < kSize * kSize; ++i) {
    Colour colour{random.unit(), random.unit(), random.unit(), random.unit()};
    if (info.is_signed()) colour[0] = colour[0] * 2 - 1, colour[1] = colour[1] * 2 - 1;
    encode(info, colour, destination.data() + i * info.bytes);
  }
  ImageDesc desc;
  desc.format = info.format;
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image image = create_image(device, desc);
  upload(device, image, destination, 0, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_LOAD, {}});
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment = source_shader(dual);
  state.blend = {state_of(equation)};
  state.blend_constants = kConstants;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const std::vector<std::byte> result = download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);

  Colour constants;
  std::ranges::copy(kConstants, constants.begin());
  // "the components of the source and destination values and blend factors are each clamped" for fixed-point attachments
  const Channel& channel = info.channels.front();
  const auto factor = [&](const Factor& f, size_t c, const Colour& s, const Colour& s1, const Colour& d) {
    const double value = blend_factor(f.value, c, s, s1, d, constants);
    return channel.numeric == Numeric::kSfloat || channel.numeric == Numeric::kUfloat ? value : clamp_to(channel, value);
  };
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    const Colour s = source_colour(i % kSize, i / kSize), s1 = second_colour(i % kSize, i / kSize);
    const Colour d = decode(info, destination.data() + i * info.bytes);
    Colour want{};
    for (size_t c = 0; c < 4; ++c) {
      const Factor& fs = c == 3 ? equation.source_alpha : equation.source;
      const Factor& fd = c == 3 ? equation.destination_alpha : equation.destination;
      want[c] = blended((c == 3 ? equation.operation_alpha : equation.operation).value, s[c], factor(fs, c, s, s1, d), d[c],
                        factor(fd, c, s, s1, d));
    }
    // One step for the conversion, one for computing at no more than the destination's precision.
    expect_colour(info, result.data() + i * info.bytes, want, 2, fmt::format("pixel {}, {}", i % kSize, i / kSize), 2);
  }
}

void add(const FormatInfo& info, const std::string& name, const Equation& equation) {
  add_case("pipeline.blend", fmt::format("{}.{}", info.name, name), kSection,
           [&info, equation](Device& device) { run(device, info, equation); });
}

bool may_blend(const FormatInfo& info) {
  const Numeric n = info.channels[0].numeric;
  return info.format != VK_FORMAT_E5B9G9R9_UFLOAT_PACK32 && info.bytes != 3 && info.bytes != 6 && info.bytes != 12 &&
         (n == Numeric::kUnorm || n == Numeric::kSnorm || n == Numeric::kSrgb || n == Numeric::kSfloat || n == Numeric::kUfloat);
}

}  // namespace

void register_pipeline_blend() {
  const Operation add_op = kOperations[0];
  for (const Factor& source : kFactors) {
    for (const Factor& destination : kFactors) {
      add(info_of(VK_FORMAT_R8G8B8A8_UNORM), fmt::format("{}.{}", source.name, destination.name),
          {source, destination, add_op, source, destination, add_op});
    }
  }
  for (const FormatInfo& info : colour_formats()) {
    if (!may_blend(info)) continue;
    for (const Operation& operation : kOperations) {
      const Operation other = kOperations[(static_cast<size_t>(&operation - kOperations) + 2) % std::size(kOperations)];
      add(info, fmt::format("op_{}", operation.name), {kFactors[6], kFactors[7], operation, kFactors[1], kFactors[9], other});
    }
    for (size_t i = 0; i + 1 < std::size(kFactors); i += 2) {  // each factor once, as source or destination
      add(info, fmt::format("factors_{}_{}", kFactors[i].name, kFactors[i + 1].name),
          {kFactors[i], kFactors[i + 1], add_op, kFactors[i + 1], kFactors[i], add_op});
    }
  }
}

}  // namespace pineda::cts
