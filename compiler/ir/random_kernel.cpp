#include "compiler/ir/random_kernel.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <span>

#include "compiler/ir/builder.h"
#include "compiler/ir/random.h"

namespace pineda::ir {
namespace {

constexpr uint32_t kWaves = 5;
constexpr uint32_t kInputBytes = 1024;
constexpr uint32_t kWindowBytes = 4096;  // of the output, for each wave: final values, then scratch
constexpr uint32_t kFinalValues = 24;
constexpr uint32_t kSlotBytes = 8 * kLanes;
constexpr uint32_t kScratch = kFinalValues * kSlotBytes;
constexpr uint32_t kScratchBytes = kWindowBytes - kScratch;
constexpr uint32_t kMaxDepth = 3;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kSpecialFloats[] = {0.0,
                                     -0.0,
                                     1.0,
                                     -1.0,
                                     0.5,
                                     1.5,
                                     2.5,
                                     -7.25,
                                     1.0 / 3,
                                     8388607.5,
                                     16777217.0,
                                     2147483648.0,
                                     4294967296.0,
                                     1e10,
                                     1e-40,
                                     1e-45,
                                     1.17549435e-38,
                                     3.4028235e38,
                                     65504.0,
                                     65520.0,
                                     6e-8,
                                     kInf,
                                     -kInf,
                                     std::numeric_limits<double>::quiet_NaN()};
constexpr uint64_t kSpecialInts[] = {0,    1,    2,          3,          7,          31,        32,    63,
                                     0x7f, 0x80, 0x7fffffff, 0x80000000, 0xffffffff, ~0ull - 1, ~0ull, 1ull << 63};
constexpr uint32_t kSpecialWords[] = {0x7f800001, 0xffc12345, 0x00000001, 0x80000000, 0x7f7fffff, 0xff800000, 0x7fffffff};

constexpr Type kWideTypes[] = {Type::kI32, Type::kF32, Type::kB1, Type::kI32, Type::kF32, Type::kF32,
                               Type::kI64, Type::kI16, Type::kI8, Type::kF64, Type::kF16};
constexpr Type kNarrowTypes[] = {Type::kI32, Type::kF32, Type::kB1, Type::kF32};
constexpr Type kInts[] = {Type::kI8, Type::kI16, Type::kI32, Type::kI64};
constexpr Type kFloats[] = {Type::kF16, Type::kF32, Type::kF64};

// What the kernel reads. The layouts are the kernel's own: only PrimRecord and the wave's mask are fixed.
struct DrawBlock {
  const uint8_t* input;
  uint32_t input_bytes;
  uint32_t words[9];
};
struct PrimBlock {
  uint32_t words[4];
};
struct WaveBlock {
  uint32_t mask;
  uint32_t index;
  uint32_t words[6];
};

class Generator {
 public:
  Generator(Kernel& kernel, Random& random, const RandomKernelOptions& options, bool all_lanes)
      : b_(kernel), random_(random), options_(options), all_lanes_(all_lanes) {}

  void run() {
    sources();
    for (uint32_t i = 0; i < options_.statements; ++i) statement();
    for (uint32_t slot = 0; slot < kFinalValues; ++slot) {
      const Value v = any(random_type());
      const bool everywhere = all_lanes_ && random_.one_in(4);
      store_final(slot, v, everywhere ? kAllLanes : 0);
    }
  }

 private:
  std::vector<Value>& pool(Type t) { return pools_[static_cast<size_t>(t)]; }
  void keep(Value v) { pool(b_.type(v)).push_back(v); }

  Type random_type() { return options_.other_widths ? random_.pick(kWideTypes) : random_.pick(kNarrowTypes); }
  Type random_int() { return options_.other_widths && random_.one_in(3) ? random_.pick(kInts) : Type::kI32; }
  Type random_float() { return options_.other_widths && random_.one_in(4) ? random_.pick(kFloats) : Type::kF32; }

  Value random_constant(Type t) {
    if (is_float(t)) return b_.fconst(t, random_.one_in(2) ? random_.pick(kSpecialFloats) : random_.below(2000) / 16.0 - 60);
    return b_.constant(t, random_.one_in(2) ? random_.pick(kSpecialInts) : random_.below(100));
  }

