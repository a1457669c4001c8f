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

bool has_depth_stencil(const compiler::FragmentState& state) {
  const bool has_depth = state.depth.format != VK_FORMAT_UNDEFINED;
  return (has_depth && (state.depth.test_enable || state.depth.bounds_test)) || state.stencil.test_enable;
}

DepthStencil::DepthStencil(Builder& b, const compiler::FragmentState& state, Value plane) : state_(state) {
  if (state.depth.test_enable || state.depth.bounds_test) depth_format_ = find_format(state.depth.format);
  if (depth_format_) depth_.emplace(b, *depth_format_, offsetof(ThreadContext, depth), plane);
  if (!state.stencil.test_enable) return;
  stencil_.emplace(b, *find_format(VK_FORMAT_S8_UINT), offsetof(ThreadContext, stencil), plane);
  is_front_ = b.ine(b.load(Type::kI32, b.prim_ptr(), offsetof(FragmentPrim, front_facing), kFixed), b.i32(0));
}

void DepthStencil::set_depth(Builder& b, Value z) {
  if (!depth_format_ || !state_.depth.test_enable) return;
  if (state_.depth_clamp) {
    const Value viewport = b.load(Type::kI32, b.prim_ptr(), offsetof(FragmentPrim, viewport_index), kFixed);
    const Value range = b.ptr_add(b.draw_ptr(), b.shl(viewport, b.i32(3)));
    const auto end = [&](uint32_t i) {
      return b.load(Type::kF32, range, static_cast<uint32_t>(offsetof(DrawContext, depth_range) + i * sizeof(float)), kFixed);
    };
    const Value low = end(0), high = end(1);
    z = b.fmin(b.fmax(low, z), high);
  }
  // "If the depth attachment has a fixed-point format ... or VK_EXT_depth_range_unrestricted is not enabled" depths are in [0,
  // 1]. No NaN is ever stored: Hi-Z orders what is.
  if (state_.depth.unrestricted && depth_format_->numeric == Numeric::kSfloat)
    z = b.select(b.feq(z, z), z, b.f32(0));
  else
    z = clamp(b, z, 0, 1);
  code_ = pack(b, *depth_format_, {z})[0];
}

// The bits of the buffer's depth, or the F32 that they are.
Value DepthStencil::stored_depth(Builder& b) {
  const Words& old = depth_->old(b);
  if (depth_format_->numeric == Numeric::kSfloat) return b.bitcast(Type::kF32, old[0]);
  return depth_format_->component[0].bits < 8 * depth_format_->texel_bytes ? extract_code(b, *depth_format_, 0, old) : old[0];
}

// "The depth bounds test compares the depth value z_a in the depth/stencil attachment at each sample location": not the
// fragment's.
Value DepthStencil::in_bounds(Builder& b) {
  const Value stored = unpack_component(b, *depth_format_, 0, depth_->old(b));
  const auto bound = [&](uint32_t i) {
    return load_draw(b, Type::kF32, offsetof(DrawContext, depth_bounds) + i * sizeof(float));
  };
  return b.and_(b.fle(bound(0), stored), b.fle(stored, bound(1)));
}

Value DepthStencil::depth_passes(Builder& b) {
  const Value fresh = depth_format_->numeric == Numeric::kSfloat ? b.bitcast(Type::kF32, code_) : code_;
  return compare(b, state_.depth.compare, fresh, stored_depth(b));
}

// A field of the DrawContext that has one value for each face.
Value DepthStencil::face_value(Builder& b, size_t offset_bytes) {
  return b.select(is_front_, load_draw(b, Type::kI32, offset_bytes), load_draw(b, Type::kI32, offset_bytes + sizeof(uint32_t)));
}

Value DepthStencil::stencil_reference(Builder& b) {
  const Value reference = exported_reference_ ? exported_reference_ : face_value(b, offsetof(DrawContext, stencil_reference));
  return b.and_(reference, b.i32(0xff));
}

Value DepthStencil::stencil_passes(Builder& b) {
  const Value mask = face_value(b, offsetof(DrawContext, stencil_compare_mask));
  const Value reference = b.and_(stencil_reference(b), mask), stored = b.and_(stencil_->old(b)[0], mask);
  const compiler::StencilState& s = state_.stencil;
  const Value front = compare(b, s.front.compare, reference, stored);
  if (s.front.compare == s.back.compare) return front;
  return b.select(is_front_, front, compare(b, s.back.compare, reference, stored));
}

Value DepthStencil::test(Builder& b, Value covered) {
  if (depth_format_ && state_.depth.bounds_test) covered = b.and_(covered, in_bounds(b));
  tested_ = covered;
  stencil_passed_ = stencil_ ? stencil_passes(b) : Value{};
  depth_passed_ = depth_format_ && state_.depth.test_enable ? depth_passes(b) : Value{};
  if (stencil_passed_) covered = b.and_(covered, stencil_passed_);
  if (depth_passed_) covered = b.and_(covered, depth_passed_);
  return covered;
}

namespace {

Value apply(Builder& b, VkStencilOp op, Value old, Value reference) {
  const auto wrap = [&](Value v) { return b.and_(v, b.i32(0xff)); };
  switch (op) {
    case VK_STENCIL_OP_ZERO:
      return b.i32(0);
    case VK_STENCIL_OP_REPLACE:
      return reference;
    case VK_STENCIL_OP_INCREMENT_AND_CLAMP:
      return b.umin(b.iadd(old, b.i32(1)), b.i32(0xff));
    case VK_STENCIL_OP_DECREMENT_AND_CLAMP:
      return b.smax(b.isub(old, b.i32(1)), b.i32(0));
    case VK_STENCIL_OP_INVERT:
      return wrap(b.not_(old));
    case VK_STENCIL_OP_INCREMENT_AND_WRAP:
      return wrap(b.iadd(old, b.i32(1)));
    case VK_STENCIL_OP_DECREMENT_AND_WRAP:
      return wrap(b.isub(old, b.i32(1)));
    default:
      return old;  // KEEP
  }
}

}  // namespace

void DepthStencil::write_stencil(Builder& b) {
  if (!stencil_ || !state_.stencil.writes()) return;
  const Value old = stencil_->old(b)[0], reference = stencil_reference(b);
  const auto result = [&](const compiler::StencilFace& face) {
    Value value = apply(b, face.pass, old, reference);
    if (depth_passed_ && face.depth_fail != face.pass)
      value = b.select(depth_passed_, value, apply(b, face.depth_fail, old, reference));
    return b.select(stencil_passed_, value, apply(b, face.fail, old, reference));
  };
  const compiler::StencilState& s = state_.stencil;
  Value value = result(s.front);
  if (!(s.front == s.back)) value = b.select(is_front_, value, result(s.back));
  const Value mask = face_value(b, offsetof(DrawContext, stencil_write_mask));
  stencil_->store(b, {b.or_(b.and_(value, mask), b.and_(old, b.not_(mask)))}, tested_);
}

void DepthStencil::write_depth(Builder& b, Value passed) {
  if (depth_format_ && state_.depth.test_enable && state_.depth.write_enable) depth_->store(b, {code_}, passed);
}

}  // namespace pineda::kernels
