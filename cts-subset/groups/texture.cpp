// texture.*: filters, address modes, level selection, shapes, comparisons and gathers, against reference/texture.
#include "cts-subset/reference/texture.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/evaluate.h"
#include "cts-subset/reference/compare.h"
#include "cts-subset/reference/float32.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

struct ShapeInfo {
  Shape shape;
  const char* name;
  const char* glsl;  // behind "sampler"
  VkImageType type;
  VkImageViewType view;
  int coordinates, layers;
};
constexpr ShapeInfo kShapes[] = {
    {Shape::k1D, "1d", "1D", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D, 1, 1},
    {Shape::k2D, "2d", "2D", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D, 2, 1},
    {Shape::k3D, "3d", "3D", VK_IMAGE_TYPE_3D, VK_IMAGE_VIEW_TYPE_3D, 3, 1},
    {Shape::kCube, "cube", "Cube", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE, 3, 6},
    {Shape::k1DArray, "1d_array", "1DArray", VK_IMAGE_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D_ARRAY, 2, 3},
    {Shape::k2DArray, "2d_array", "2DArray", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 3, 3},
    {Shape::kCubeArray, "cube_array", "CubeArray", VK_IMAGE_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE_ARRAY, 4, 12},
};
const ShapeInfo& shape_info(Shape shape) { return kShapes[static_cast<size_t>(shape)]; }

struct AddressMode {
  VkSamplerAddressMode value;
  const char* name;
};
constexpr AddressMode kAddressModes[] = {{VK_SAMPLER_ADDRESS_MODE_REPEAT, "repeat"},
                                         {VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT, "mirrored_repeat"},
                                         {VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE, "clamp_to_edge"},
                                         {VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER, "clamp_to_border"},
                                         {VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE, "mirror_clamp_to_edge"}};

enum class Op { kLod, kGrad, kLodOffset, kGather, kGatherOffset, kProjective };

struct TextureCase {
  Shape shape = Shape::k2D;
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  SamplerState state;
  Op op = Op::kLod;
  size_t component = 0;
  VkBorderColor border = VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK;
  VkShaderStageFlagBits stage = VK_SHADER_STAGE_FRAGMENT_BIT;
};

// Sizes are not powers of two, so that no rounding is hidden.
VkExtent3D base_extent(Shape shape) {
  switch (shape) {
    case Shape::k1D:
    case Shape::k1DArray:
      return {13, 1, 1};
    case Shape::k3D:
      return {7, 6, 5};
    case Shape::kCube:
    case Shape::kCubeArray:
      return {10, 10, 1};
    default:
      return {13, 11, 1};
  }
}

Image create_texture(Device& device, const TextureCase& c, Texture& model, Random& random) {
  const ShapeInfo& info = shape_info(c.shape);
  ImageDesc desc;
  desc.format = c.format;
  desc.extent = base_extent(c.shape);
  desc.type = info.type;
  desc.view_type = info.view;
  desc.layers = static_cast<uint32_t>(info.layers);
  desc.levels = c.state.unnormalized ? 1 : 3;
  desc.usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
  if (c.shape == Shape::kCube || c.shape == Shape::kCubeArray) desc.flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  Image image = create_image(device, desc);
  model.shape = c.shape;
  model.layers = info.layers;
  const bool depth = aspects_of(c.format) == VK_IMAGE_ASPECT_DEPTH_BIT;
  const uint32_t bytes = texel_bytes(c.format);
  for (uint32_t level = 0; level < desc.levels; ++level) {
    const VkExtent3D extent = image.level_extent(level);
    TextureLevel decoded{static_cast<int>(extent.width), static_cast<int>(extent.height), static_cast<int>(extent.depth), {}};
    const size_t count = size_t{extent.width} * extent.height * extent.depth;
    for (uint32_t layer = 0; layer < desc.layers; ++layer) {
      std::vector<std::byte> texels(count * bytes);
      for (size_t i = 0; i < count; ++i) {
        std::byte* texel = texels.data() + i * bytes;
        if (depth) {  // multiples of 1/16: exact in D32, and equal to some references
          const float value = static_cast<float>(random.below(17)) / 16;
          std::memcpy(texel, &value, 4);
          decoded.texels.push_back({value, 0, 0, 1});
          continue;
        }
        const FormatInfo& format = info_of(c.format);
        Colour colour;
        for (double& channel : colour) channel = format.is_integer() ? random.below(100) : random.unit();
        encode(format, colour, texel);
        decoded.texels.push_back(decode(format, texel));
      }
      upload(device, image, texels, level, layer);
    }
    model.levels.push_back(std::move(decoded));
  }
  return image;
}