  // A value that is visible here, of the last ones more often.
  Value any(Type t) {
    auto& values = pool(t);
    if (values.empty() || random_.one_in(8)) return random_constant(t);
    const auto count = static_cast<uint32_t>(values.size());
    return values[count - 1 - std::min(random_.below(count), random_.below(count))];
  }

  // ---- values of each rate ------------------------------------------------------------------------------------------------

  void sources() {
    constexpr uint8_t kUniform = kInvariant | kSpeculate;
    const Value draw = b_.draw_ptr(), prim = b_.prim_ptr(), wave = b_.wave_ptr();
    input_ = b_.load(Type::kPtr, draw, offsetof(DrawBlock, input), kUniform);
    input_bytes_ = b_.load(Type::kI32, draw, offsetof(DrawBlock, input_bytes), kUniform);
    for (uint32_t i = 0; i < 3; ++i) {
      const auto word = static_cast<uint32_t>(4 * i);
      keep(b_.load(i == 1 ? Type::kF32 : Type::kI32, draw, offsetof(DrawBlock, words) + word, kUniform));
      keep(b_.load(i == 1 ? Type::kF32 : Type::kI32, prim, offsetof(PrimBlock, words) + word, kUniform));
      keep(b_.load(i == 1 ? Type::kF32 : Type::kI32, wave, offsetof(WaveBlock, words) + word, kUniform));
    }
    keep(b_.lane());
    keep(b_.unpack_mask(b_.load(Type::kI32, wave, offsetof(WaveBlock, words) + 12, kUniform)));
    const Value index = b_.load(Type::kI32, wave, offsetof(WaveBlock, index), kUniform);
    const Value output = b_.load(Type::kPtr, b_.thread_ptr(), offsetof(ThreadContext, color), kUniform);
    window_ = b_.ptr_add(output, b_.imul(index, b_.i32(kWindowBytes)));
    scratch_ = b_.ptr_add(options_.barriers ? output : window_, b_.i64(kScratch));
    for (uint32_t i = 0; i < 3; ++i) {
      variables_.push_back(b_.variable(random_type()));
      arrays_.push_back(b_.local(i == 0 ? Type::kI32 : random_type(), 1 + random_.below(5)));
    }
    for (Type t : {Type::kF32, Type::kI32, Type::kF32}) contiguous_load(t);
  }

  void contiguous_load(Type t) {
    const uint32_t size = size_bytes(t);
    const Value offset = b_.i32(random_.below(kInputBytes - kLanes * size + 1));
    keep(b_.load(t, {.base = input_, .offset = offset, .lane_stride = size}, random_.one_in(2) ? kInvariant : 0));
  }

  // ---- statements ---------------------------------------------------------------------------------------------------------

  void statement() {
    if (options_.barriers && random_.one_in(8)) return b_.barrier();
    switch (random_.below(28)) {
      case 0:
      case 1:
      case 2:
      case 3:
        return keep(integer(random_int()));
      case 4:
      case 5:
      case 6:
      case 7:
      case 8:
        return keep(floating(random_float()));
      case 9:
      case 10:
        return keep(comparison());
      case 11:
        return keep(logic());
      case 12:
      case 13:
        return keep(select());
      case 14:
      case 15:
        return keep(conversion());
      case 16:
        return load();
      case 17:
        return store();
      case 18:
        return variable();
      case 19:
        return array();
      case 20:
        return depth_ < kMaxDepth ? if_else() : keep(integer(Type::kI32));
      case 21:
        return depth_ < kMaxDepth ? loop() : keep(floating(Type::kF32));
      case 22:
        return options_.atomics ? atomic() : keep(logic());
      case 23:
        return keep(b_.ballot(any(Type::kB1)));
      case 25:
        return keep(b_.shuffle(any(random_type()), random_.one_in(3)   ? random_constant(Type::kI32)
                                                   : random_.one_in(3) ? b_.xor_(b_.lane(), b_.i32(random_.below(16)))
                                                                       : any(Type::kI32)));
      case 26:
        return keep(reduction());
      case 24:
        return all_lanes_ && depth_ == 0 ? quad_swizzle() : keep(comparison());
      default:
        return options_.transcendentals ? keep(transcendental()) : keep(floating(Type::kF32));
    }
  }

