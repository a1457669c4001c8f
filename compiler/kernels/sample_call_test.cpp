// The general path: a kernel that calls functions for its samples (sample_call.h, sample_functions.h) computes the same bits as
// one in which the sampling is inlined, whatever surrounds it.
#include "compiler/kernels/sample_call.h"

#include <bit>

#include "compiler/kernels/sample_lod.h"
#include "compiler/kernels/sample_reference.h"
#include "compiler/sample_functions.h"

namespace pineda::kernels::test {
namespace {

using compiler::TextureState;
using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::LodMode;
using spirv::SampleRequest;

constexpr uint32_t kDescriptorSlot = 232;  // push constant bytes that hold the descriptors' addresses
constexpr uint32_t kInputs = 12;

struct Case {
  std::vector<TextureState> states;      // of each image
  std::vector<const TestImage*> images;  // lanes choose one by input 11
  SampleRequest request;                 // what is constant in it
  bool layered = false;
};

// Products go in and sums come out, so that a contraction across the border would show.
Channels surrounded(Builder& b, const std::vector<Value>& in, const Case& c,
                    const std::function<Result<Channels>(const SampleRequest&)>& ask) {
  SampleRequest r = c.request;
  const auto scaled = [&](uint32_t i) { return b.fmul(in[i], b.f32(1.1)); };
  const uint32_t axes = axis_count(r.view_type), last = axes + (is_array(r.view_type) ? 1 : 0);
  const bool fetch = r.lod_mode == LodMode::kFetch;
  const auto integer = [&](Value v) { return b.convert(ir::Op::kFToS, Type::kI32, b.fmul(v, b.f32(16))); };
  for (uint32_t a = 0; a < last; ++a) r.coord[a] = fetch ? integer(in[a]) : scaled(a);
  if (fetch) r.lod = b.convert(ir::Op::kFToS, Type::kI32, in[4]);
  if (r.lod_mode == LodMode::kExplicit) r.lod = scaled(4);
  if (r.lod_mode == LodMode::kGradient) {
    for (uint32_t a = 0; a < axes; ++a) r.ddx[a] = scaled(5 + a), r.ddy[a] = scaled(8 + a);
  }
  if (r.bias) r.bias = scaled(4);
  if (r.min_lod) r.min_lod = scaled(9);
  if (r.depth_reference) r.depth_reference = scaled(10);
  for (uint32_t a = 0; a < axes && r.dynamic_offset[0]; ++a) r.dynamic_offset[a] = integer(b.fmul(in[5 + a], b.f32(0.1)));
  const Result<Channels> texel = ask(r);
  EXPECT_TRUE(texel) << (texel ? "" : texel.error().text);
  Channels out = *texel;
  for (uint32_t i = 0; i < 4 && r.result == Type::kF32; ++i) out[i] = b.fadd(out[i], in[i]);
  return out;
}

std::vector<std::vector<uint32_t>> run(const Case& c, bool called, const std::vector<std::vector<uint32_t>>& in,
                                       const KernelHandle* handle) {
  const ArrayKernel kernel(kInputs, [&](Builder& b, const std::vector<Value>& words) {
    std::vector<Value> floats;
    for (const Value v : words) floats.push_back(b.bitcast(Type::kF32, v));
    const auto descriptor = [&](uint32_t i) {
      return b.load(Type::kPtr, b.draw_ptr(), offsetof(DrawContext, push_constants) + kDescriptorSlot + 8 * i);
    };
    const auto sampler = [&](Value image) { return b.ptr_add(image, b.i32(offsetof(ImageDescriptor, lod_bias))); };
    const Value second = b.flt(floats[11], b.f32(0.4));
    Channels out = surrounded(b, floats, c, [&](const SampleRequest& r) -> Result<Channels> {
      const bool two = c.images.size() > 1;
      if (called) {
        const Value image = two ? b.select(second, descriptor(1), descriptor(0)) : descriptor(0);
        return call_sample(b, image, sampler(image), r);
      }
      Result<Channels> texel = sample_image(b, {c.states[0], descriptor(0), sampler(descriptor(0))}, r);
      if (!two || !texel) return texel;
      const Result<Channels> other = sample_image(b, {c.states[1], descriptor(1), sampler(descriptor(1))}, r);
      for (uint32_t i = 0; i < 4; ++i) (*texel)[i] = b.select(second, (*other)[i], (*texel)[i]);
      return texel;
    });
    std::vector<Value> bits;
    for (const Value v : out) bits.push_back(b.bitcast(Type::kI32, v));
    return bits;
  });
  DrawContext draw{};
  draw.sample = handle;
  for (uint32_t i = 0; i < c.images.size(); ++i) {
    const void* address = &c.images[i]->descriptor;
    std::memcpy(draw.push_constants + kDescriptorSlot + 8 * i, &address, 8);
  }
  return kernel(in, draw);
}

class SampleCalls : public testing::Test {
 protected:
  uint32_t pick(uint32_t n) { return static_cast<uint32_t>(random_()) % n; }