// Away from texel boundaries by 1/16 texel in every level, so that nearest filtering has one answer; and from centres, for
// gathers.
bool is_clear(double value, uint32_t size) {
  for (uint32_t level_size = size; level_size > 0; level_size /= 2) {
    const double position = value * level_size, fraction = position - std::floor(position);
    if (fraction < 1.0 / 16 || fraction > 15.0 / 16 || std::abs(fraction - 0.5) < 1.0 / 64) return false;
  }
  return true;
}

double coordinate_for(Random& random, uint32_t size, double low, double high) {
  for (;;) {
    const double value = static_cast<float>(random.between(low, high));
    if (is_clear(value, size)) return value;
  }
}

void random_direction(Random& random, uint32_t size, float* xyz) {
  for (;;) {
    for (int i = 0; i < 3; ++i) xyz[i] = static_cast<float>(random.between(-1, 1));
    const FacePoint p = cube_point(xyz[0], xyz[1], xyz[2]);
    if (is_clear(p.s, size) && is_clear(p.t, size)) return;
  }
}

std::vector<Arguments> make_inputs(const TextureCase& c, Random& random) {
  const VkExtent3D extent = base_extent(c.shape);
  static constexpr float kLods[] = {-1.0f, 0.0f, 0.25f, 0.75f, 1.0f, 1.375f, 1.875f, 2.0f, 5.0f};
  std::vector<Arguments> inputs(256);
  for (Arguments& input : inputs) {
    const double low = c.state.unnormalized ? 0 : -1.6, high = c.state.unnormalized ? 1 : 2.6;
    float s[4] = {};
    const bool cube = c.shape == Shape::kCube || c.shape == Shape::kCubeArray;
    if (cube) {
      random_direction(random, extent.width, s);
      s[3] = static_cast<float>(random.between(-0.4, 2.4));
    } else {
      s[0] = static_cast<float>(coordinate_for(random, extent.width, low, high));
      if (c.shape != Shape::k1D) s[1] = static_cast<float>(coordinate_for(random, extent.height, low, high));
      if (c.shape == Shape::k3D) s[2] = static_cast<float>(coordinate_for(random, extent.depth, low, high));
      if (c.shape == Shape::k1DArray) s[1] = static_cast<float>(random.below(30)) / 7 - 1;
      if (c.shape == Shape::k2DArray) s[2] = static_cast<float>(random.below(30)) / 7 - 1;
      if (c.state.unnormalized) s[0] *= static_cast<float>(extent.width), s[1] *= static_cast<float>(extent.height);
    }
    for (size_t i = 0; i < 4; ++i) input.a[i] = as_bits(s[i]);
    input.b[0] = as_bits(kLods[random.below(std::size(kLods))]);
    input.b[1] = as_bits(static_cast<float>(random.below(17)) / 16);
    for (size_t i = 0; i < 3; ++i) input.c[i] = random.bits();
  }
  return inputs;
}

