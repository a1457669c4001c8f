#include "compiler/kernels/tile.h"

#include <algorithm>

#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

namespace {

Type element_type(const FormatInfo& format) {
  return format.texel_bytes == 1 ? Type::kI8 : format.texel_bytes == 2 ? Type::kI16 : Type::kI32;
}

// Plane w holds word w of each lane.
ir::Address plane(Builder& b, const FormatInfo& format, Value base, uint32_t w) {
  const uint32_t element_bytes = std::min<uint32_t>(format.texel_bytes, 4);
  return {.base = base, .offset = b.i32(w * kLanes * element_bytes), .lane_stride = element_bytes};
}

}  // namespace

TileBlock::TileBlock(Builder& b, const FormatInfo& format, size_t thread_offset_bytes, Value block_index) : format_(format) {
  const Value buffer = b.load(Type::kPtr, b.thread_ptr(), static_cast<uint32_t>(thread_offset_bytes), kFixed);
  base_ = b.ptr_add(buffer, b.imul(block_index, b.i32(kLanes * format.texel_bytes)));
}

const Words& TileBlock::old(Builder& b) {
  for (uint32_t w = 0; w < word_count(format_) && !old_[w]; ++w) {
    const Value word = b.load(element_type(format_), plane(b, format_, base_, w), ir::kSpeculate);
    old_[w] = b.convert(Op::kZExt, Type::kI32, word);
  }
  return old_;
}

void TileBlock::store(Builder& b, const Words& words, Value covered) {
  old(b);
  for (uint32_t w = 0; w < word_count(format_); ++w) {
    const Value merged = b.select(covered, words[w], old_[w]);
    b.store(plane(b, format_, base_, w), b.convert(Op::kTrunc, element_type(format_), merged), ir::kAllLanes);
  }
}

void TileBlock::replace(Builder& b, const Words& words) {
  for (uint32_t w = 0; w < word_count(format_); ++w)
    b.store(plane(b, format_, base_, w), b.convert(Op::kTrunc, element_type(format_), words[w]), ir::kAllLanes);
}

}  // namespace pineda::kernels