  TextureState random_state(const ImageShape& shape) {
    TextureState s{.format = shape.format,
                   .view_type = shape.type,
                   .single_level = shape.levels == 1,
                   .mag_filter = static_cast<VkFilter>(pick(2)),
                   .min_filter = static_cast<VkFilter>(pick(2)),
                   .mipmap_mode = static_cast<VkSamplerMipmapMode>(pick(2)),
                   .anisotropy = pick(4) == 0};
    s.swizzle = {static_cast<uint8_t>(pick(6)), static_cast<uint8_t>(pick(6)), 2, 3};
    if (pick(4) == 0) s.reduction = VK_SAMPLER_REDUCTION_MODE_MAX;
    s.compare_enable = shape.format == VK_FORMAT_D32_SFLOAT;
    s.compare = static_cast<VkCompareOp>(pick(8));
    for (auto& mode : s.address) mode = static_cast<VkSamplerAddressMode>(pick(5));
    return s;
  }

  SampleRequest random_request(const ImageShape& shape) {
    Value some{1};  // surrounded() replaces it
    SampleRequest r;
    r.view_type = shape.type;
    r.result = find_format(shape.format)->is_integer() ? Type::kI32 : Type::kF32;
    const bool cube = is_cube(shape.type);
    const uint32_t kind = pick(5);
    r.lod_mode = kind == 0            ? LodMode::kExplicit
                 : kind == 1          ? LodMode::kGradient
                 : kind == 2 && !cube ? LodMode::kFetch
                                      : LodMode::kImplicit;
    const bool fetch = r.lod_mode == LodMode::kFetch;
    if (shape.format == VK_FORMAT_D32_SFLOAT && !fetch) r.depth_reference = some;
    if (kind == 4 && shape.type != VK_IMAGE_VIEW_TYPE_3D && axis_count(shape.type) > 1) {
      r.lod_mode = LodMode::kExplicit;
      r.gather_component = static_cast<int32_t>(pick(4));
      if (!cube && pick(2)) r.dynamic_offset[0] = some;
    } else if (!cube && pick(2)) {
      r.offset = {static_cast<int32_t>(pick(16)) - 8, static_cast<int32_t>(pick(16)) - 8, -3};
    }
    if ((r.lod_mode == LodMode::kGradient || r.lod_mode == LodMode::kImplicit) && pick(2)) r.bias = some;
    if (!fetch && r.gather_component < 0 && pick(4) == 0) r.min_lod = some;
    return r;
  }

  ImageShape random_shape() {
    constexpr VkFormat kFormats[] = {VK_FORMAT_R8G8B8A8_UNORM,      VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT,
                                     VK_FORMAT_R32G32_SFLOAT,       VK_FORMAT_R8G8_SNORM,    VK_FORMAT_R16G16B16A16_UINT,
                                     VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_D32_SFLOAT};
    ImageShape s{.format = kFormats[pick(std::size(kFormats))], .type = static_cast<VkImageViewType>(pick(7))};
    s.width = 1 + pick(20);
    s.height = axis_count(s.type) == 1 ? 1 : is_cube(s.type) ? s.width : 1 + pick(20);
    s.depth = s.type == VK_IMAGE_VIEW_TYPE_3D ? 1 + pick(9) : 1;
    s.levels = 1 + pick(4);
    s.layers = (is_array(s.type) ? 1 + pick(3) : 1) * (is_cube(s.type) ? 6 : 1);
    return s;
  }

  // Two images of one kind (and a null one, now and then), called and inlined.
  void check() {
    const ImageShape shape = random_shape();
    TestImage first(shape, random_), second(shape, random_);
    Case c{.states = {random_state(shape), random_state(shape)}, .images = {&first, &second}, .request = random_request(shape)};
    if (pick(3) == 0) c.images.pop_back();
    uint32_t id = 0;
    for (TestImage* image : {&first, &second}) {
      image->descriptor.state_id = image->descriptor.sampler_state_id = ++id;
      image->descriptor.lod_bias = 0.3f;
    }
    const compiler::SampleFunctions functions([&](uint32_t view, uint32_t) { return c.states[view - 1]; });
    std::vector<std::vector<uint32_t>> in(kInputs, std::vector<uint32_t>(64));
    for (auto& array : in) {
      for (uint32_t& bits : array) bits = std::bit_cast<uint32_t>(static_cast<float>(random_() / 0x1p31 - 0.8));
    }
    const auto inlined = run(c, false, in, nullptr), called = run(c, true, in, functions.handle());
    ASSERT_EQ(inlined, called) << "format " << shape.format << " view type " << shape.type << " lod mode "
                               << static_cast<int>(c.request.lod_mode) << " gather " << c.request.gather_component;
  }

  std::mt19937 random_{kSeed};
};

TEST_F(SampleCalls, GiveTheBitsOfInlinedSampling) {
  for (int i = 0; i < 150 && !HasFailure(); ++i) check();
}

TEST(SampleSignature, PacksEverything) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const auto bit = [&] { return (random() & 1) != 0; };
    const SampleSignature s{.operation = static_cast<SampleSignature::Operation>(random() % 3),
                            .view_type = static_cast<VkImageViewType>(random() % 7),
                            .lod_mode = static_cast<LodMode>(random() % 4),
                            .integer = bit(),
                            .has_bias = bit(),
                            .has_min_lod = bit(),
                            .has_reference = bit(),
                            .has_dynamic_offset = bit(),
                            .has_sample = bit(),
                            .gather_component = static_cast<int8_t>(static_cast<int>(random() % 5) - 1),
                            .offset = {static_cast<int32_t>(random() % 256) - 128, -128, 127}};
    const SampleSignature t = SampleSignature::unpack(s.pack());
    EXPECT_EQ(s, t);
  }
}

}  // namespace
}  // namespace pineda::kernels::test