std::string call_for(const TextureCase& c) {
  const int count = shape_info(c.shape).coordinates;
  const std::string p = std::string("uintBitsToFloat(a.") + std::string("xyzw").substr(0, static_cast<size_t>(count)) + ")";
  const char* offset = c.shape == Shape::k1D || c.shape == Shape::k1DArray ? "2"
                       : c.shape == Shape::k3D                             ? "ivec3(2, -3, 1)"
                                                                           : "ivec2(2, -3)";
  const std::string lod = "uintBitsToFloat(b.x)", reference = "uintBitsToFloat(b.y)";
  if (c.state.compare) {
    if (c.op == Op::kGather) return fmt::format("textureGather(t, {}, {})", p, reference);
    return fmt::format("vec4(textureLod(t, vec3({}, {}), {}), 0.0, 0.0, 1.0)", p, reference, lod);
  }
  switch (c.op) {
    case Op::kLod:
      return fmt::format("textureLod(t, {}, {})", p, lod);
    case Op::kLodOffset:
      return fmt::format("textureLodOffset(t, {}, {}, {})", p, lod, offset);
    case Op::kGather:
      return fmt::format("textureGather(t, {}, {})", p, c.component);
    case Op::kGatherOffset:
      return fmt::format("textureGatherOffset(t, {}, {}, {})", p, offset, c.component);
    case Op::kProjective:
      return fmt::format("textureProjLod(t, vec3({} * 3.0, 3.0), {})", p, lod);
    default: {  // gradients of an isotropic footprint of 2^lod texels
      const VkExtent3D extent = base_extent(c.shape);
      if (count == 1) return fmt::format("textureGrad(t, {}, exp2({}) / {}.0, 0.0)", p, lod, extent.width);
      return fmt::format("textureGrad(t, {0}, vec2(exp2({1}) / {2}.0, 0.0), vec2(0.0, exp2({1}) / {3}.0))", p, lod, extent.width,
                         extent.height);
    }
  }
}

void check_support(Device& device, const TextureCase& c) {
  const VkFormatFeatureFlags features = device.format(c.format).optimalTilingFeatures;
  require(features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "sampling this format");
  const bool linear =
      c.state.mag == VK_FILTER_LINEAR || c.state.min == VK_FILTER_LINEAR || c.state.mip == VK_SAMPLER_MIPMAP_MODE_LINEAR;
  require(!linear || features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT, "filtering this format");
  require(c.shape != Shape::kCubeArray || device.caps().features.imageCubeArray, "imageCubeArray");
  require(c.op != Op::kGatherOffset || device.caps().features.shaderImageGatherExtended, "shaderImageGatherExtended");
  for (const VkSamplerAddressMode mode : c.state.address) {
    require(mode != VK_SAMPLER_ADDRESS_MODE_MIRROR_CLAMP_TO_EDGE ||
                device.has_extension(VK_KHR_SAMPLER_MIRROR_CLAMP_TO_EDGE_EXTENSION_NAME),
            "mirror clamp");
  }
}

