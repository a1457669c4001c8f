#include "compiler/kernels/storage_image.h"

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// Where a texel is, but for its column, which depends on the format.
struct Place {
  Value column, inside;
  ir::Address row;
};

Value image_word(Builder& b, Value image, size_t offset_bytes) {
  return b.load(Type::kI32, image, static_cast<uint32_t>(offset_bytes), kFixed);
}

bool has_layers(VkImageViewType type) {
  return type != VK_IMAGE_VIEW_TYPE_1D && type != VK_IMAGE_VIEW_TYPE_2D && type != VK_IMAGE_VIEW_TYPE_3D;
}

// A cube is an array of its faces. Slices of a volume, and samples, follow each other.
Place locate(Builder& b, Value image, const spirv::ImageAccess& access) {
  const bool is_1d = access.view_type == VK_IMAGE_VIEW_TYPE_1D || access.view_type == VK_IMAGE_VIEW_TYPE_1D_ARRAY;
  const Value row_pitch = image_word(b, image, offsetof(ImageDescriptor, levels) + offsetof(MipLevel, row_pitch_bytes));
  Place place{.column = access.coord[0],
              .inside = b.ult(access.coord[0], image_word(b, image, offsetof(ImageDescriptor, width)))};
  Value offset = image_word(b, image, offsetof(ImageDescriptor, levels) + offsetof(MipLevel, offset_bytes));
  const auto check = [&](Value index, size_t count_offset) {
    place.inside = b.and_(place.inside, b.ult(index, image_word(b, image, count_offset)));
  };
  Value row;
  if (!is_1d) {
    row = access.coord[1];
    check(row, offsetof(ImageDescriptor, height));
  }
  const Value slice = access.view_type == VK_IMAGE_VIEW_TYPE_3D ? access.coord[2] : access.sample;
  if (slice) {
    check(slice, offsetof(ImageDescriptor, depth));
    row = b.iadd(b.imul(slice, image_word(b, image, offsetof(ImageDescriptor, height))), row);
  }
  if (row) offset = b.iadd(offset, b.imul(row, row_pitch));
  if (has_layers(access.view_type)) {
    const Value layer = access.coord[is_1d ? 1 : 2];
    check(layer, offsetof(ImageDescriptor, layer_count));
    offset = b.iadd(offset, b.imul(layer, image_word(b, image, offsetof(ImageDescriptor, layer_pitch_bytes))));
  }
  place.row = {.base = b.load(Type::kPtr, image, offsetof(ImageDescriptor, address), kFixed),
               .offset = offset,
               .limit = image_word(b, image, offsetof(ImageDescriptor, size_bytes))};
  return place;
}

ir::Address texel_address(Builder& b, const Place& place, const FormatInfo& format) {
  ir::Address at = place.row;
  at.offset = b.iadd(at.offset, b.imul(place.column, b.i32(format.texel_bytes)));
  at.limit = b.select(place.inside, at.limit, b.i32(0));
  return at;
}

// Formats that an image declared without one may have, given the component type that the shader declares.
std::vector<const FormatInfo*> possible_formats(const spirv::ImageAccess& access) {
  std::vector<const FormatInfo*> formats;
  for (const FormatInfo& format : all_formats()) {
    if (!(format.uses & kUseStorage)) continue;
    const Numeric integer = access.is_signed ? Numeric::kSint : Numeric::kUint;
    if (access.component == Type::kF32 ? !format.is_integer() : format.numeric == integer) formats.push_back(&format);
  }
  return formats;
}

Value has_format(Builder& b, Value image, const FormatInfo& format) {
  return b.ieq(image_word(b, image, offsetof(ImageDescriptor, format)), b.i32(static_cast<uint32_t>(format.format)));
}

Channels load_as(Builder& b, const Place& place, const FormatInfo& format, Type component) {
  Channels values = unpack(b, format, load_words(b, format, texel_address(b, place, format), 0));
  for (Value& v : values) v = b.bitcast(component, v);
  return values;
}

void store_as(Builder& b, const Place& place, const FormatInfo& format, std::span<const Value> texel) {
  Channels values{};
  for (uint32_t c = 0; c < 4; ++c) {
    if (format.component[c].bits != 0) values[c] = b.bitcast(channel_type(format), texel[c]);
  }
  const Words words = pack(b, format, values);
  const ir::Address first = texel_address(b, place, format);
  const Type element = format.texel_bytes == 1 ? Type::kI8 : format.texel_bytes == 2 ? Type::kI16 : Type::kI32;
  for (uint32_t w = 0; w < word_count(format); ++w) {
    ir::Address at = first;
    at.offset = b.iadd(at.offset, b.i32(4 * w));
    b.store(at, b.convert(Op::kTrunc, element, words[w]));
  }
}

Result<void> check(const spirv::ImageAccess& access) {
  if (ir::size_bytes(access.component) != 4) return compile_error("Only 32-bit image components are supported.");
  if (access.view_type > VK_IMAGE_VIEW_TYPE_CUBE_ARRAY)
    return compile_error("This dimension of storage images is not supported.");
  if (access.format == VK_FORMAT_UNDEFINED) return {};
  const FormatInfo* format = find_format(access.format);
  if (!format || !(format->uses & kUseStorage)) return compile_error("A storage image of a format that is not supported.");
  return {};
}

}  // namespace

Result<Channels> load_storage_image(Builder& b, Value image, const spirv::ImageAccess& access) {
  if (const auto ok = check(access); !ok) return std::unexpected(ok.error());
  const Place place = locate(b, image, access);
  if (access.format != VK_FORMAT_UNDEFINED) return load_as(b, place, *find_format(access.format), access.component);
  const std::vector<Type> types(4, access.component);
  const Value zero = b.constant(Type::kI32, 0);
  std::vector<Value> texel(4, b.bitcast(access.component, zero));
  for (const FormatInfo* format : possible_formats(access)) {
    texel = b.if_else(
        has_format(b, image, *format), types,
        [&] {
          const Channels values = load_as(b, place, *format, access.component);
          return std::vector<Value>(values.begin(), values.end());
        },
        [&] { return texel; });
  }
  return Channels{texel[0], texel[1], texel[2], texel[3]};
}

Result<ir::Address> storage_texel(Builder& b, Value image, const spirv::ImageAccess& access) {
  if (const auto ok = check(access); !ok) return std::unexpected(ok.error());
  return texel_address(b, locate(b, image, access), *find_format(access.format));
}

Result<void> store_storage_image(Builder& b, Value image, const spirv::ImageAccess& access, std::span<const Value> texel) {
  if (const auto ok = check(access); !ok) return std::unexpected(ok.error());
  const FormatInfo* declared = find_format(access.format);
  for (uint32_t c = 0; c < 4; ++c) {
    if (declared && declared->component[c].bits == 0) continue;
    if (c >= texel.size() || !texel[c] || ir::size_bytes(b.type(texel[c])) != 4) {
      return compile_error(
          concat("A store to a storage image of format ", declared ? declared->name : "unknown", " lacks components."));
    }
  }
  const Place place = locate(b, image, access);
  if (declared) {
    store_as(b, place, *declared, texel);
    return {};
  }
  for (const FormatInfo* format : possible_formats(access)) {
    b.if_(has_format(b, image, *format), [&] { store_as(b, place, *format, texel); });
  }
  return {};
}

}  // namespace pineda::kernels
