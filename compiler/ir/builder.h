// Appends instructions to a region of a Kernel. Folds nothing but constants and identities that are free to see (x + 0, select of
// a constant ...): the passes do the rest.
//
//     Builder b(kernel);                       // appends to kernel.wave, which it creates
//     Value x = b.load(Type::kF32, b.draw_ptr(), 16, kInvariant);
//     auto r = b.if_else(b.flt(x, b.f32(0)), {Type::kF32},
//                        [&] { return std::vector{b.fneg(x)}; }, [&] { return std::vector{x}; });
//
// Mutable variables (SPIR-V Function variables, break flags ...): `Var v = b.variable(type)`, b.set(v, x), b.get(v). They are
// Locals of one element; passes/ssa replaces them by values.
#pragma once

#include <functional>
#include <initializer_list>
#include <span>
#include <vector>

#include "compiler/ir/ir.h"

namespace pineda::ir {

struct Var {
  Value local;
  Type type = Type::kVoid;
};

// Where a memory access goes. `limit` unset: unchecked.
struct Address {
  Value base;    // Ptr
  Value offset;  // I32, bytes; unset = 0
  Value limit;   // I32, bytes
  uint32_t lane_stride = 0;
};

class Builder {
 public:
  explicit Builder(Kernel& kernel);  // creates kernel.draw, prim and wave when they are absent; appends to wave

  Kernel& kernel() { return *kernel_; }
  Type type(Value v) const { return kernel_->at(v).type; }
  RegionId region() const { return region_; }
  void set_region(RegionId region) { region_ = region; }

  // sources
  Value constant(Type type, uint64_t bits);  // integers, B1
  Value b1(bool v) { return constant(Type::kB1, v); }
  Value i32(uint32_t v) { return constant(Type::kI32, v); }
  Value i64(uint64_t v) { return constant(Type::kI64, v); }
  Value f32(double v) { return fconst(Type::kF32, v); }
  Value fconst(Type type, double v);
  Value zero(Type type);
  Value draw_ptr();
  Value thread_ptr();
  Value prim_ptr();
  Value wave_ptr();
  Value lane();

  // one function for each row of ops.inc that takes only operands
  Value op(Op op, Type type, std::initializer_list<Value> operands, uint64_t imm = 0, uint8_t flags = 0);
// clang-format off
#define PINEDA_UNARY(name, Name) Value name(Value a) { return same(Op::k##Name, a); }
#define PINEDA_BINARY(name, Name) Value name(Value a, Value c) { return same(Op::k##Name, a, c); }
#define PINEDA_COMPARE(name, Name) Value name(Value a, Value c) { return op(Op::k##Name, Type::kB1, {a, c}); }
  PINEDA_BINARY(iadd, IAdd) PINEDA_BINARY(isub, ISub) PINEDA_BINARY(imul, IMul) PINEDA_BINARY(umul_hi, UMulHi)
  PINEDA_BINARY(smul_hi, SMulHi) PINEDA_BINARY(madd16, MAdd16) PINEDA_BINARY(udiv, UDiv) PINEDA_BINARY(sdiv, SDiv) PINEDA_BINARY(urem, URem)
  PINEDA_BINARY(srem, SRem) PINEDA_BINARY(shl, Shl) PINEDA_BINARY(lshr, LShr) PINEDA_BINARY(ashr, AShr)
  PINEDA_BINARY(and_, And) PINEDA_BINARY(or_, Or) PINEDA_BINARY(xor_, Xor) PINEDA_UNARY(not_, Not)
  PINEDA_BINARY(smin, SMin) PINEDA_BINARY(smax, SMax) PINEDA_BINARY(umin, UMin) PINEDA_BINARY(umax, UMax)
  PINEDA_UNARY(clz, Clz) PINEDA_UNARY(ctz, Ctz) PINEDA_UNARY(popcount, PopCount) PINEDA_UNARY(bitreverse, BitReverse)
  PINEDA_COMPARE(ieq, IEq) PINEDA_COMPARE(ine, INe) PINEDA_COMPARE(ult, ULt) PINEDA_COMPARE(ule, ULe)
  PINEDA_COMPARE(slt, SLt) PINEDA_COMPARE(sle, SLe)
  PINEDA_BINARY(fadd, FAdd) PINEDA_BINARY(fsub, FSub) PINEDA_BINARY(fmul, FMul) PINEDA_BINARY(fdiv, FDiv)
  PINEDA_BINARY(fmin, FMin) PINEDA_BINARY(fmax, FMax) PINEDA_UNARY(fsqrt, FSqrt) PINEDA_UNARY(fneg, FNeg)
  PINEDA_UNARY(fabs, FAbs) PINEDA_UNARY(ffloor, FFloor) PINEDA_UNARY(fceil, FCeil) PINEDA_UNARY(ftrunc, FTrunc)
  PINEDA_UNARY(fround_even, FRoundEven) PINEDA_UNARY(fcanon, FCanon)
  PINEDA_COMPARE(feq, FEq) PINEDA_COMPARE(fne, FNe) PINEDA_COMPARE(flt, FLt) PINEDA_COMPARE(fle, FLe)
  PINEDA_UNARY(fsin, FSin) PINEDA_UNARY(fcos, FCos) PINEDA_UNARY(ftan, FTan) PINEDA_UNARY(fasin, FAsin)
  PINEDA_UNARY(facos, FAcos) PINEDA_UNARY(fatan, FAtan) PINEDA_BINARY(fatan2, FAtan2) PINEDA_UNARY(fsinh, FSinh)
  PINEDA_UNARY(fcosh, FCosh) PINEDA_UNARY(ftanh, FTanh) PINEDA_UNARY(fasinh, FAsinh) PINEDA_UNARY(facosh, FAcosh)
  PINEDA_UNARY(fatanh, FAtanh) PINEDA_UNARY(frsqrt, FRsqrt) PINEDA_UNARY(fexp2, FExp2)
  PINEDA_UNARY(flog2, FLog2) PINEDA_UNARY(flog2_coarse, FLog2Coarse) PINEDA_UNARY(fexp, FExp) PINEDA_UNARY(flog, FLog) PINEDA_BINARY(fpow, FPow)
// clang-format on
#undef PINEDA_UNARY
#undef PINEDA_BINARY
#undef PINEDA_COMPARE
                                                                                      Value fma(Value a, Value c, Value d) {
    return op(Op::kFMa, type(a), {a, c, d});
  }
  Value convert(Op op_, Type to, Value a) { return op(op_, to, {a}); }  // FToS ... Trunc
  Value bitcast(Type to, Value a);  // inserts FCanon when `a` is a float that arithmetic produced
  Value select(Value cond, Value a, Value c) { return op(Op::kSelect, type(a), {cond, a, c}); }
  Value unpack_mask(Value bits) { return op(Op::kUnpackMask, Type::kB1, {bits}); }
  Value ballot(Value cond) { return op(Op::kBallot, Type::kI32, {cond}); }
  Value quad_swizzle(Value a, uint32_t pattern) { return op(Op::kQuadSwizzle, type(a), {a}, pattern); }
  Value shuffle(Value a, Value index) { return op(Op::kShuffle, type(a), {a, index}); }
  Value reduce(ReduceOp how, Scan scan, Value a, uint32_t log2_cluster = 4) {
    return op(Op::kReduce, type(a), {a}, Inst::reduce_imm(how, scan, log2_cluster));
  }
  void barrier() { op(Op::kBarrier, Type::kVoid, {}); }
  Value ptr_add(Value base, Value offset) { return op(Op::kPtrAdd, Type::kPtr, {base, offset}); }

