#include "compiler/kernels/stage.h"

#include <algorithm>

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/sample.h"
#include "compiler/kernels/sample_call.h"
#include "compiler/kernels/storage_image.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

bool is_dynamic(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;
}

bool is_uniform(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
}

bool is_buffer(VkDescriptorType type) {
  return is_uniform(type) || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;
}

bool is_image(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER || type == VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE ||
         type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE || type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT ||
         type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
}

// An index outside the array reads its last element.
Value clamp_index(Builder& b, Value index, uint32_t count) {
  return index && count > 1 ? b.umin(index, b.i32(count - 1)) : Value{};
}

Value element(Builder& b, const spirv::ImageRef& ref) { return ref.index ? ref.index : b.i32(ref.array_index); }

}  // namespace

Value load_draw(Builder& b, Type type, size_t offset_bytes) {
  return b.load(type, b.draw_ptr(), static_cast<uint32_t>(offset_bytes), kFixed);
}

const compiler::DescriptorBinding* Stage::find(uint32_t set, uint32_t binding) const {
  const auto found = std::ranges::find_if(
      layout_.bindings, [&](const compiler::DescriptorBinding& d) { return d.set == set && d.binding == binding; });
  return found != layout_.bindings.end() && found->set < kMaxSets && found->count > 0 ? &*found : nullptr;
}

Value Stage::descriptor(Builder& b, const compiler::DescriptorBinding& where, Value array_index) const {
  const Value set = load_draw(b, Type::kPtr, offsetof(DrawContext, sets) + where.set * sizeof(void*));
  Value offset = b.i32(where.offset_bytes);
  if (const Value index = clamp_index(b, array_index, where.count))
    offset = b.iadd(offset, b.imul(index, b.i32(where.stride_bytes)));
  return b.ptr_add(set, offset);
}

std::optional<spirv::BufferRef> Stage::buffer(Builder& b, uint32_t set, uint32_t binding, Value array_index) {
  if (set == kPushConstants) {
    const uint32_t size = std::min(layout_.push_constant_bytes, kMaxPushConstantBytes);
    return spirv::BufferRef{b.ptr_add(b.draw_ptr(), b.i32(offsetof(DrawContext, push_constants))), b.i32(size), true};
  }
  const compiler::DescriptorBinding* where = find(set, binding);
  if (!where || !is_buffer(where->type)) {
    return refuse(concat("The pipeline layout has no buffer at set ", set, ", binding ", binding, "."));
  }
  const Value at = descriptor(b, *where, array_index);
  Value base = b.load(Type::kPtr, at, offsetof(BufferDescriptor, address), kFixed);
  const Value size = b.load(Type::kI32, at, offsetof(BufferDescriptor, size_bytes), kFixed);
  if (is_dynamic(where->type)) {
    if (where->dynamic_index + where->count > kMaxDynamicOffsets) return refuse("Too many dynamic offsets.");
    const Value first = b.i32(static_cast<uint32_t>(offsetof(DrawContext, dynamic_offsets) + 4 * where->dynamic_index));
    const Value index = clamp_index(b, array_index, where->count);
    const ir::Address slot{.base = b.draw_ptr(), .offset = index ? b.iadd(first, b.shl(index, b.i32(2))) : first};
    base = b.ptr_add(base, b.load(Type::kI32, slot, kFixed));
  }
  return spirv::BufferRef{base, size, is_uniform(where->type)};
}

std::array<Value, 2> Stage::address_ranges(Builder& b) {
  return {load_draw(b, Type::kPtr, offsetof(DrawContext, address_ranges)),
          load_draw(b, Type::kI32, offsetof(DrawContext, address_range_count))};
}

const compiler::TextureState* Stage::texture_state(const spirv::ImageRef& image, const spirv::ImageRef& sampler) const {
  const auto exact = std::ranges::find_if(
      textures_, [&](const compiler::TextureUse& use) { return use.image == image && use.sampler == sampler; });
  return exact != textures_.end() ? &exact->state : nullptr;
}

Value Stage::image_descriptor(Builder& b, const spirv::ImageRef& image) {
  const compiler::DescriptorBinding* where = find(image.set, image.binding);
  if (!where || !is_image(where->type) || (!image.index && image.array_index >= where->count)) {
    refuse(
        concat("The pipeline layout has no image at set ", image.set, ", binding ", image.binding, "[", image.array_index, "]."));
    return {};
  }
  return descriptor(b, *where, element(b, image));
}

