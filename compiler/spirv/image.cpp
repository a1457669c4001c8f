// Image instructions -> SampleRequest and ImageAccess, which the kernel's StageInterface answers.
#include "compiler/spirv/image.h"

#include <algorithm>
#include <bit>

namespace pineda::spirv {
namespace {

using ir::Value;

VkFormat vulkan_format(spv::ImageFormat format) {
  switch (format) {
    case spv::ImageFormatRgba32f:
      return VK_FORMAT_R32G32B32A32_SFLOAT;
    case spv::ImageFormatRgba16f:
      return VK_FORMAT_R16G16B16A16_SFLOAT;
    case spv::ImageFormatR32f:
      return VK_FORMAT_R32_SFLOAT;
    case spv::ImageFormatRgba8:
      return VK_FORMAT_R8G8B8A8_UNORM;
    case spv::ImageFormatRgba8Snorm:
      return VK_FORMAT_R8G8B8A8_SNORM;
    case spv::ImageFormatRg32f:
      return VK_FORMAT_R32G32_SFLOAT;
    case spv::ImageFormatRg16f:
      return VK_FORMAT_R16G16_SFLOAT;
    case spv::ImageFormatR11fG11fB10f:
      return VK_FORMAT_B10G11R11_UFLOAT_PACK32;
    case spv::ImageFormatR16f:
      return VK_FORMAT_R16_SFLOAT;
    case spv::ImageFormatRgba16:
      return VK_FORMAT_R16G16B16A16_UNORM;
    case spv::ImageFormatRgb10A2:
      return VK_FORMAT_A2B10G10R10_UNORM_PACK32;
    case spv::ImageFormatRg16:
      return VK_FORMAT_R16G16_UNORM;
    case spv::ImageFormatRg8:
      return VK_FORMAT_R8G8_UNORM;
    case spv::ImageFormatR16:
      return VK_FORMAT_R16_UNORM;
    case spv::ImageFormatR8:
      return VK_FORMAT_R8_UNORM;
    case spv::ImageFormatRgba16Snorm:
      return VK_FORMAT_R16G16B16A16_SNORM;
    case spv::ImageFormatRg16Snorm:
      return VK_FORMAT_R16G16_SNORM;
    case spv::ImageFormatRg8Snorm:
      return VK_FORMAT_R8G8_SNORM;
    case spv::ImageFormatR16Snorm:
      return VK_FORMAT_R16_SNORM;
    case spv::ImageFormatR8Snorm:
      return VK_FORMAT_R8_SNORM;
    case spv::ImageFormatRgba32i:
      return VK_FORMAT_R32G32B32A32_SINT;
    case spv::ImageFormatRgba16i:
      return VK_FORMAT_R16G16B16A16_SINT;
    case spv::ImageFormatRgba8i:
      return VK_FORMAT_R8G8B8A8_SINT;
    case spv::ImageFormatR32i:
      return VK_FORMAT_R32_SINT;
    case spv::ImageFormatRg32i:
      return VK_FORMAT_R32G32_SINT;
    case spv::ImageFormatRg16i:
      return VK_FORMAT_R16G16_SINT;
    case spv::ImageFormatRg8i:
      return VK_FORMAT_R8G8_SINT;
    case spv::ImageFormatR16i:
      return VK_FORMAT_R16_SINT;
    case spv::ImageFormatR8i:
      return VK_FORMAT_R8_SINT;
    case spv::ImageFormatRgba32ui:
      return VK_FORMAT_R32G32B32A32_UINT;
    case spv::ImageFormatRgba16ui:
      return VK_FORMAT_R16G16B16A16_UINT;
    case spv::ImageFormatRgba8ui:
      return VK_FORMAT_R8G8B8A8_UINT;
    case spv::ImageFormatR32ui:
      return VK_FORMAT_R32_UINT;
    case spv::ImageFormatRgb10a2ui:
      return VK_FORMAT_A2B10G10R10_UINT_PACK32;
    case spv::ImageFormatRg32ui:
      return VK_FORMAT_R32G32_UINT;
    case spv::ImageFormatRg16ui:
      return VK_FORMAT_R16G16_UINT;
    case spv::ImageFormatRg8ui:
      return VK_FORMAT_R8G8_UINT;
    case spv::ImageFormatR16ui:
      return VK_FORMAT_R16_UINT;
    case spv::ImageFormatR8ui:
      return VK_FORMAT_R8_UINT;
    default:
      return VK_FORMAT_UNDEFINED;
  }
}

}  // namespace

VkImageViewType view_type(const ImageType& image) {
  switch (image.dim) {
    case spv::DimBuffer:  // an image of one row
      return VK_IMAGE_VIEW_TYPE_1D;
    case spv::Dim1D:
      return image.arrayed ? VK_IMAGE_VIEW_TYPE_1D_ARRAY : VK_IMAGE_VIEW_TYPE_1D;
    case spv::Dim3D:
      return VK_IMAGE_VIEW_TYPE_3D;
    case spv::DimCube:
      return image.arrayed ? VK_IMAGE_VIEW_TYPE_CUBE_ARRAY : VK_IMAGE_VIEW_TYPE_CUBE;
    default:
      return image.arrayed ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
  }
}

uint32_t dimensions(const ImageType& image) {
  if (image.dim == spv::Dim1D || image.dim == spv::DimBuffer) return 1;
  return image.dim == spv::Dim2D || image.dim == spv::DimSubpassData ? 2 : 3;
}

const ImageType& image_type(Translator& t, const Instruction& inst, const Opaque& o) {
  if (o.image_type == 0) inst.fail("the operand is not an image");
  const ImageType& image = t.m.type(o.image_type).image;
  return image;
}

namespace {

ir::Type component_type(Translator& t, const Opaque& o) { return t.m.type(t.m.type(o.image_type).element).scalar; }

std::array<Value, 4> coordinates(Translator& t, const Instruction& inst, uint32_t word, uint32_t count, bool wants_float) {
  const Values v = wants_float ? t.floats(inst, word) : t.integers(inst, word);
  if (v.size() < count) inst.fail("the coordinate has too few components");
  std::array<Value, 4> out{};
  std::copy_n(v.begin(), count, out.begin());
  return out;
}

// ---- sampling ----

// The optional image operands, which follow in the order of their bits (SPIR-V 3.14).
struct Operands {
  Value bias, lod, min_lod, sample;
  Values ddx, ddy;
  std::array<int32_t, 3> offset{};
  std::array<Value, 3> dynamic_offset{};
  std::vector<std::array<int32_t, 3>> gather_offsets;  // ConstOffsets
};

std::array<int32_t, 3> constant_offset(Translator& t, const Instruction& inst, uint32_t id) {
  const Constant* c = t.m.constant(id);
  if (!c) inst.fail("texel offsets must be constants");
  const std::vector<ir::Type> types = t.m.flat_scalars(c->type);
  if (types.empty() || types.size() > 3 || types[0] != ir::Type::kI32) inst.fail("a texel offset must be 1 to 3 integers");
  std::array<int32_t, 3> out{};
  for (size_t i = 0; i < c->scalars.size(); ++i) out[i] = static_cast<int32_t>(c->scalars[i]);
  return out;
}

void gather_offsets(Translator& t, const Instruction& inst, uint32_t id, Operands& out) {
  const Constant* c = t.m.constant(id);
  if (!c || t.m.flat_scalars(c->type).size() != 8 || t.m.flat_scalars(c->type)[0] != ir::Type::kI32) {
    inst.fail("ConstOffsets must be four constant pairs of integers");
  }
  for (uint32_t i = 0; i < 4; ++i) {
    const auto part = [&](uint32_t k) { return c->scalars.empty() ? 0 : static_cast<int32_t>(c->scalars[2 * i + k]); };
    out.gather_offsets.push_back({part(0), part(1), 0});
  }
}

// Need not be constant (ImageGatherExtended).
void offset(Translator& t, const Instruction& inst, uint32_t word, Operands& out) {
  if (t.m.constant(inst.word(word))) {
    out.offset = constant_offset(t, inst, inst.word(word));
    return;
  }
  const Values v = t.integers(inst, word);
  if (v.size() > 3 || t.b.type(v[0]) != ir::Type::kI32) inst.fail("a texel offset must be 1 to 3 integers");
  std::ranges::copy(v, out.dynamic_offset.begin());
}

Operands read_operands(Translator& t, const Instruction& inst, uint32_t word, ir::Type lod_type) {
  Operands out;
  const uint32_t mask = inst.word_or(word++, 0);
  constexpr uint32_t kIgnored = uint32_t{spv::ImageOperandsNonPrivateTexelMask} | spv::ImageOperandsVolatileTexelMask |
                                spv::ImageOperandsSignExtendMask | spv::ImageOperandsZeroExtendMask |
                                spv::ImageOperandsMakeTexelAvailableMask | spv::ImageOperandsMakeTexelVisibleMask;
  constexpr uint32_t kRead = uint32_t{spv::ImageOperandsBiasMask} | spv::ImageOperandsLodMask | spv::ImageOperandsGradMask |
                             spv::ImageOperandsConstOffsetMask | spv::ImageOperandsOffsetMask |
                             spv::ImageOperandsConstOffsetsMask | spv::ImageOperandsSampleMask | spv::ImageOperandsMinLodMask;
  if (mask & ~(kIgnored | kRead)) inst.fail("image operands " + std::to_string(mask) + " are not supported");
  if (mask & spv::ImageOperandsBiasMask) out.bias = t.scalar(inst, word++, ir::Type::kF32);
  if (mask & spv::ImageOperandsLodMask) out.lod = t.scalar(inst, word++, lod_type);
  if (mask & spv::ImageOperandsGradMask) {
    out.ddx = t.floats(inst, word++);
    out.ddy = t.floats(inst, word++);
  }
  if (mask & spv::ImageOperandsConstOffsetMask) out.offset = constant_offset(t, inst, inst.word(word++));
  if (mask & spv::ImageOperandsOffsetMask) offset(t, inst, word++, out);
  if (mask & spv::ImageOperandsConstOffsetsMask) gather_offsets(t, inst, inst.word(word++), out);
  if (mask & spv::ImageOperandsSampleMask) out.sample = t.scalar(inst, word++, ir::Type::kI32);
  if (mask & spv::ImageOperandsMinLodMask) out.min_lod = t.scalar(inst, word++, ir::Type::kF32);
  return out;
}

Texel ask(Translator& t, const Instruction& inst, const SampleRequest& request) {
  const std::optional<Texel> texel = t.stage.sample(t.b, request);
  if (!texel) inst.fail("this way of sampling is not supported");
  return *texel;
}

SampleRequest request_for(Translator& t, const Instruction& inst, const Opaque& o, const ImageType& image) {
  if (image.storage) inst.fail("storage images cannot be sampled");
  if (image.multisampled && o.has_sampler) inst.fail("multisampled images have no sampler");
  if (image.dim == spv::DimBuffer && o.has_sampler) inst.fail("a buffer has no sampler");
  SampleRequest r{.image = o.image, .sampler = o.has_sampler ? o.sampler : o.image};
  r.view_type = view_type(image);
  r.result = component_type(t, o);
  return r;
}

void apply(Translator& t, const Instruction& inst, const Operands& operands, uint32_t dims, SampleRequest& r) {
  r.offset = operands.offset;
  r.min_lod = operands.min_lod;
  if (operands.dynamic_offset[0]) inst.fail("only gathers have offsets that are not constant");
  if (!operands.ddx.empty()) {
    if (operands.ddx.size() != dims || operands.ddy.size() != dims) inst.fail("the gradients do not have the image's dimensions");
    r.lod_mode = LodMode::kGradient;
    std::ranges::copy(operands.ddx, r.ddx.begin());
    std::ranges::copy(operands.ddy, r.ddy.begin());
  } else if (operands.lod) {
    r.lod_mode = LodMode::kExplicit;
    r.lod = operands.lod;
  } else if (!t.is_fragment()) {  // without derivatives the base level is sampled
    r.lod_mode = LodMode::kExplicit;
    r.lod = t.b.f32(0);
  } else {
    t.found().uses_derivatives = true;
    r.lod_mode = LodMode::kImplicit;
    r.bias = operands.bias;
  }
}

enum class Explicit : bool { kNo, kYes };
enum class Compare : bool { kNo, kYes };
enum class Projective : bool { kNo, kYes };

// OpImageSample{Proj,}{Dref,}{Implicit,Explicit}Lod
template <Explicit kExplicit, Compare kCompare, Projective kProjective>
void sample(Translator& t, const Instruction& inst) {
  const Opaque o = t.opaque(inst, 3);
  const ImageType& image = image_type(t, inst, o);
  if (!o.has_sampler) inst.fail("the image has no sampler");
  SampleRequest r = request_for(t, inst, o, image);
  const uint32_t dims = dimensions(image);
  constexpr bool kProj = kProjective == Projective::kYes;
  if (kProj && image.arrayed) inst.fail("arrayed images cannot be sampled projectively");
  r.coord = coordinates(t, inst, 4, dims + (image.arrayed || kProj ? 1 : 0), true);
  uint32_t word = 5;
  if (kCompare == Compare::kYes) r.depth_reference = t.scalar(inst, word++, ir::Type::kF32);
  if (kProj) {  // u/q, v/q, w/q and the reference too
    const Value q = r.coord[dims];
    for (uint32_t i = 0; i < dims; ++i) r.coord[i] = t.b.fdiv(r.coord[i], q);
    r.coord[dims] = {};
    if (r.depth_reference) r.depth_reference = t.b.fdiv(r.depth_reference, q);
  }
  const Operands operands = read_operands(t, inst, word, ir::Type::kF32);
  if (kExplicit == Explicit::kYes && !operands.lod && operands.ddx.empty()) inst.fail("has neither Lod nor Grad");
  if (kExplicit == Explicit::kNo && (operands.lod || !operands.ddx.empty())) inst.fail("cannot have Lod or Grad");
  apply(t, inst, operands, dims, r);
  const Texel texel = ask(t, inst, r);
  t.define(inst, kCompare == Compare::kYes ? Values{texel[0]} : Values(texel.begin(), texel.end()));
}

// Component `pick` of the texels around the coordinate. With four offsets each result is the texel that offset i moves to the
// place of the footprint's upper left texel, which is component 3 of a gather there (Vulkan, "Texel Gathering").
void gather_with(Translator& t, const Instruction& inst, SampleRequest& r, uint32_t operands_word) {
  const Operands operands = read_operands(t, inst, operands_word, ir::Type::kF32);
  if (operands.lod || operands.bias || !operands.ddx.empty()) inst.fail("a gather has no LOD");
  r.lod_mode = LodMode::kExplicit;
  r.lod = t.b.f32(0);
  r.offset = operands.offset;
  r.dynamic_offset = operands.dynamic_offset;
  if (operands.gather_offsets.empty()) {
    const Texel texel = ask(t, inst, r);
    return t.define(inst, Values(texel.begin(), texel.end()));
  }
  Values out;
  for (const auto& offset : operands.gather_offsets) {
    r.offset = offset;
    out.push_back(ask(t, inst, r)[3]);
  }
  t.define(inst, std::move(out));
}

template <Compare kCompare>
void gather(Translator& t, const Instruction& inst) {
  const Opaque o = t.opaque(inst, 3);
  const ImageType& image = image_type(t, inst, o);
  if (!o.has_sampler) inst.fail("the image has no sampler");
  if (image.dim != spv::Dim2D && image.dim != spv::DimCube) inst.fail("only 2D and Cube images can be gathered");
  SampleRequest r = request_for(t, inst, o, image);
  r.coord = coordinates(t, inst, 4, dimensions(image) + (image.arrayed ? 1 : 0), true);
  if (kCompare == Compare::kYes) {
    r.depth_reference = t.scalar(inst, 5, ir::Type::kF32);
    r.gather_component = 0;
  } else {
    const uint32_t component = t.m.constant_u32(inst, inst.word(5));
    if (component > 3) inst.fail("the component is out of range");
    r.gather_component = static_cast<int32_t>(component);
  }
  gather_with(t, inst, r, 6);
}

void fetch(Translator& t, const Instruction& inst) {
  const Opaque o = t.opaque(inst, 3);
  const ImageType& image = image_type(t, inst, o);
  SampleRequest r = request_for(t, inst, o, image);
  if (image.dim == spv::DimCube) inst.fail("Cube images cannot be fetched");
  r.coord = coordinates(t, inst, 4, dimensions(image) + (image.arrayed ? 1 : 0), false);
  const Operands operands = read_operands(t, inst, 5, ir::Type::kI32);
  r.lod_mode = LodMode::kFetch;
  if (image.multisampled != static_cast<bool>(operands.sample)) inst.fail("Sample goes with multisampled images");
  r.lod = operands.lod ? operands.lod : t.b.i32(0);
  r.offset = operands.offset;
  if (operands.dynamic_offset[0]) inst.fail("only gathers have offsets that are not constant");
  r.sample = operands.sample;
  r.sampler = r.image;
  const Texel texel = ask(t, inst, r);
  t.define(inst, Values(texel.begin(), texel.end()));
}

// ---- storage images ----

ImageAccess access_of(Translator& t, const Instruction& inst, const Opaque& o, uint32_t coordinate_word) {
  const ImageType& image = image_type(t, inst, o);
  if (!image.storage || image.dim == spv::DimSubpassData) inst.fail("the image is not a storage image");
  ImageAccess a{.image = o.image};
  a.view_type = view_type(image);
  a.format = vulkan_format(image.format);
  a.component = component_type(t, o);
  a.is_signed = t.m.type(t.m.type(o.image_type).element).is_signed;
  // A cube's third coordinate is the face, or layer * 6 + face.
  const uint32_t count = image.dim == spv::DimCube ? 3 : dimensions(image) + (image.arrayed ? 1 : 0);
  a.coord = coordinates(t, inst, coordinate_word, count, false);
  return a;
}

ImageAccess access_for(Translator& t, const Instruction& inst, uint32_t image_word, uint32_t coordinate_word,
                       uint32_t operands_word) {
  const Opaque o = t.opaque(inst, image_word);
  const ImageType& image = image_type(t, inst, o);
  ImageAccess a = access_of(t, inst, o, coordinate_word);
  const Operands operands = read_operands(t, inst, operands_word, ir::Type::kI32);
  if (image.multisampled && !operands.sample) inst.fail("a multisampled image is accessed without a sample");
  if (image.multisampled) a.sample = operands.sample;
  return a;
}

// An input attachment at the fragment's own place, which the coordinate is relative to: a fetch.
void subpass_read(Translator& t, const Instruction& inst, const Opaque& o, const ImageType& image) {
  SampleRequest r{.image = o.image, .sampler = o.image, .view_type = VK_IMAGE_VIEW_TYPE_2D_ARRAY, .result = component_type(t, o)};
  const std::array<Value, 4> offset = coordinates(t, inst, 4, 2, false);
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const Value place = t.stage.input(t.b, {.built_in = BuiltIn::kFragCoord, .component = axis});
    if (!place) inst.fail("input attachments are for fragment shaders");
    r.coord[axis] = t.b.iadd(t.b.convert(ir::Op::kFToS, ir::Type::kI32, place), offset[axis]);
  }
  // The layer that is drawn to; with multiview that is the view's, and otherwise the view is 0. Views without layers ignore it.
  const Value layer = t.stage.input(t.b, {.built_in = BuiltIn::kLayer, .type = ir::Type::kI32}),
              of_view = t.stage.input(t.b, {.built_in = BuiltIn::kViewIndex, .type = ir::Type::kI32});
  if (!layer || !of_view) inst.fail("input attachments are for fragment shaders");
  r.coord[2] = t.b.iadd(layer, of_view);
  const Operands operands = read_operands(t, inst, 5, ir::Type::kI32);
  if (image.multisampled != static_cast<bool>(operands.sample)) inst.fail("Sample goes with multisampled images");
  r.lod_mode = LodMode::kFetch;
  r.lod = t.b.i32(0);
  r.sample = operands.sample;
  const Texel texel = ask(t, inst, r);
  const Type& type = t.result_type(inst);
  t.define(inst, Values(texel.begin(), texel.begin() + (type.kind == TypeKind::kVector ? type.count : 1)));
}

void read(Translator& t, const Instruction& inst) {
  const Opaque o = t.opaque(inst, 3);
  if (const ImageType& image = image_type(t, inst, o); image.dim == spv::DimSubpassData) return subpass_read(t, inst, o, image);
  const ImageAccess a = access_for(t, inst, 3, 4, 5);
  const std::optional<Texel> texel = t.stage.image_load(t.b, a);
  if (!texel) inst.fail("this image cannot be read here");
  const Type& type = t.result_type(inst);
  t.define(inst, Values(texel->begin(), texel->begin() + (type.kind == TypeKind::kVector ? type.count : 1)));
}

void write(Translator& t, const Instruction& inst) {
  const ImageAccess a = access_for(t, inst, 1, 2, 4);
  const Values texel = t.values(inst, 3);
  const Type& type = t.type_of(inst, 3);
  const bool fits = (type.is_scalar() || type.kind == TypeKind::kVector) && t.b.type(texel[0]) == a.component;
  if (!fits) inst.fail("the texel does not have the image's type");
  bool ok = true;
  t.effect([&] { ok = t.stage.image_store(t.b, a, texel); });
  if (!ok) inst.fail("this image cannot be written here");
}

// A pointer whose base, limit and offset the kernel computes; only atomics use it.
void texel_pointer(Translator& t, const Instruction& inst) {
  const Pointer variable = t.pointer(inst, 3);
  if (variable.storage != spv::StorageClassUniformConstant) inst.fail("needs a pointer to an image");
  const Type& type = t.m.type(variable.pointee);
  if (type.kind != TypeKind::kImage) inst.fail("needs a pointer to an image");
  ImageAccess a = access_of(t, inst, opaque_of(t, inst, variable), 4);
  if (ir::size_bytes(a.component) != 4) inst.fail("only 32-bit texels have atomics");
  const bool has_atomics = a.format == VK_FORMAT_R32_UINT || a.format == VK_FORMAT_R32_SINT || a.format == VK_FORMAT_R32_SFLOAT;
  if (!has_atomics) inst.fail("atomics need an image declared as R32ui, R32i or R32f");
  if (type.image.multisampled) a.sample = t.scalar(inst, 5, ir::Type::kI32);
  const std::optional<ir::Address> texel = t.stage.image_texel(t.b, a);
  if (!texel) inst.fail("this image has no atomics here");
  t.define(inst, Pointer{.pointee = type.element,
                         .storage = spv::StorageClassImage,
                         .index = texel->offset,
                         .base = texel->base,
                         .size_bytes = texel->limit});
}

void sampled_image(Translator& t, const Instruction& inst) {
  Opaque o = t.opaque(inst, 3);
  const Opaque sampler = t.opaque(inst, 4);
  if (o.image_type == 0 || sampler.image_type != 0) inst.fail("needs an image and a sampler");
  o.has_sampler = true;
  o.sampler = sampler.sampler;
  t.define(inst, o);
}

void image_of(Translator& t, const Instruction& inst) {
  Opaque o = t.opaque(inst, 3);
  image_type(t, inst, o);
  o.has_sampler = false;
  t.define(inst, o);
}

constexpr auto kImplicit = Explicit::kNo;
constexpr auto kExplicit = Explicit::kYes;

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(SampledImage, 5, sampled_image),
    PINEDA_SPIRV_ROW(Image, 4, image_of),
    PINEDA_SPIRV_ROW(ImageSampleImplicitLod, 5, sample<kImplicit, Compare::kNo, Projective::kNo>),
    PINEDA_SPIRV_ROW(ImageSampleExplicitLod, 7, sample<kExplicit, Compare::kNo, Projective::kNo>),
    PINEDA_SPIRV_ROW(ImageSampleDrefImplicitLod, 6, sample<kImplicit, Compare::kYes, Projective::kNo>),
    PINEDA_SPIRV_ROW(ImageSampleDrefExplicitLod, 8, sample<kExplicit, Compare::kYes, Projective::kNo>),
    PINEDA_SPIRV_ROW(ImageSampleProjImplicitLod, 5, sample<kImplicit, Compare::kNo, Projective::kYes>),
    PINEDA_SPIRV_ROW(ImageSampleProjExplicitLod, 7, sample<kExplicit, Compare::kNo, Projective::kYes>),
    PINEDA_SPIRV_ROW(ImageSampleProjDrefImplicitLod, 6, sample<kImplicit, Compare::kYes, Projective::kYes>),
    PINEDA_SPIRV_ROW(ImageSampleProjDrefExplicitLod, 8, sample<kExplicit, Compare::kYes, Projective::kYes>),
    PINEDA_SPIRV_ROW(ImageFetch, 5, fetch),
    PINEDA_SPIRV_ROW(ImageGather, 6, gather<Compare::kNo>),
    PINEDA_SPIRV_ROW(ImageDrefGather, 6, gather<Compare::kYes>),
    PINEDA_SPIRV_ROW(ImageRead, 5, read),
    PINEDA_SPIRV_ROW(ImageWrite, 4, write),
    PINEDA_SPIRV_ROW(ImageTexelPointer, 6, texel_pointer),
};

}  // namespace

std::span<const OpRow> image_rows() { return kRows; }

}  // namespace pineda::spirv
