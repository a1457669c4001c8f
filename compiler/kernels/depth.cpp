#include "compiler/kernels/depth.h"

#include "base/abi.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Type;
using ir::Value;

Value compare(Builder& b, VkCompareOp op, Value a, Value c) {
  const bool is_float = ir::is_float(b.type(a));
  const auto less = [&](Value x, Value y) { return is_float ? b.flt(x, y) : b.ult(x, y); };
  const auto less_equal = [&](Value x, Value y) { return is_float ? b.fle(x, y) : b.ule(x, y); };
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return b.b1(false);
    case VK_COMPARE_OP_LESS:
      return less(a, c);
    case VK_COMPARE_OP_EQUAL:
      return is_float ? b.feq(a, c) : b.ieq(a, c);
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return less_equal(a, c);
    case VK_COMPARE_OP_GREATER:
      return less(c, a);
    case VK_COMPARE_OP_NOT_EQUAL:
      return is_float ? b.fne(a, c) : b.ine(a, c);
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return less_equal(c, a);
    default:
      return b.b1(true);
  }
}

DepthTest::DepthTest(Builder& b, const compiler::FragmentState& state, Value block_index)
    : state_(state.depth), depth_clamp_(state.depth_clamp) {
  if (!state_.test_enable) return;
  format_ = find_format(state_.format);
  if (format_) block_.emplace(b, *format_, offsetof(ThreadContext, depth), block_index);
}

void DepthTest::set_depth(Builder& b, Value z) {
  if (depth_clamp_) {
    const Value viewport = b.load(Type::kI32, b.prim_ptr(), offsetof(FragmentPrim, viewport_index), kFixed);
    const Value range = b.ptr_add(b.draw_ptr(), b.shl(viewport, b.i32(3)));
    const auto end = [&](uint32_t i) {
      return b.load(Type::kF32, range, static_cast<uint32_t>(offsetof(DrawContext, depth_range) + i * sizeof(float)), kFixed);
    };
    const Value low = end(0), high = end(1);
    z = b.fmin(b.fmax(low, z), high);
  }
  // Without VK_EXT_depth_range_unrestricted every stored depth is in [0, 1].
  z = clamp(b, z, 0, 1);
  code_ = pack(b, *format_, {z})[0];
}

Value DepthTest::test(Builder& b, Value covered) {
  Value fresh = code_, old = block_->old(b)[0];
  if (format_->numeric == Numeric::kSfloat) {
    fresh = b.bitcast(Type::kF32, fresh);
    old = b.bitcast(Type::kF32, old);
  } else if (format_->component[0].bits < 8 * format_->texel_bytes) {
    old = extract_code(b, *format_, 0, block_->old(b));
  }
  return b.and_(covered, compare(b, state_.compare, fresh, old));
}

void DepthTest::write(Builder& b, Value passed) {
  if (state_.write_enable) block_->store(b, {code_}, passed);
}

}  // namespace pineda::kernels
