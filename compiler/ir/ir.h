// The intermediate representation: everything that computes a pixel or a buffer is a Kernel, built here, optimised by passes/,
// run by jit/ (16 lanes, machine code) or eval/ (the oracle).
//
// Shape. Typed SSA, scalarised: a value is one scalar per lane. Control flow is a tree of regions; there are no branches:
//
//     If cond { region[0] ... Yield a, b } else { region[1] ... Yield c, d }      Result 0, Result 1 follow it
//     Loop (init...) { LoopArg 0.. ; ... ; Yield again, next... }                 do-while: the body runs at least once per
//                                                                                  active lane; a lane leaves when `again` is
//                                                                                  false; Result k is the lane's k-th `next`
//                                                                                  of its last iteration
// Break, continue, return and kill become B1 values that guard the rest of a region: every kernel has exactly this form, so
// each pass, the verifier, the JIT and the evaluator handle two constructs only.
//
// Lanes. A region runs under a mask of active lanes: the wave record's first word at the top, narrowed by If (lanes where cond
// holds) and Loop (lanes still in it). A Store, Atomic or LocalStore acts for active lanes only. Values of inactive lanes are
// unspecified and must not reach an effect; QuadSwizzle is the exception that reads them, and is legal only where all lanes
// run.
//
// Subgroups. A wave is a subgroup. Ballot, Shuffle and Reduce look at the active lanes of the wave at this place, so no pass
// moves them. Reduce first gives inactive lanes the operation's identity (-0.0 for FAdd, so that x op identity is x for every x
// but a NaN; infinities for FMin and FMax), and then, in clusters of c lanes, c a power of two:
//     reduce      for s = c/2, c/4 ... 1: x[l] = x[l] op x[l + s] for the lanes l with l mod 2s < s; all get the first lane's x
//     inclusive   for s = 1, 2, 4 ... c/2: x[l] = x[l - s] op x[l] for the lanes l with l mod c >= s, all at once
//     exclusive   x[l] = inclusive x[l - 1]; the first lane gets the identity (+0.0 for FAdd, as SPIR-V has it)
// This order is part of the bit contract.
//
// Barriers. The waves of one primitive (compute: a workgroup) run one after the other, up to the next Barrier, in ascending
// order; then all go on behind it. An If or Loop that holds a Barrier is run by the whole workgroup: its regions' parts between
// Barriers run for each wave, under the wave's own mask, and a Loop ends when the last lane of the last wave leaves. So a Barrier
// that not all invocations reach (undefined in SPIR-V) is as well defined as any other and cannot hang.
//
// Rates. passes/rates gives each instruction the slowest rate at which its value is constant: Draw, Prim, Wave or Lane
// (base/abi.h shows the loops). passes/hoist moves pure Draw- and Prim-rate instructions into Kernel::draw and Kernel::prim.
//
// Memory. The address of Load/Store/Atomic is base + zext(offset) + lane * lane_stride(). With a `limit` operand (I32, bytes,
// unsigned) the access is checked: it takes place only when offset + lane * lane_stride + size <= limit, computed without
// wrapping; otherwise a load or atomic gives zero and a store does nothing. Accesses need no alignment, atomics their natural
// one. Lanes act in ascending order: where stores or atomics of one instruction meet, the highest active lane comes last. B1 is
// never in memory. lane_stride == size with a uniform offset is one contiguous vector access.
//
// Numbers. IEEE binary32/64, round to nearest even, denormals kept. An operation that creates a NaN gives a NaN of unspecified
// sign and payload; FCanon makes it one pattern, and is placed (by Builder) wherever bits become visible: Bitcast from a float,
// Store of a float. FMA is formed only by passes/fuse_fma. In the f64 evaluator F32 values are doubles and transcendentals are
// exact to double precision; memory keeps its formats.
//
// Thread safety: none; a Kernel belongs to the thread that builds it and is immutable afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pineda::ir {

enum class Type : uint8_t { kVoid, kB1, kI8, kI16, kI32, kI64, kF16, kF32, kF64, kPtr };

enum class Rate : uint8_t { kDraw, kPrim, kWave, kLane };

enum class Op : uint8_t {
  kInvalid,
#define PINEDA_IR_OP(name, text, operands, rule, effect) k##name,
#include "compiler/ir/ops.inc"
#undef PINEDA_IR_OP
  kCount
};

enum class Effect : uint8_t { kPure, kRead, kWrite, kControl };

enum class TypeRule : uint8_t {
  kAny,
  kPtr,
  kI32,
  kSame,
  kCompare,
  kFToI,
  kIToF,
  kFToF,
  kIToI,
  kBitcast,
  kSelect,
  kMaskToB1,
  kB1ToMask,
  kShuffle,
  kReduce,
  kPtrAdd,
  kVoid,
  kAtomic,
  kLocalLd
};

struct OpInfo {
  const char* name;  // in printed IR
  uint8_t operands;
  TypeRule rule;
  Effect effect;
};
const OpInfo& op_info(Op op);

// a op b equals b op a for all values (the sign and payload of a NaN apart, which are unspecified).
bool is_commutative(Op op);