  Value integer(Type t) {
    constexpr Op kUnary[] = {Op::kNot, Op::kClz, Op::kCtz, Op::kPopCount, Op::kBitReverse};
    constexpr Op kBinary[] = {Op::kIAdd, Op::kISub, Op::kIMul, Op::kUMulHi, Op::kSMulHi, Op::kUDiv, Op::kSDiv,
                              Op::kURem, Op::kSRem, Op::kShl,  Op::kLShr,   Op::kAShr,   Op::kAnd,  Op::kOr,
                              Op::kXor,  Op::kSMin, Op::kSMax, Op::kUMin,   Op::kUMax,   Op::kIAdd, Op::kIMul};
    if (random_.one_in(5)) return b_.op(random_.pick(kUnary), t, {any(t)});
    if (t == Type::kI32 && random_.one_in(20)) return b_.madd16(any(t), any(t));
    return b_.op(random_.pick(kBinary), t, {any(t), any(t)});
  }

  Value floating(Type t) {
    constexpr Op kUnary[] = {Op::kFSqrt, Op::kFNeg,   Op::kFAbs,       Op::kFFloor,
                             Op::kFCeil, Op::kFTrunc, Op::kFRoundEven, Op::kFCanon};
    constexpr Op kBinary[] = {Op::kFAdd, Op::kFSub, Op::kFMul, Op::kFDiv, Op::kFMin, Op::kFMax, Op::kFAdd, Op::kFMul};
    if (random_.one_in(4)) return b_.op(random_.pick(kUnary), t, {any(t)});
    if (random_.one_in(6)) return b_.fma(any(t), any(t), any(t));
    const Op op = random_.pick(kBinary);
    const bool contractible = op == Op::kFAdd || op == Op::kFSub || op == Op::kFMul;
    return b_.op(op, t, {any(t), any(t)}, 0, contractible && random_.one_in(4) ? kNoContract : 0);
  }

  Value comparison() {
    constexpr Op kInt[] = {Op::kIEq, Op::kINe, Op::kULt, Op::kULe, Op::kSLt, Op::kSLe};
    constexpr Op kFloat[] = {Op::kFEq, Op::kFNe, Op::kFLt, Op::kFLe};
    const bool floats = random_.one_in(2);
    const Type t = floats ? random_float() : random_int();
    return b_.op(floats ? random_.pick(kFloat) : random_.pick(kInt), Type::kB1, {any(t), any(t)});
  }

  Value logic() {
    constexpr Op kBinary[] = {Op::kAnd, Op::kOr, Op::kXor};
    if (random_.one_in(3)) return b_.not_(any(Type::kB1));
    return b_.op(random_.pick(kBinary), Type::kB1, {any(Type::kB1), any(Type::kB1)});
  }

  Value select() {
    const Type t = random_type();
    return b_.select(any(Type::kB1), any(t), any(t));
  }

  Value transcendental() {
    constexpr uint32_t kCount = static_cast<uint32_t>(Op::kFPow) - static_cast<uint32_t>(Op::kFSin) + 1;
    const auto op = static_cast<Op>(static_cast<uint32_t>(Op::kFSin) + random_.below(kCount));
    const Type type = options_.other_widths && random_.one_in(4) ? Type::kF16 : Type::kF32;
    const Value x = any(type);
    return op_info(op).operands == 2 ? b_.op(op, type, {x, any(type)}) : b_.op(op, type, {x});
  }

  Value conversion() {
    const Type i = random_int(), f = random_float();
    switch (random_.below(8)) {
      case 0:
        return b_.convert(Op::kFToS, i, any(f));
      case 1:
        return b_.convert(Op::kFToU, i, any(f));
      case 2:
        return b_.convert(Op::kSToF, f, any(i));
      case 3:
        return b_.convert(Op::kUToF, f, any(i));
      case 4:
        return b_.convert(Op::kFConvert, random_float(), any(f));
      case 5:
        return b_.convert(random_.one_in(2) ? Op::kZExt : Op::kSExt, i, any(Type::kB1));
      case 6:
        return bitcast();
      default:
        return resize(any(i));
    }
  }

  Value resize(Value v) {
    const Type from = b_.type(v), to = random_int();
    if (size_bytes(to) < size_bytes(from)) return b_.convert(Op::kTrunc, to, v);
    return b_.convert(random_.one_in(2) ? Op::kZExt : Op::kSExt, to, v);
  }