Value Stage::sampler_words(Builder& b, const spirv::ImageRef& image, const spirv::ImageRef& sampler, Value image_descriptor) {
  constexpr uint32_t kWords = offsetof(ImageDescriptor, lod_bias);  // in the tail of a combined descriptor
  if (sampler == image) return image_descriptor ? b.ptr_add(image_descriptor, b.i32(kWords)) : Value{};
  const compiler::DescriptorBinding* where = find(sampler.set, sampler.binding);
  if (!where || (!sampler.index && sampler.array_index >= where->count)) {
    refuse(concat("The pipeline layout has no sampler at set ", sampler.set, ", binding ", sampler.binding, "."));
    return {};
  }
  const Value words = descriptor(b, *where, element(b, sampler));
  return where->type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ? b.ptr_add(words, b.i32(kWords)) : words;
}

// What the pipeline was specialised for, or null: then the descriptors tell when the kernel runs.
const compiler::TextureState* Stage::known_state(const spirv::ImageRef& image, const spirv::ImageRef& sampler, bool fetch) const {
  if (image.index || sampler.index) return nullptr;
  if (const compiler::TextureState* exact = texture_state(image, sampler)) return exact;
  if (!fetch) return nullptr;  // a fetch has no sampler: any use of the image tells its format
  const auto any = std::ranges::find(textures_, image, &compiler::TextureUse::image);
  return any != textures_.end() ? &any->state : nullptr;
}

Value Stage::common_input(Builder& b, const spirv::InterfaceScalar& in) {
  using spirv::BuiltIn;
  if (!in.built_in || in.component > 3) return {};
  const auto ones = [&](uint32_t bits) { return b.shl(b.i32(bits), b.lane()); };  // from this lane on
  Value mask;
  switch (*in.built_in) {
    case BuiltIn::kSubgroupSize:
      return b.i32(kLanes);
    case BuiltIn::kSubgroupLocalInvocationId:
      return b.lane();
    case BuiltIn::kSubgroupEqMask:
      mask = ones(1);
      break;
    case BuiltIn::kSubgroupGeMask:
      mask = ones(~0u);
      break;
    case BuiltIn::kSubgroupGtMask:
      mask = ones(~1u);
      break;
    case BuiltIn::kSubgroupLeMask:
      mask = b.not_(ones(~1u));
      break;
    case BuiltIn::kSubgroupLtMask:
      mask = b.not_(ones(~0u));
      break;
    default:
      return {};
  }
  return in.component == 0 ? b.and_(mask, b.i32((1u << kLanes) - 1)) : b.i32(0);  // bits of 16 lanes only
}

std::optional<std::array<Value, 4>> Stage::sample(Builder& b, const spirv::SampleRequest& request) {
  const bool fetch = request.lod_mode == spirv::LodMode::kFetch;
  const Value image = image_descriptor(b, request.image);
  const Value sampler = fetch ? image : sampler_words(b, request.image, request.sampler, image);
  if (!image || !sampler) return std::nullopt;
  const compiler::TextureState* state = known_state(request.image, request.sampler, fetch);
  const Result<Channels> texel =
      state ? sample_image(b, {*state, image, sampler}, request) : call_sample(b, image, sampler, request);
  if (!texel) return refuse(texel.error().text);
  return *texel;
}

std::optional<std::array<Value, 4>> Stage::query(Builder& b, const spirv::ImageQuery& query) {
  const Value image = image_descriptor(b, query.image);
  if (!image) return std::nullopt;
  Result<Channels> answer;
  if (query.kind == spirv::ImageQuery::Kind::kLod) {
    const Value sampler = sampler_words(b, query.image, query.sampler, image);
    if (!sampler) return std::nullopt;
    const compiler::TextureState* state = known_state(query.image, query.sampler, false);
    answer = state ? query_lod(b, {*state, image, sampler}, lod_request(b, query)) : call_query_lod(b, image, sampler, query);
  } else {
    answer = query_image(b, image, query);
  }
  if (!answer) return refuse(answer.error().text);
  return *answer;
}

std::optional<std::array<Value, 4>> Stage::image_load(Builder& b, const spirv::ImageAccess& access) {
  const Value image = image_descriptor(b, access.image);
  if (!image) return std::nullopt;
  const Result<Channels> texel = load_storage_image(b, image, access);
  if (!texel) return refuse(texel.error().text);
  return *texel;
}

std::optional<ir::Address> Stage::image_texel(Builder& b, const spirv::ImageAccess& access) {
  const Value image = image_descriptor(b, access.image);
  if (!image) return std::nullopt;
  const Result<ir::Address> texel = storage_texel(b, image, access);
  if (!texel) return refuse(texel.error().text);
  return *texel;
}

bool Stage::image_store(Builder& b, const spirv::ImageAccess& access, std::span<const Value> texel) {
  const Value image = image_descriptor(b, access.image);
  if (!image) return false;
  const Result<void> stored = store_storage_image(b, image, access, texel);
  if (!stored) refuse(stored.error().text);
  return stored.has_value();
}

}  // namespace pineda::kernels