void check_results(Device& device, const TextureCase& c, const Texture& model, const std::vector<Arguments>& inputs,
                   const std::vector<Words4>& results) {
  const bool one = c.shape == Shape::k1D || c.shape == Shape::k1DArray;
  const bool offset_used = c.op == Op::kLodOffset || c.op == Op::kGatherOffset;
  const std::array<int, 3> offset =
      offset_used ? std::array<int, 3>{2, one ? 0 : -3, c.shape == Shape::k3D ? 1 : 0} : std::array<int, 3>{};
  const bool is_gather = c.op == Op::kGather || c.op == Op::kGatherOffset;
  const bool integer = aspects_of(c.format) == VK_IMAGE_ASPECT_COLOR_BIT && info_of(c.format).is_integer();
  // The specification does not say how precisely fixed-point texels are weighted: one step of the format is allowed.
  const bool weighted =
      c.state.mag == VK_FILTER_LINEAR || c.state.min == VK_FILTER_LINEAR || c.state.mip == VK_SAMPLER_MIPMAP_MODE_LINEAR;
  const double step = weighted && !is_gather && !c.state.compare && aspects_of(c.format) == VK_IMAGE_ASPECT_COLOR_BIT
                          ? step_of(info_of(c.format).channels.front(), 0)
                          : 0;
  // Decoding sRGB is asked to be within half a step of 8 bits; a step near one is 1/113 in linear values, near zero much less.
  const bool srgb =
      aspects_of(c.format) == VK_IMAGE_ASPECT_COLOR_BIT && info_of(c.format).channels.front().numeric == Numeric::kSrgb;
  for (size_t n = 0; n < inputs.size(); ++n) {
    std::array<double, 4> p{};
    for (size_t i = 0; i < 4; ++i) p[i] = as_float(inputs[n].a[i]);
    const double lod = as_float(inputs[n].b[0]), reference = as_float(inputs[n].b[1]);
    Sample want;
    if (is_gather) {
      want.value = gather(model, c.state, p, c.state.compare ? 0 : c.component, reference, offset);
    } else {
      want = sample(model, c.state, p, lod, reference, offset, static_cast<int>(device.limits().subTexelPrecisionBits),
                    static_cast<int>(device.limits().mipmapPrecisionBits));
    }
    // Gradients give a level of detail that the specification lets differ: nothing is asked near a change of level.
    if (c.op == Op::kGrad && (lod <= 0 || c.state.mip == VK_SAMPLER_MIPMAP_MODE_LINEAR)) continue;
    for (size_t i = 0; i < (c.state.compare && !is_gather ? 1u : 4u); ++i) {
      const double got = integer ? results[n][i] : double{as_float(results[n][i])};
      const double allowed = want.slack[i] + step + (srgb ? 1e-3 : 1e-5) * (1 + std::abs(want.value[i]));
      if (std::abs(got - want.value[i]) <= allowed) continue;
      throw Failure(fmt::format("at ({}, {}, {}, {}), lod {}, reference {}: component {} is {:.7g}, not {:.7g} (allowed {:.2g})",
                                p[0], p[1], p[2], p[3], lod, reference, i, got, want.value[i], allowed));
    }
  }
}

void run(Device& device, const TextureCase& c, const std::string& name) {
  check_support(device, c);
  Random random(name);
  Texture model;
  const Image image = create_texture(device, c, model, random);
  const Sampler sampler = create_sampler(device, [&](VkSamplerCreateInfo& info) {
    info.magFilter = c.state.mag;
    info.minFilter = c.state.min;
    info.mipmapMode = c.state.mip;
    info.addressModeU = c.state.address[0];
    info.addressModeV = c.state.address[1];
    info.addressModeW = c.state.address[2];
    info.mipLodBias = static_cast<float>(c.state.bias);
    info.minLod = static_cast<float>(c.state.min_lod);
    info.maxLod = static_cast<float>(c.state.unnormalized ? 0 : c.state.max_lod);
    info.borderColor = c.border;
    info.compareEnable = c.state.compare;
    info.compareOp = c.state.compare_op;
    info.unnormalizedCoordinates = c.state.unnormalized;
  });
  const std::vector<Arguments> inputs = make_inputs(c, random);
  const bool depth = aspects_of(c.format) == VK_IMAGE_ASPECT_DEPTH_BIT;
  const bool integer = !depth && info_of(c.format).is_integer();
  Snippet snippet;
  snippet.functions = fmt::format("layout(binding = 2) uniform {}sampler{}{} t;", integer ? "u" : "", shape_info(c.shape).glsl,
                                  c.state.compare ? "Shadow" : "");
  snippet.body = fmt::format("r = {}({});", integer ? "uvec4" : "floatBitsToUint", call_for(c));
  snippet.descriptors.push_back(sampled_image(2, image, sampler));
  check_results(device, c, model, inputs, evaluate(device, c.stage, snippet, inputs));
}

void add(const std::string& group, const std::string& name, const TextureCase& c) {
  add_case(group, name, "16 Image Operations: 16.4 to 16.9", [c, name](Device& device) { run(device, c, name); });
}

SamplerState sampler_state(VkFilter filter, VkSamplerMipmapMode mip, VkSamplerAddressMode address) {
  SamplerState state;
  state.mag = state.min = filter;
  state.mip = mip;
  state.address.fill(address);
  return state;
}

