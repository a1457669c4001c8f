// Subgroup instructions. A subgroup is a wave of 16 lanes. The lanes that take part are the active ones; in a fragment shader
// without helper invocations and those that were discarded, as Vulkan allows ("Helper Invocations": group operations may treat
// them as inactive), so that counts and elections are of invocations whose stores count. Where none but such lanes is active they
// take part after all, so that a loop over the distinct values of a subgroup ends for them too. All active lanes get the result
// of an operation that has one for the whole subgroup. Quad operations always see the whole quad.
//
// Vectors go component by component. Results that SPIR-V leaves undefined (a source lane that is inactive or does not exist) are
// what ir.h's Shuffle gives.
#include <algorithm>

#include "base/abi.h"
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Builder;
using ir::ReduceOp;
using ir::Scan;
using ir::Type;
using ir::Value;

constexpr uint32_t kLaneBits = kLanes - 1;
constexpr uint32_t kLog2Lanes = 4;

void check_scope(Translator& t, const Instruction& inst) {
  if (t.m.constant_u32(inst, inst.word(3)) != spv::ScopeSubgroup) inst.fail("needs the scope Subgroup");
}

// The lanes that take part, as a mask (I32) that is the same for all active lanes.
Value taking_part(Translator& t) {
  const Value active = t.b.ballot(t.b.b1(true)), counting = t.lanes_with_effects();
  if (!counting) return active;
  const Value some = t.b.ballot(counting);
  return t.b.select(t.b.ieq(some, t.b.i32(0)), active, some);
}

Value first_lane(Translator& t) { return t.b.ctz(taking_part(t)); }

// Lanes that take part and where the condition holds.
Value ballot_of(Translator& t, Value condition) { return t.b.and_(t.b.ballot(condition), taking_part(t)); }
Value all_true(Translator& t, Value condition) { return t.b.ieq(ballot_of(t, t.b.not_(condition)), t.b.i32(0)); }

// Defines the instruction's result, component by component of the value in `word`.
void each(Translator& t, const Instruction& inst, uint32_t word, const std::function<Value(Value)>& fn) {
  Values out = t.values(inst, word);
  for (Value& v : out) v = fn(v);
  t.define(inst, std::move(out));
}

// ---- elect and vote -------------------------------------------------------------------------------------------------------

void elect(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  t.define(inst, Values{t.b.ieq(t.b.lane(), first_lane(t))});
}

template <uint32_t kWord>
void all(Translator& t, const Instruction& inst) {
  t.define(inst, Values{all_true(t, t.scalar(inst, kWord, Type::kB1))});
}

template <uint32_t kWord>
void any(Translator& t, const Instruction& inst) {
  t.define(inst, Values{t.b.ine(ballot_of(t, t.scalar(inst, kWord, Type::kB1)), t.b.i32(0))});
}

Value equal(Builder& b, Value x, Value y) {
  if (b.type(x) == Type::kB1) return b.not_(b.xor_(x, y));
  return ir::is_float(b.type(x)) ? b.feq(x, y) : b.ieq(x, y);
}

template <uint32_t kWord>
void all_equal(Translator& t, const Instruction& inst) {
  const Values in = t.values(inst, kWord);
  const Value first = first_lane(t);
  Value same;
  for (Value v : in) {
    const Value this_one = equal(t.b, v, t.b.shuffle(v, first));
    same = same ? t.b.and_(same, this_one) : this_one;
  }
  t.define(inst, Values{all_true(t, same)});
}

// ---- ballots: the mask is the first of four words -------------------------------------------------------------------------

template <uint32_t kWord>
void ballot(Translator& t, const Instruction& inst) {
  const Value zero = t.b.i32(0);
  t.define(inst, Values{ballot_of(t, t.scalar(inst, kWord, Type::kB1)), zero, zero, zero});
}

Value ballot_word(Translator& t, const Instruction& inst, uint32_t word) {
  const Values in = t.integers(inst, word);
  if (in.size() != 4 || t.b.type(in[0]) != Type::kI32) inst.fail("a ballot is a vector of four 32-bit integers");
  return t.b.and_(in[0], t.b.i32((1u << kLanes) - 1));
}

void inverse_ballot(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  t.define(inst, Values{t.b.unpack_mask(ballot_word(t, inst, 4))});
}

void ballot_bit(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  const Value index = t.scalar(inst, 5, Type::kI32);
  const Value bit = t.b.and_(t.b.lshr(ballot_word(t, inst, 4), index), t.b.i32(1));
  t.define(inst, Values{t.b.ine(bit, t.b.i32(0))});
}

void ballot_count(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  Builder& b = t.b;
  Value mask = ballot_word(t, inst, 5);
  const uint32_t scan = inst.word(4);
  if (scan == spv::GroupOperationInclusiveScan)
    mask = b.and_(mask, b.isub(b.shl(b.i32(2), b.lane()), b.i32(1)));
  else if (scan == spv::GroupOperationExclusiveScan)
    mask = b.and_(mask, b.isub(b.shl(b.i32(1), b.lane()), b.i32(1)));
  else if (scan != spv::GroupOperationReduce)
    inst.fail("has an unknown group operation");
  t.define(inst, Values{b.popcount(mask)});
}