// kFAdd adds the binary32 or binary64 numbers that the bits of an I32 or I64 are; a NaN is stored in FCanon's pattern.
enum class AtomicOp : uint8_t { kAdd, kAnd, kOr, kXor, kSMin, kSMax, kUMin, kUMax, kExchange, kFAdd, kCompareExchange };

// Reduce: what is combined, and how far.
enum class ReduceOp : uint8_t { kIAdd, kIMul, kSMin, kSMax, kUMin, kUMax, kAnd, kOr, kXor, kFAdd, kFMul, kFMin, kFMax, kCount };
enum class Scan : uint8_t { kReduce, kInclusive, kExclusive };
Op combining_op(ReduceOp op);

// Index of an instruction in Kernel::insts; also the name of its value. 0 is "none".
struct Value {
  uint32_t id = 0;
  explicit operator bool() const { return id != 0; }
  bool operator==(const Value&) const = default;
};

using RegionId = uint32_t;  // index in Kernel::regions; 0 is "none"

// Inst::flags
inline constexpr uint8_t kInvariant = 1;   // Load: nothing writes this memory while the kernel runs, so it may be hoisted
inline constexpr uint8_t kSpeculate = 2;   // Load: the address is valid for every lane, active or not
inline constexpr uint8_t kAllLanes = 4;    // Store: writes all 16 lanes whatever the mask (tile buffers)
inline constexpr uint8_t kNoContract = 8;  // FAdd, FSub, FMul: never fused (SPIR-V NoContraction)
inline constexpr uint8_t kVolatile = 16;   // Load: never merged with another or moved (atomic loads: another thread may write)
inline constexpr uint8_t kLikely = 32;     // If: mostly its first region runs
inline constexpr uint8_t kPrivate = 64;    // Atomic: no other thread touches this memory while the kernel runs

inline constexpr uint32_t kMaxOperands = 5;
inline constexpr uint64_t kMaxRecordBytes = 4096;  // of a Call

struct Inst {
  Op op = Op::kInvalid;
  Type type = Type::kVoid;
  Rate rate = Rate::kLane;
  uint8_t flags = 0;
  uint32_t list = 0;  // Loop, Yield: index in Kernel::lists
  std::array<Value, kMaxOperands> operand{};
  uint64_t imm = 0;
  std::array<RegionId, 2> region{};

  // Load, Store, Atomic: bytes between consecutive lanes, added to the address
  uint32_t lane_stride() const { return static_cast<uint32_t>(imm >> 32); }
  AtomicOp atomic_op() const { return static_cast<AtomicOp>(imm & 0xff); }
  // Reduce
  ReduceOp reduce_op() const { return static_cast<ReduceOp>(imm & 0xff); }
  Scan scan() const { return static_cast<Scan>(imm >> 8 & 0xff); }
  uint32_t cluster_lanes() const { return 1u << (imm >> 16 & 0xff); }
  static uint64_t reduce_imm(ReduceOp op, Scan scan, uint32_t log2_cluster) {
    return static_cast<uint64_t>(op) | static_cast<uint64_t>(scan) << 8 | static_cast<uint64_t>(log2_cluster) << 16;
  }
};

struct Region {
  std::vector<Value> insts;  // in order; the last one of an If/Loop region is its Yield
};

enum class KernelKind : uint8_t { kVertex, kFragment, kCompute };

struct Kernel {
  std::string name;
  KernelKind kind = KernelKind::kCompute;
  uint32_t wave_stride_bytes = 0;  // size of one wave record; its first word is the mask of active lanes
  bool full_waves = false;         // every wave's mask is 0xFFFF
  std::vector<Inst> insts{1};      // [0] is unused
  std::vector<Region> regions{1};
  std::vector<std::vector<Value>> lists{1};
  RegionId draw = 0, prim = 0, wave = 0;

  Inst& at(Value v) { return insts[v.id]; }
  const Inst& at(Value v) const { return insts[v.id]; }
};

// What passes/lower_math replaces.
constexpr bool is_transcendental(Op op) { return op >= Op::kFSin && op <= Op::kFPow; }

constexpr bool is_float(Type t) { return t == Type::kF16 || t == Type::kF32 || t == Type::kF64; }
constexpr bool is_int(Type t) { return t >= Type::kI8 && t <= Type::kI64; }
constexpr uint32_t size_bytes(Type t) {  // in memory; B1 is 1
  switch (t) {
    case Type::kVoid:
      return 0;
    case Type::kB1:
    case Type::kI8:
      return 1;
    case Type::kI16:
    case Type::kF16:
      return 2;
    case Type::kI32:
    case Type::kF32:
      return 4;
    case Type::kI64:
    case Type::kF64:
    case Type::kPtr:
      return 8;
  }
  return 0;
}
const char* type_name(Type t);  // "f32"

// Text form: print() gives what parse() reads back, instruction for instruction.
std::string print(const Kernel& kernel);

struct ParseResult {
  Kernel kernel;
  std::string error;  // "line 12: ..." ; empty on success
};
ParseResult parse(const std::string& text);

// Empty when well formed; otherwise the first fault, with the instruction's text. Checks operand counts, types, regions,
// dominance, Yield arity and flags.
std::string verify(const Kernel& kernel);

}  // namespace pineda::ir