  Value bitcast() {
    constexpr std::pair<Type, Type> kPairs[] = {
        {Type::kI32, Type::kF32}, {Type::kI32, Type::kF32}, {Type::kI16, Type::kF16}, {Type::kI64, Type::kF64}};
    auto [a, c] = options_.other_widths ? random_.pick(kPairs) : kPairs[0];
    if (random_.one_in(2)) std::swap(a, c);
    return b_.bitcast(c, any(a));
  }

  Value reduction() {
    const bool floats = random_.one_in(2);
    const Type t = floats ? random_float() : random_.one_in(4) ? Type::kB1 : random_int();
    constexpr ReduceOp kFloat[] = {ReduceOp::kFAdd, ReduceOp::kFMul, ReduceOp::kFMin, ReduceOp::kFMax};
    constexpr ReduceOp kLogic[] = {ReduceOp::kAnd, ReduceOp::kOr, ReduceOp::kXor};
    constexpr ReduceOp kInt[] = {ReduceOp::kIAdd, ReduceOp::kIMul, ReduceOp::kSMin, ReduceOp::kSMax, ReduceOp::kUMin,
                                 ReduceOp::kUMax, ReduceOp::kAnd,  ReduceOp::kOr,   ReduceOp::kXor};
    const ReduceOp op = floats ? random_.pick(kFloat) : t == Type::kB1 ? random_.pick(kLogic) : random_.pick(kInt);
    return b_.reduce(op, static_cast<Scan>(random_.below(3)), any(t), random_.one_in(2) ? 4 : random_.below(5));
  }

  void quad_swizzle() {
    const Type t = random_type();
    keep(b_.quad_swizzle(any(t), random_.below(256)));
  }

  // ---- memory -------------------------------------------------------------------------------------------------------------

  Type memory_type() {
    const Type t = random_type();
    return t == Type::kB1 ? Type::kI32 : t;
  }

  // An offset that is in range more often than not; often one of a few constants, so that loads and stores meet.
  Value random_offset(uint32_t range) {
    if (random_.one_in(3)) return b_.i32(4 * random_.below(4));
    if (random_.one_in(6)) return any(Type::kI32);
    return b_.iadd(b_.urem(any(Type::kI32), b_.i32(range)), b_.i32(random_.below(16)));
  }

  // As the translator addresses an array of scalars behind a header: the product of index and size must not wrap, nor its sum
  // with what stands in front. The index grows from lane to lane and is anywhere: at the array's ends, at those of 32 bits, at
  // borders of the product.
  Address indexed(Value base, Value limit, uint32_t range, uint32_t size) {
    const uint32_t places[] = {0, range / size, ~0u / size, 1u << 31};
    Value index = random_.one_in(2) ? b_.i32(places[random_.below(4)] + random_.below(40) - 20)
                                    : b_.iadd(b_.urem(any(Type::kI32), b_.i32(range / size)), b_.i32(random_.below(4)));
    if (!random_.one_in(4)) index = b_.iadd(index, b_.lane());
    const uint32_t row = 4 * random_.below(3), most = ~0u / size;
    const Value scaled = b_.imul(index, b_.i32(size));
    Value holds = b_.ule(index, b_.i32(most)), offset = scaled;
    if (row != 0) {
      holds = b_.and_(holds, b_.ule(scaled, b_.i32(~0u - row)));
      offset = b_.iadd(scaled, b_.i32(row));
    } else if (random_.one_in(2)) {
      offset = b_.iadd(b_.imul(b_.urem(any(Type::kI32), b_.i32(5)), b_.i32(size)), scaled);
      holds = b_.and_(holds, b_.ule(scaled, offset));
    }
    return {base, offset, random_.one_in(8) ? limit : b_.select(holds, limit, b_.i32(0)), 0};
  }

  void load() {
    const Type t = memory_type();
    if (random_.one_in(4)) return contiguous_load(t);
    const uint32_t stride = random_.one_in(3) ? random_.below(9) : 0;
    if (random_.one_in(3)) {  // what this wave wrote
      const Address from{scratch_, random_offset(kScratchBytes), b_.i32(kScratchBytes), stride};
      return keep(b_.load(t, from));
    }
    const Value limit = random_.one_in(2) ? input_bytes_ : b_.i32(kInputBytes);
    const uint8_t flags = random_.one_in(2) ? kInvariant : 0;
    if (random_.one_in(2)) return keep(b_.load(t, indexed(input_, limit, kInputBytes, size_bytes(t)), flags));
    keep(b_.load(t, {input_, random_offset(kInputBytes), limit, stride}, flags));
  }