void ballot_lowest(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  t.define(inst, Values{t.b.ctz(ballot_word(t, inst, 4))});
}

void ballot_highest(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  t.define(inst, Values{t.b.isub(t.b.i32(31), t.b.clz(ballot_word(t, inst, 4)))});
}

// ---- shuffles -------------------------------------------------------------------------------------------------------------

template <uint32_t kWord>
void read_lane(Translator& t, const Instruction& inst) {
  const Value index = t.scalar(inst, kWord + 1, Type::kI32);
  each(t, inst, kWord, [&](Value v) { return t.b.shuffle(v, index); });
}

template <uint32_t kWord>
void read_first(Translator& t, const Instruction& inst) {
  const Value first = first_lane(t);
  each(t, inst, kWord, [&](Value v) { return t.b.shuffle(v, first); });
}

enum class Move : uint8_t { kXor, kUp, kDown };

template <Move kMove>
void relative(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  const Value by = t.scalar(inst, 5, Type::kI32), lane = t.b.lane();
  const Value from = kMove == Move::kXor ? t.b.xor_(lane, by) : kMove == Move::kUp ? t.b.isub(lane, by) : t.b.iadd(lane, by);
  each(t, inst, 4, [&](Value v) { return t.b.shuffle(v, from); });
}

uint32_t log2_cluster(Translator& t, const Instruction& inst, uint32_t word) {
  const uint32_t size = t.m.constant_u32(inst, inst.word(word));
  if (size == 0 || (size & (size - 1)) != 0) inst.fail("ClusterSize is not a power of two");
  return std::min<uint32_t>(kLog2Lanes, static_cast<uint32_t>(__builtin_ctz(size)));
}

void rotate(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  const uint32_t in_cluster = inst.size() > 6 ? (1u << log2_cluster(t, inst, 6)) - 1 : kLaneBits;
  Builder& b = t.b;
  const Value moved = b.and_(b.iadd(b.lane(), t.scalar(inst, 5, Type::kI32)), b.i32(in_cluster));
  const Value from = b.or_(b.and_(b.lane(), b.i32(kLaneBits & ~in_cluster)), moved);
  each(t, inst, 4, [&](Value v) { return b.shuffle(v, from); });
}

// Helper invocations and killed ones stay with their quad (flow.h), so these read them.
void quad_broadcast(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  Builder& b = t.b;
  const Value in_quad = b.and_(t.scalar(inst, 5, Type::kI32), b.i32(3));
  const Value from = b.or_(b.and_(b.lane(), b.i32(kLaneBits & ~3u)), in_quad);
  Values out = t.values(inst, 4);
  for (Value& v : out) v = b.shuffle(v, from);
  t.define(inst, std::move(out));
}

void quad_swap(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  const uint32_t direction = t.m.constant_u32(inst, inst.word(5));  // 0 horizontal, 1 vertical, 2 diagonal
  if (direction > 2) inst.fail("Direction is out of range");
  const Value from = t.b.xor_(t.b.lane(), t.b.i32(direction + 1));
  Values out = t.values(inst, 4);
  for (Value& v : out) v = t.b.shuffle(v, from);
  t.define(inst, std::move(out));
}

// ---- arithmetic -----------------------------------------------------------------------------------------------------------

// Only lanes that take part are combined; the others get what the whole subgroup gets, if the operation has one result.
Value reduce(Translator& t, ReduceOp op, Scan scan, Value v, uint32_t cluster) {
  const Value counting = t.lanes_with_effects();
  if (!counting) return t.b.reduce(op, scan, v, cluster);
  const Value mask = taking_part(t);
  const Value combined = t.b.if_else(
      t.b.unpack_mask(mask), {t.b.type(v)}, [&] { return Values{t.b.reduce(op, scan, v, cluster)}; },
      [&] { return Values{t.b.zero(t.b.type(v))}; })[0];
  return scan == Scan::kReduce && cluster == kLog2Lanes ? t.b.shuffle(combined, t.b.ctz(mask)) : combined;
}

