#include "compiler/kernels/storage_image.h"

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/sample_lod.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

struct Texel {
  const FormatInfo* format;
  ir::Address at;
};

Value image_word(Builder& b, Value image, size_t offset_bytes) {
  return b.load(Type::kI32, image, static_cast<uint32_t>(offset_bytes), kFixed);
}

Result<Texel> locate(Builder& b, Value image, const spirv::ImageAccess& access) {
  const FormatInfo* format = find_format(access.format);
  if (!format) return compile_error("A storage image without a declared format, or of one that is not supported.");
  if (access.view_type > VK_IMAGE_VIEW_TYPE_CUBE_ARRAY || axis_count(access.view_type) > 2) {
    return compile_error("3D and cube storage images are not supported.");
  }
  const uint32_t axes = axis_count(access.view_type);
  const bool array = access.view_type == VK_IMAGE_VIEW_TYPE_1D_ARRAY || access.view_type == VK_IMAGE_VIEW_TYPE_2D_ARRAY;
  Value inside = b.ult(access.coord[0], image_word(b, image, offsetof(ImageDescriptor, width)));
  Value offset = b.iadd(image_word(b, image, offsetof(ImageDescriptor, levels) + offsetof(MipLevel, offset_bytes)),
                        b.imul(access.coord[0], b.i32(format->texel_bytes)));
  const auto step = [&](Value index, size_t count_offset, size_t pitch_offset) {
    inside = b.and_(inside, b.ult(index, image_word(b, image, count_offset)));
    offset = b.iadd(offset, b.imul(index, image_word(b, image, pitch_offset)));
  };
  if (axes == 2) {
    step(access.coord[1], offsetof(ImageDescriptor, height),
         offsetof(ImageDescriptor, levels) + offsetof(MipLevel, row_pitch_bytes));
  }
  if (array) step(access.coord[axes], offsetof(ImageDescriptor, layer_count), offsetof(ImageDescriptor, layer_pitch_bytes));
  const Value limit = b.select(inside, image_word(b, image, offsetof(ImageDescriptor, size_bytes)), b.i32(0));
  const Value base = b.load(Type::kPtr, image, offsetof(ImageDescriptor, address), kFixed);
  return Texel{format, {.base = base, .offset = offset, .limit = limit}};
}

}  // namespace

Result<Channels> load_storage_image(Builder& b, Value image, const spirv::ImageAccess& access) {
  if (ir::size_bytes(access.component) != 4) return compile_error("Only 32-bit image components are supported.");
  const Result<Texel> texel = locate(b, image, access);
  if (!texel) return std::unexpected(texel.error());
  Channels values = unpack(b, *texel->format, load_words(b, *texel->format, texel->at, 0));
  for (Value& v : values) v = b.bitcast(access.component, v);
  return values;
}

Result<void> store_storage_image(Builder& b, Value image, const spirv::ImageAccess& access, std::span<const Value> texel) {
  const Result<Texel> where = locate(b, image, access);
  if (!where) return std::unexpected(where.error());
  const FormatInfo& format = *where->format;
  Channels values{};
  for (uint32_t c = 0; c < 4; ++c) {
    if (format.component[c].bits == 0) continue;
    if (c >= texel.size() || !texel[c] || ir::size_bytes(b.type(texel[c])) != 4) {
      return compile_error(concat("A store to a storage image of format ", format.name, " lacks components."));
    }
    values[c] = b.bitcast(channel_type(format), texel[c]);
  }
  const Words words = pack(b, format, values);
  const Type element = format.texel_bytes == 1 ? Type::kI8 : format.texel_bytes == 2 ? Type::kI16 : Type::kI32;
  for (uint32_t w = 0; w < word_count(format); ++w) {
    ir::Address at = where->at;
    at.offset = b.iadd(at.offset, b.i32(4 * w));
    b.store(at, b.convert(Op::kTrunc, element, words[w]));
  }
  return {};
}

}  // namespace pineda::kernels
