#include "tools/fuzz/memory_stage.h"

#include <cstddef>

namespace pineda::fuzz {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

constexpr uint8_t kFixed = ir::kInvariant | ir::kSpeculate;
constexpr uint32_t kArray = 4;  // entries of each array of descriptors; indices wrap

Value as_float(Builder& b, Value v) {
  if (!v) return b.f32(0);
  return b.type(v) == Type::kF32 ? v : b.convert(Op::kSToF, Type::kF32, v);
}

Value as_type(Builder& b, Type type, Value v) {
  if (b.type(v) == type) return v;
  return type == Type::kF32 ? b.convert(Op::kSToF, type, v) : b.convert(Op::kFToS, type, v);
}

}  // namespace

ir::Address MemoryStage::slot(Builder& b) {
  const uint32_t index = slots_ < kMaxSlots ? slots_ : 0;
  overflowed_ |= slots_++ >= kMaxSlots;
  const auto offset = static_cast<uint32_t>(offsetof(WaveRecord, words) + index * sizeof(uint32_t) * kLanes);
  return {.base = b.wave_ptr(), .offset = b.i32(offset), .lane_stride = 4};
}

Value MemoryStage::input(Builder& b, const spirv::InterfaceScalar& in) {
  if (in.type == Type::kB1) return b.ine(b.load(Type::kI32, slot(b), ir::kInvariant), b.i32(0));
  return b.load(in.type, slot(b), ir::kInvariant);
}

// A word of its own, which the place moves a little.
Value MemoryStage::input_at(Builder& b, const spirv::InterfaceScalar& in, const spirv::InterpolationPlace& place) {
  Value moved = input(b, in);
  if (b.type(moved) != Type::kF32) return moved;
  for (const Value by : {as_float(b, place.sample), as_float(b, place.offset[0]), as_float(b, place.offset[1])}) {
    moved = b.fadd(b.fmul(moved, b.f32(0.75)), by);
  }
  return place.centroid ? b.fneg(moved) : moved;
}

void MemoryStage::output(Builder& b, const spirv::InterfaceScalar&, Value value) {
  b.store(slot(b), b.type(value) == Type::kB1 ? b.convert(Op::kZExt, Type::kI32, value) : value);
}

spirv::BufferRef MemoryStage::entry(Builder& b, Value index) {
  const Value at = b.imul(index, b.i32(sizeof(Table::Buffer)));
  const auto field = [&](Type type, size_t offset_bytes) {
    return b.load(type, {.base = b.draw_ptr(), .offset = b.iadd(at, b.i32(static_cast<uint32_t>(offset_bytes)))}, kFixed);
  };
  return {.base = field(Type::kPtr, offsetof(Table::Buffer, address)),
          .size_bytes = field(Type::kI32, offsetof(Table::Buffer, size_bytes))};
}

std::optional<spirv::BufferRef> MemoryStage::buffer(Builder& b, uint32_t set, uint32_t binding, Value array_index) {
  if (set == kPushConstants) {
    return spirv::BufferRef{.base = b.ptr_add(b.draw_ptr(), b.i32(offsetof(Table, push_constants))),
                            .size_bytes = b.i32(kMaxPushConstantBytes),
                            .read_only = true};
  }
  const auto [found, is_new] =
      buffers_.emplace(std::pair(set, binding), kFirstBuffer + kArray * static_cast<uint32_t>(buffers_.size()));
  if (found->second + kArray > Table::kBuffers) {
    overflowed_ = true;
    return std::nullopt;
  }
  return entry(b, b.iadd(b.i32(found->second), b.and_(array_index, b.i32(kArray - 1))));
}

std::optional<std::array<Value, 4>> MemoryStage::sample(Builder& b, const spirv::SampleRequest& r) {
  Value mixed = b.fmul(as_float(b, r.lod), b.f32(0.125));
  for (uint32_t i = 0; i < 4; ++i) mixed = b.fadd(b.fmul(mixed, b.f32(0.75)), as_float(b, r.coord[i]));
  for (uint32_t i = 0; i < 3; ++i) mixed = b.fadd(mixed, b.fsub(as_float(b, r.ddx[i]), as_float(b, r.ddy[i])));
  const Value depth = as_float(b, r.depth_reference);
  std::array<Value, 4> out{mixed, b.fmul(mixed, b.f32(0.5)), b.fsub(mixed, depth), b.f32(1)};
  for (Value& v : out) v = as_type(b, r.result, v);
  return out;
}

std::optional<std::array<Value, 4>> MemoryStage::query(Builder& b, const spirv::ImageQuery& q) {
  if (q.kind == spirv::ImageQuery::Kind::kLod)
    return std::array<Value, 4>{as_float(b, q.coord[0]), as_float(b, q.coord[1]), b.f32(0), b.f32(0)};
  return std::array<Value, 4>{b.i32(16), b.i32(8), b.i32(4), b.i32(6)};
}

// One word for each (x, y) modulo 16 and each layer modulo 4.
Value MemoryStage::texel_offset(Builder& b, const spirv::ImageAccess& a) {
  const auto part = [&](uint32_t i, uint32_t mask, uint32_t scale) {
    return a.coord[i] ? b.imul(b.and_(a.coord[i], b.i32(mask)), b.i32(4 * scale)) : b.i32(0);
  };
  return b.iadd(b.iadd(part(0, 15, 1), part(1, 15, 16)), part(2, 3, 256));
}

std::optional<std::array<Value, 4>> MemoryStage::image_load(Builder& b, const spirv::ImageAccess& a) {
  const spirv::BufferRef image = entry(b, b.i32(kImage));
  const Value v = b.load(a.component, {.base = image.base, .offset = texel_offset(b, a), .limit = image.size_bytes});
  return std::array<Value, 4>{v, v, v, v};
}

bool MemoryStage::image_store(Builder& b, const spirv::ImageAccess& a, std::span<const Value> texel) {
  const spirv::BufferRef image = entry(b, b.i32(kImage));
  b.store({.base = image.base, .offset = texel_offset(b, a), .limit = image.size_bytes}, texel[0]);
  return true;
}

std::optional<ir::Address> MemoryStage::image_texel(Builder& b, const spirv::ImageAccess& a) {
  const spirv::BufferRef image = entry(b, b.i32(kImage));
  const Value offset = b.and_(texel_offset(b, a), b.i32(0 - ir::size_bytes(a.component)));
  return ir::Address{.base = image.base, .offset = offset, .limit = image.size_bytes};
}

Value MemoryStage::covered(Builder& b) {
  return b.unpack_mask(b.load(Type::kI32, b.wave_ptr(), offsetof(WaveRecord, coverage), kFixed));
}

Value MemoryStage::shared_memory(Builder& b) { return entry(b, b.i32(kShared)).base; }

std::array<Value, 2> MemoryStage::address_ranges(Builder& b) {
  return {b.ptr_add(b.draw_ptr(), b.i32(offsetof(Table, ranges))), b.i32(std::size(Table{}.ranges))};
}

void MemoryStage::finish(Builder& b, const spirv::Translation& translation) {
  if (translation.discarded) output(b, {}, translation.discarded);
}

}  // namespace pineda::fuzz
