#include "compiler/kernels/samples.h"

#include <bit>

#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

namespace {

constexpr uint32_t kMostUnrolled = 4;

}  // namespace

Value sample_plane(Builder& b, uint32_t samples, Value block_index, Value sample) {
  return b.iadd(b.shl(block_index, b.i32(static_cast<uint32_t>(std::countr_zero(samples)))), sample);
}

void for_samples(Builder& b, uint32_t samples, const std::function<void(Value sample)>& body) {
  if (samples <= kMostUnrolled) {
    for (uint32_t s = 0; s < samples; ++s) body(b.i32(s));
    return;
  }
  b.loop({b.i32(0)}, [&](std::span<const Value> carried) -> Builder::LoopStep {
    body(carried[0]);
    const Value next = b.iadd(carried[0], b.i32(1));
    return {b.ult(next, b.i32(samples)), {next}};
  });
}

Value filter_samples(Builder& b, uint32_t samples, Value mask, const std::function<Value(Value sample, Value covered)>& body) {
  const auto bit = [&](Value sample) {
    const Value covered = b.ine(b.and_(b.lshr(mask, sample), b.i32(1)), b.i32(0));
    return b.shl(b.convert(Op::kZExt, Type::kI32, body(sample, covered)), sample);
  };
  if (samples <= kMostUnrolled) {
    Value kept = b.i32(0);
    for (uint32_t s = 0; s < samples; ++s) kept = b.or_(kept, bit(b.i32(s)));
    return kept;
  }
  const std::vector<Value> results = b.loop({b.i32(0), b.i32(0)}, [&](std::span<const Value> carried) -> Builder::LoopStep {
    const Value kept = b.or_(carried[1], bit(carried[0])), next = b.iadd(carried[0], b.i32(1));
    return {b.ult(next, b.i32(samples)), {next, kept}};
  });
  return results[1];
}

EqualSamples::EqualSamples(Builder& b, Value block_index)
    : at_{.base = b.load(Type::kPtr, b.thread_ptr(), offsetof(ThreadContext, equal_samples), kFixed), .offset = block_index} {}

Value EqualSamples::load(Builder& b) const { return b.ine(b.load(Type::kI8, at_), b.constant(Type::kI8, 0)); }

void EqualSamples::store(Builder& b, bool equal) const { b.store(at_, b.constant(Type::kI8, equal)); }

void spread_sample_0(Builder& b, const FormatInfo& format, size_t thread_offset_bytes, uint32_t samples, Value block_index) {
  TileBlock first(b, format, thread_offset_bytes, sample_plane(b, samples, block_index, b.i32(0)));
  const Words texels = first.old(b);
  for_samples(b, samples, [&](Value sample) {
    TileBlock(b, format, thread_offset_bytes, sample_plane(b, samples, block_index, sample)).replace(b, texels);
  });
}

}  // namespace pineda::kernels