const char* filter_name(VkFilter filter) { return filter == VK_FILTER_LINEAR ? "linear" : "nearest"; }

void register_shapes() {
  for (const ShapeInfo& shape : kShapes) {
    for (const AddressMode& address : kAddressModes) {
      for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
        for (const VkSamplerMipmapMode mip : {VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_MIPMAP_MODE_LINEAR}) {
          TextureCase c;
          c.shape = shape.shape;
          c.state = sampler_state(filter, mip, address.value);
          const char* mip_name = mip == VK_SAMPLER_MIPMAP_MODE_LINEAR ? "mip_linear" : "mip_nearest";
          add("texture.filtering", fmt::format("{}.{}.{}_{}", shape.name, address.name, filter_name(filter), mip_name), c);
        }
      }
    }
    for (const StageName& stage : kStages) {
      TextureCase c;
      c.shape = shape.shape;
      c.stage = stage.stage;
      c.state = sampler_state(VK_FILTER_LINEAR, VK_SAMPLER_MIPMAP_MODE_LINEAR, VK_SAMPLER_ADDRESS_MODE_REPEAT);
      add("texture.stages", fmt::format("{}.{}", shape.name, stage.name), c);
    }
  }
}

void register_formats() {
  for (const FormatInfo& format : colour_formats()) {
    const Numeric numeric = format.channels[0].numeric;
    if (numeric == Numeric::kUscaled || numeric == Numeric::kSscaled || numeric == Numeric::kSint) continue;
    if (format.format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) continue;  // its encoder is not part of the reference
    for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
      if (filter == VK_FILTER_LINEAR && format.is_integer()) continue;
      TextureCase c;
      c.format = format.format;
      c.state = sampler_state(filter, filter == VK_FILTER_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
                              VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT);
      add("texture.formats", fmt::format("{}.{}", format.name, filter_name(filter)), c);
    }
  }
}

void register_selection() {
  struct Selection {
    const char* name;
    double bias, min_lod, max_lod;
  };
  static constexpr Selection kSelections[] = {{"bias_up", 0.625, 0, 1000},
                                              {"bias_down", -0.875, 0, 1000},
                                              {"min_lod", 0, 1.25, 1000},
                                              {"max_lod", 0, 0, 0.875},
                                              {"fixed", 0, 1, 1}};
  for (const Selection& selection : kSelections) {
    for (const VkSamplerMipmapMode mip : {VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_MIPMAP_MODE_LINEAR}) {
      TextureCase c;
      c.state = sampler_state(VK_FILTER_NEAREST, mip, VK_SAMPLER_ADDRESS_MODE_REPEAT);
      c.state.bias = selection.bias, c.state.min_lod = selection.min_lod, c.state.max_lod = selection.max_lod;
      add("texture.level_of_detail",
          fmt::format("{}.{}", selection.name, mip == VK_SAMPLER_MIPMAP_MODE_LINEAR ? "linear" : "nearest"), c);
    }
  }
  for (const auto& [mag, min] : {std::pair{VK_FILTER_NEAREST, VK_FILTER_LINEAR}, {VK_FILTER_LINEAR, VK_FILTER_NEAREST}}) {
    TextureCase c;
    c.state = sampler_state(mag, VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    c.state.min = min;
    add("texture.level_of_detail", fmt::format("mag_{}_min_{}", filter_name(mag), filter_name(min)), c);
  }
}

void register_functions() {
  struct Function {
    Op op;
    const char* name;
  };
  for (const AddressMode& address : kAddressModes) {
    for (const Function f : {Function{Op::kLodOffset, "lod_offset"}, {Op::kGrad, "grad"}, {Op::kProjective, "proj_lod"}}) {
      for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
        for (const Shape shape : {Shape::k1D, Shape::k2D, Shape::k3D}) {
          if (shape != Shape::k2D && f.op != Op::kLodOffset) continue;
          TextureCase c;
          c.shape = shape;
          c.op = f.op;
          c.state = sampler_state(filter, VK_SAMPLER_MIPMAP_MODE_NEAREST, address.value);
          add("glsl.texture_functions",
              fmt::format("{}.{}.{}.{}", f.name, shape_info(shape).name, address.name, filter_name(filter)), c);
        }
      }
    }
    for (const Shape shape : {Shape::k2D, Shape::k2DArray, Shape::kCube, Shape::kCubeArray}) {
      for (size_t component = 0; component < 4; ++component) {
        for (const Op op : {Op::kGather, Op::kGatherOffset}) {
          if (op == Op::kGatherOffset && shape != Shape::k2D && shape != Shape::k2DArray) continue;
          TextureCase c;
          c.shape = shape;
          c.op = op;
          c.component = component;
          c.state = sampler_state(VK_FILTER_LINEAR, VK_SAMPLER_MIPMAP_MODE_NEAREST, address.value);
          add("texture.gather",
              fmt::format("{}.{}.{}component_{}", shape_info(shape).name, address.name, op == Op::kGather ? "" : "offset_",
                          component),
              c);
        }
      }
    }
  }
}