  // memory
  Value load(Type type, const Address& from, uint8_t flags = 0);
  Value load(Type type, Value base, uint32_t offset_bytes, uint8_t flags = 0) {
    return load(type, Address{.base = base, .offset = i32(offset_bytes)}, flags);
  }
  void store(const Address& to, Value value, uint8_t flags = 0);  // inserts FCanon as bitcast does
  Value atomic(AtomicOp op, const Address& at, Value value, Value comparand = {}, uint8_t flags = 0);
  Value local(Type element, uint32_t count) { return op(Op::kLocal, element, {}, count); }
  Value local_load(Value local, Value index) { return op(Op::kLocalLoad, type(local), {local, index}); }
  void local_store(Value local, Value index, Value value) { op(Op::kLocalStore, Type::kVoid, {local, index, value}); }
  Var variable(Type type) { return {local(type, 1), type}; }  // placed in the wave region, so it outlives every If
  Value get(Var v) { return local_load(v.local, i32(0)); }
  void set(Var v, Value x) { local_store(v.local, i32(0), x); }

  // Calls another kernel on a record of memory.
  void call(Value handle, Value record, uint32_t record_bytes) { op(Op::kCall, Type::kVoid, {handle, record}, record_bytes); }

  // While off, fadd, fsub and fmul are made kNoContract: what they compute does not depend on what surrounds them.
  void set_contraction(bool on) { float_flags_ = on ? 0 : kNoContract; }
  bool contraction() const { return float_flags_ == 0; }

  // control flow: the bodies append to the new region and return what it yields
  using Body = std::function<std::vector<Value>()>;
  std::vector<Value> if_else(Value cond, const std::vector<Type>& results, const Body& then_body, const Body& else_body);
  void if_(Value cond, const std::function<void()>& then_body);  // no results
  void if_else(Value cond, const std::function<void()>& then_body, const std::function<void()>& else_body);
  struct LoopStep {
    Value again;              // B1
    std::vector<Value> next;  // as many as init
  };
  std::vector<Value> loop(const std::vector<Value>& init, const std::function<LoopStep(std::span<const Value> carried)>& body);

 private:
  Value append(const Inst& inst);
  Value same(Op o, Value a) { return op(o, type(a), {a}); }
  Value same(Op o, Value a, Value c) { return op(o, type(a), {a, c}); }

  Kernel* kernel_;
  RegionId region_;
  uint32_t local_count_ = 0;  // Locals at the head of the wave region that this Builder knows of
  uint8_t float_flags_ = 0;
};

}  // namespace pineda::ir