  void store() {
    const uint32_t stride = random_.one_in(2) ? random_.below(9) : 0;
    const Type t = memory_type();
    if (random_.one_in(4)) return b_.store(indexed(scratch_, b_.i32(kScratchBytes), kScratchBytes, size_bytes(t)), any(t));
    b_.store({scratch_, random_offset(kScratchBytes), b_.i32(kScratchBytes), stride}, any(t));
  }

  void atomic() {
    const Type t = options_.other_widths && random_.one_in(4) ? Type::kI64 : Type::kI32;
    const uint32_t size = size_bytes(t);
    const Value offset = b_.imul(b_.urem(any(Type::kI32), b_.i32(kScratchBytes / size + 2)), b_.i32(size));
    const auto op = static_cast<AtomicOp>(random_.below(static_cast<uint32_t>(AtomicOp::kCompareExchange) + 1));
    const Value comparand = op == AtomicOp::kCompareExchange ? any(t) : Value{};
    keep(b_.atomic(op, {scratch_, offset, b_.i32(kScratchBytes), random_.one_in(3) ? size : 0}, any(t), comparand,
                   random_.one_in(2) ? kPrivate : uint8_t{0}));
  }

  void store_final(uint32_t slot, Value v, uint8_t flags) {
    if (b_.type(v) == Type::kB1) v = b_.convert(Op::kZExt, Type::kI32, v);
    b_.store({.base = window_, .offset = b_.i32(slot * kSlotBytes), .lane_stride = size_bytes(b_.type(v))}, v, flags);
  }

  void variable() {
    const Var v = random_.pick(variables_);
    if (random_.one_in(2)) return keep(b_.get(v));
    b_.set(v, any(v.type));
  }

  void array() {
    const Value local = random_.pick(arrays_);
    const Value index = random_.one_in(3) ? b_.i32(random_.below(6)) : b_.urem(any(Type::kI32), b_.i32(6));
    if (random_.one_in(2)) return keep(b_.local_load(local, index));
    b_.local_store(local, index, any(b_.type(local)));
  }

  // ---- control flow -------------------------------------------------------------------------------------------------------

  std::vector<Type> random_types() {
    std::vector<Type> out(random_.below(4));
    for (Type& t : out) t = random_type();
    return out;
  }

  // Runs a body whose values are not visible afterwards.
  template <typename Body>
  auto scoped(Body&& body) {
    const auto outer = pools_;
    ++depth_;
    auto out = body();
    --depth_;
    pools_ = outer;
    return out;
  }

  std::vector<Value> body(const std::vector<Type>& types) {
    for (uint32_t n = 1 + random_.below(6); n > 0; --n) statement();
    std::vector<Value> out;
    for (Type t : types) out.push_back(any(t));
    return out;
  }

  void if_else() {
    const std::vector<Type> types = random_types();
    const auto side = [&] { return scoped([&] { return body(types); }); };
    for (Value v : b_.if_else(any(Type::kB1), types, side, side)) keep(v);
  }

  // What a translator makes of a break: a lane that leaves keeps what it carried.
  Value leave_early(Value broken, std::span<const Value> carried, Value& count, std::vector<Value>& next, Value again) {
    if (random_.one_in(2)) {
      count = b_.select(broken, carried[0], count);
      for (size_t k = 0; k < next.size(); ++k) next[k] = b_.select(broken, carried[k + 1], next[k]);
      return b_.and_(b_.not_(broken), again);
    }
    std::vector<Type> types{Type::kB1, Type::kI32};
    for (Value v : next) types.push_back(b_.type(v));
    const auto results = b_.if_else(
        broken, types,
        [&] {
          std::vector<Value> out{b_.b1(false)};
          out.insert(out.end(), carried.begin(), carried.end());
          return out;
        },
        [&] {
          std::vector<Value> out{again, b_.iadd(carried[0], b_.i32(1))};
          out.insert(out.end(), next.begin(), next.end());
          return out;
        });
    count = results[1];
    next.assign(results.begin() + 2, results.end());
    return results[0];
  }