void register_shadow_and_borders() {
  static constexpr const char* kCompareNames[] = {
      "never", "less", "equal", "less_or_equal", "greater", "not_equal", "greater_or_equal", "always"};
  for (int op = 0; op < 8; ++op) {
    for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
      for (const Op function : {Op::kLod, Op::kGather}) {
        TextureCase c;
        c.format = VK_FORMAT_D32_SFLOAT;
        c.op = function;
        c.state = sampler_state(filter, VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_ADDRESS_MODE_REPEAT);
        c.state.compare = true;
        c.state.compare_op = static_cast<VkCompareOp>(op);
        add("texture.shadow",
            fmt::format("{}.{}.{}", function == Op::kLod ? "lod" : "gather", kCompareNames[op], filter_name(filter)), c);
      }
    }
  }
  struct Border {
    VkBorderColor value;
    const char* name;
    Colour colour;
    bool integer;
  };
  for (const Border& border : {Border{VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK, "transparent_black", {0, 0, 0, 0}, false},
                               {VK_BORDER_COLOR_FLOAT_OPAQUE_BLACK, "opaque_black", {0, 0, 0, 1}, false},
                               {VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE, "opaque_white", {1, 1, 1, 1}, false},
                               {VK_BORDER_COLOR_INT_TRANSPARENT_BLACK, "int_transparent_black", {0, 0, 0, 0}, true},
                               {VK_BORDER_COLOR_INT_OPAQUE_BLACK, "int_opaque_black", {0, 0, 0, 1}, true},
                               {VK_BORDER_COLOR_INT_OPAQUE_WHITE, "int_opaque_white", {1, 1, 1, 1}, true}}) {
    for (const Shape shape : {Shape::k1D, Shape::k2D, Shape::k3D, Shape::k2DArray}) {
      for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
        if (border.integer && filter == VK_FILTER_LINEAR) continue;
        TextureCase c;
        c.shape = shape;
        c.format = border.integer ? VK_FORMAT_R32G32B32A32_UINT : VK_FORMAT_R8G8B8A8_UNORM;
        c.state = sampler_state(filter, VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER);
        c.state.border = border.colour;
        c.border = border.value;
        add("texture.border", fmt::format("{}.{}.{}", border.name, shape_info(shape).name, filter_name(filter)), c);
      }
    }
  }
  for (const VkFilter filter : {VK_FILTER_NEAREST, VK_FILTER_LINEAR}) {
    for (const AddressMode& address : {kAddressModes[2], kAddressModes[3]}) {
      TextureCase c;
      c.state = sampler_state(filter, VK_SAMPLER_MIPMAP_MODE_NEAREST, address.value);
      c.state.unnormalized = true;
      add("texture.unnormalized", fmt::format("{}.{}", address.name, filter_name(filter)), c);
    }
  }
}

}  // namespace

void register_texture() {
  register_shapes();
  register_formats();
  register_selection();
  register_functions();
  register_shadow_and_borders();
}

}  // namespace pineda::cts