template <ReduceOp kOp>
void combine(Translator& t, const Instruction& inst) {
  check_scope(t, inst);
  Scan scan = Scan::kReduce;
  uint32_t cluster = kLog2Lanes;
  switch (inst.word(4)) {
    case spv::GroupOperationReduce:
      break;
    case spv::GroupOperationInclusiveScan:
      scan = Scan::kInclusive;
      break;
    case spv::GroupOperationExclusiveScan:
      scan = Scan::kExclusive;
      break;
    case spv::GroupOperationClusteredReduce:
      if (inst.size() < 7) inst.fail("needs a ClusterSize");
      cluster = log2_cluster(t, inst, 6);
      break;
    default:
      inst.fail("has an unknown group operation");
  }
  const Values in = kOp >= ReduceOp::kFAdd ? t.floats(inst, 5) : t.values(inst, 5);
  for (Value v : in) {
    const bool logic = kOp == ReduceOp::kAnd || kOp == ReduceOp::kOr || kOp == ReduceOp::kXor;
    if (kOp < ReduceOp::kFAdd && !ir::is_int(t.b.type(v)) && !(logic && t.b.type(v) == Type::kB1)) {
      inst.fail("has an operand of the wrong type");
    }
  }
  each(t, inst, 5, [&](Value v) {
    const Value out = reduce(t, kOp, scan, v, cluster);
    // SPIR-V's identity is +0, the IR's -0: they differ where no lane came before.
    const bool add_zero = kOp == ReduceOp::kFAdd && scan == Scan::kExclusive;
    return add_zero ? t.b.fadd(out, t.b.fconst(t.b.type(out), 0.0)) : out;
  });
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(GroupNonUniformElect, 4, elect),
    PINEDA_SPIRV_ROW(GroupNonUniformAll, 5, all<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformAny, 5, any<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformAllEqual, 5, all_equal<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformBroadcast, 6, read_lane<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformBroadcastFirst, 5, read_first<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformBallot, 5, ballot<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformInverseBallot, 5, inverse_ballot),
    PINEDA_SPIRV_ROW(GroupNonUniformBallotBitExtract, 6, ballot_bit),
    PINEDA_SPIRV_ROW(GroupNonUniformBallotBitCount, 6, ballot_count),
    PINEDA_SPIRV_ROW(GroupNonUniformBallotFindLSB, 5, ballot_lowest),
    PINEDA_SPIRV_ROW(GroupNonUniformBallotFindMSB, 5, ballot_highest),
    PINEDA_SPIRV_ROW(GroupNonUniformShuffle, 6, read_lane<4>),
    PINEDA_SPIRV_ROW(GroupNonUniformShuffleXor, 6, relative<Move::kXor>),
    PINEDA_SPIRV_ROW(GroupNonUniformShuffleUp, 6, relative<Move::kUp>),
    PINEDA_SPIRV_ROW(GroupNonUniformShuffleDown, 6, relative<Move::kDown>),
    PINEDA_SPIRV_ROW(GroupNonUniformRotateKHR, 6, rotate),
    PINEDA_SPIRV_ROW(GroupNonUniformIAdd, 6, combine<ReduceOp::kIAdd>),
    PINEDA_SPIRV_ROW(GroupNonUniformFAdd, 6, combine<ReduceOp::kFAdd>),
    PINEDA_SPIRV_ROW(GroupNonUniformIMul, 6, combine<ReduceOp::kIMul>),
    PINEDA_SPIRV_ROW(GroupNonUniformFMul, 6, combine<ReduceOp::kFMul>),
    PINEDA_SPIRV_ROW(GroupNonUniformSMin, 6, combine<ReduceOp::kSMin>),
    PINEDA_SPIRV_ROW(GroupNonUniformUMin, 6, combine<ReduceOp::kUMin>),
    PINEDA_SPIRV_ROW(GroupNonUniformFMin, 6, combine<ReduceOp::kFMin>),
    PINEDA_SPIRV_ROW(GroupNonUniformSMax, 6, combine<ReduceOp::kSMax>),
    PINEDA_SPIRV_ROW(GroupNonUniformUMax, 6, combine<ReduceOp::kUMax>),
    PINEDA_SPIRV_ROW(GroupNonUniformFMax, 6, combine<ReduceOp::kFMax>),
    PINEDA_SPIRV_ROW(GroupNonUniformBitwiseAnd, 6, combine<ReduceOp::kAnd>),
    PINEDA_SPIRV_ROW(GroupNonUniformBitwiseOr, 6, combine<ReduceOp::kOr>),
    PINEDA_SPIRV_ROW(GroupNonUniformBitwiseXor, 6, combine<ReduceOp::kXor>),
    PINEDA_SPIRV_ROW(GroupNonUniformLogicalAnd, 6, combine<ReduceOp::kAnd>),
    PINEDA_SPIRV_ROW(GroupNonUniformLogicalOr, 6, combine<ReduceOp::kOr>),
    PINEDA_SPIRV_ROW(GroupNonUniformLogicalXor, 6, combine<ReduceOp::kXor>),
    PINEDA_SPIRV_ROW(GroupNonUniformQuadBroadcast, 6, quad_broadcast),
    PINEDA_SPIRV_ROW(GroupNonUniformQuadSwap, 6, quad_swap),
    // SPV_KHR_shader_ballot, SPV_KHR_subgroup_vote
    PINEDA_SPIRV_ROW(SubgroupBallotKHR, 4, ballot<3>),
    PINEDA_SPIRV_ROW(SubgroupFirstInvocationKHR, 4, read_first<3>),
    PINEDA_SPIRV_ROW(SubgroupReadInvocationKHR, 5, read_lane<3>),
    PINEDA_SPIRV_ROW(SubgroupAllKHR, 4, all<3>),
    PINEDA_SPIRV_ROW(SubgroupAnyKHR, 4, any<3>),
    PINEDA_SPIRV_ROW(SubgroupAllEqualKHR, 4, all_equal<3>),
};

}  // namespace

std::span<const OpRow> subgroup_rows() { return kRows; }

}  // namespace pineda::spirv