  // At most five turns; lanes may leave at different times.
  void loop() {
    const std::vector<Type> types = random_types();
    std::vector<Value> init{b_.i32(0)};
    for (Type t : types) init.push_back(any(t));
    const Value bound = b_.iadd(b_.urem(random_.one_in(2) ? any(Type::kI32) : b_.lane(), b_.i32(4)), b_.i32(1));
    const auto out = b_.loop(init, [&](std::span<const Value> carried) {
      return scoped([&] {
        for (Value v : carried) keep(v);
        std::vector<Value> next = body(types);
        Value count = b_.iadd(carried[0], b_.i32(1));
        Value again = b_.ult(count, bound);
        if (random_.one_in(3)) again = b_.and_(again, any(Type::kB1));
        if (random_.one_in(2)) again = leave_early(any(Type::kB1), carried, count, next, again);
        next.insert(next.begin(), count);
        return Builder::LoopStep{again, std::move(next)};
      });
    });
    for (Value v : out) keep(v);
  }

  Builder b_;
  Random& random_;
  const RandomKernelOptions& options_;
  const bool all_lanes_;  // every wave is full
  uint32_t depth_ = 0;
  std::array<std::vector<Value>, 10> pools_;  // visible values by type
  std::vector<Var> variables_;
  std::vector<Value> arrays_;
  Value input_, input_bytes_, window_, scratch_;
};

}  // namespace

struct RandomKernel::Memory {
  std::vector<uint8_t> input, initial, output, frames;
  DrawBlock draw{};
  std::array<PrimBlock, 3> prims{};
  std::array<PrimRecord, 3> records{};
  std::array<WaveBlock, kWaves> waves{};
};

RandomKernel::RandomKernel(uint64_t seed, const RandomKernelOptions& options) : memory_(std::make_unique<Memory>()) {
  Random random(seed);
  const auto word = [&] {
    const double number = random.below(4000) / 32.0 - 60;
    switch (random.below(4)) {
      case 0:
        return std::bit_cast<uint32_t>(static_cast<float>(random.pick(kSpecialFloats)));
      case 1:
        return random.pick(kSpecialWords);
      case 2:
        return std::bit_cast<uint32_t>(static_cast<float>(number));
      default:
        return random.below(64);
    }
  };
  Memory& m = *memory_;
  m.input.resize(kInputBytes);
  m.initial.resize(kWaves * kWindowBytes);
  for (size_t i = 0; i < m.input.size(); i += 4) {
    const uint32_t bits = word();
    std::copy_n(reinterpret_cast<const uint8_t*>(&bits), 4, &m.input[i]);
  }
  for (uint8_t& byte : m.initial) byte = static_cast<uint8_t>(random.next());
  m.draw = {m.input.data(), kInputBytes - 3, {}};
  std::ranges::generate(m.draw.words, word);
  for (PrimBlock& prim : m.prims) std::ranges::generate(prim.words, word);
  m.records = {{{&m.prims[0], 0, 2}, {&m.prims[1], 2, 0}, {&m.prims[2], 2, 3}}};
  const bool all_lanes = random.one_in(2);
  for (uint32_t i = 0; i < kWaves; ++i) {
    m.waves[i].mask = all_lanes ? 0xffff : static_cast<uint32_t>(random.next() & 0xffff) | 1;
    m.waves[i].index = i;
    std::ranges::generate(m.waves[i].words, word);
  }
  kernel_.name = "random " + std::to_string(seed);
  kernel_.wave_stride_bytes = sizeof(WaveBlock);
  Generator(kernel_, random, options, all_lanes).run();
  // Room for any frame: it may hold every value of three waves.
  if (options.barriers) m.frames.resize(3 * (kernel_.insts.size() + 64) * 8 * kLanes + 64);
  if (const std::string fault = verify(kernel_); !fault.empty()) {
    fprintf(stderr, "random kernel %llu: %s\n", static_cast<unsigned long long>(seed), fault.c_str());
    abort();  // the generator is wrong, so every test that uses it is
  }
}

RandomKernel::~RandomKernel() = default;

std::vector<uint8_t> RandomKernel::run(const Run& run) {
  Memory& m = *memory_;
  m.output = m.initial;
  ThreadContext thread{};
  thread.color[0] = m.output.data();
  thread.wave_frames = reinterpret_cast<uint8_t*>((reinterpret_cast<uintptr_t>(m.frames.data()) + 63) & ~uintptr_t{63});
  run(&m.draw, &thread, m.records.data(), static_cast<uint32_t>(m.records.size()), m.waves.data());
  return m.output;
}

}  // namespace pineda::ir
