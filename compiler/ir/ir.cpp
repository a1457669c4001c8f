#include "compiler/ir/ir.h"

#include <iterator>

namespace pineda::ir {
namespace {

constexpr OpInfo kOps[] = {
    {"invalid", 0, TypeRule::kAny, Effect::kPure},
#define PINEDA_IR_OP(name, text, operands, rule, effect) {text, operands, TypeRule::k##rule, Effect::k##effect},
#include "compiler/ir/ops.inc"
#undef PINEDA_IR_OP
};
static_assert(std::size(kOps) == static_cast<size_t>(Op::kCount));

}  // namespace

const OpInfo& op_info(Op op) { return kOps[op < Op::kCount ? static_cast<size_t>(op) : 0]; }

bool is_commutative(Op op) {
  switch (op) {
    case Op::kIAdd:
    case Op::kIMul:
    case Op::kUMulHi:
    case Op::kSMulHi:
    case Op::kMAdd16:
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor:
    case Op::kSMin:
    case Op::kSMax:
    case Op::kUMin:
    case Op::kUMax:
    case Op::kIEq:
    case Op::kINe:
    case Op::kFAdd:
    case Op::kFMul:
    case Op::kFEq:
    case Op::kFNe:
      return true;
    default:
      return false;
  }
}

Op combining_op(ReduceOp op) {
  constexpr Op kCombining[] = {Op::kIAdd, Op::kIMul, Op::kSMin, Op::kSMax, Op::kUMin, Op::kUMax, Op::kAnd,
                               Op::kOr,   Op::kXor,  Op::kFAdd, Op::kFMul, Op::kFMin, Op::kFMax};
  static_assert(std::size(kCombining) == static_cast<size_t>(ReduceOp::kCount));
  return op < ReduceOp::kCount ? kCombining[static_cast<size_t>(op)] : Op::kInvalid;
}

const char* type_name(Type t) {
  switch (t) {
    case Type::kVoid:
      return "void";
    case Type::kB1:
      return "b1";
    case Type::kI8:
      return "i8";
    case Type::kI16:
      return "i16";
    case Type::kI32:
      return "i32";
    case Type::kI64:
      return "i64";
    case Type::kF16:
      return "f16";
    case Type::kF32:
      return "f32";
    case Type::kF64:
      return "f64";
    case Type::kPtr:
      return "ptr";
  }
  return "?";
}

}  // namespace pineda::ir
