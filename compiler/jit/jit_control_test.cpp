// Control flow, masks and operations across lanes; the frame's loops; the plug-in's interface.
#include <thread>

#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

struct Wave {
  uint32_t mask = 0xffff;
  uint32_t uniform = 0;
  uint32_t in[kLanes] = {};
  uint32_t out[6][kLanes] = {};
};

class ControlRig {
 public:
  explicit ControlRig(uint32_t wave_count = 24) : waves(wave_count) {
    std::mt19937 rng(5);
    for (Wave& w : waves) {
      w.mask = rng() % 3 == 0 ? 0xffff : rng();
      w.uniform = rng() % 7;
      for (uint32_t& x : w.in) x = rng() % 12;
    }
    kernel.name = "control";
    kernel.wave_stride_bytes = sizeof(Wave);
  }
  Value in() { return b.load(Type::kI32, {.base = b.wave_ptr(), .offset = b.i32(offsetof(Wave, in)), .lane_stride = 4}); }
  Value uniform() { return b.load(Type::kI32, b.wave_ptr(), offsetof(Wave, uniform)); }
  void put(Value v) {
    b.store({.base = b.wave_ptr(), .offset = b.i32(static_cast<uint32_t>(offsetof(Wave, out)) + slot_++ * 64), .lane_stride = 4},
            v);
  }
  // Twice: all values per lane, then with rates.
  void check() {
    const auto wave_count = static_cast<uint32_t>(waves.size());
    const Call call{.prims = {{nullptr, 0, wave_count}},
                    .waves = waves.data(),
                    .memory = waves.data(),
                    .memory_bytes = waves.size() * sizeof(Wave)};
    expect_same(kernel, call);
    passes::rates(kernel);
    expect_same(kernel, call);
  }

  ir::Kernel kernel;
  Builder b{kernel};
  std::vector<Wave> waves;

 private:
  uint32_t slot_ = 0;
};

// Enough work that the branch is not flattened.
Value long_work(Builder& b, Value x) {
  for (uint32_t i = 0; i < 12; ++i) x = b.xor_(b.imul(x, b.i32(0x9e3779b1 + i)), b.lshr(x, b.i32(i)));
  return x;
}

// Logic of masks that come from words, selected by masks: LLVM's DAG combiner must come to an end (emit_mask.cpp).
TEST(JitControl, MasksFromWords) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in();
  std::vector<Value> word, compared;
  for (uint32_t i = 0; i < 2; ++i) word.push_back(b.unpack_mask(b.imul(r.uniform(), b.i32(0x1357 + 2 * i))));
  for (uint32_t i = 0; i < 3; ++i) compared.push_back(b.ult(x, b.i32(3 + i)));
  const Value either = b.or_(word[1], word[0]);
  const Value chosen = b.ballot(b.select(compared[2], either, word[1]));
  const Value both = b.ballot(b.and_(compared[1], b.and_(compared[0], word[0])));
  r.put(chosen);
  r.put(b.and_(both, b.i32(1)));
  r.check();
}

TEST(JitControl, DivergentIf) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in();
  const auto longer = b.if_else(
      b.ult(x, b.i32(5)), {Type::kI32, Type::kB1},
      [&] {
        return std::vector{long_work(b, x), b.ult(x, b.i32(2))};
      },
      [&] {
        return std::vector{b.iadd(x, b.i32(100)), b.b1(true)};
      });
  const auto flat = b.if_else(
      b.ult(x, b.i32(8)), {Type::kI32}, [&] { return std::vector{b.isub(x, b.i32(1))}; },
      [&] { return std::vector{r.uniform()}; });
  r.put(longer[0]);
  r.put(b.convert(ir::Op::kZExt, Type::kI32, longer[1]));
  r.put(flat[0]);
  b.if_(b.ieq(x, b.i32(3)), [&] { r.put(long_work(b, x)); });
  b.if_else(
      b.ult(x, b.i32(1)), [&] {}, [&] { r.put(x); });
  r.check();
}

TEST(JitControl, UniformIf) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in(), u = r.uniform();
  const auto v = b.if_else(
      b.ult(u, b.i32(3)), {Type::kI32, Type::kI32, Type::kB1},
      [&] {
        return std::vector{b.iadd(u, b.i32(1)), long_work(b, x), b.ult(x, u)};
      },
      [&] {
        return std::vector{b.imul(u, u), u, b.b1(false)};
      });
  for (int i = 0; i < 2; ++i) r.put(v[static_cast<size_t>(i)]);
  r.put(b.convert(ir::Op::kZExt, Type::kI32, v[2]));
  b.if_(b.ieq(u, b.i32(2)), [&] { b.if_(b.ult(x, b.i32(6)), [&] { r.put(b.ballot(b.b1(true))); }); });
  r.check();
}

TEST(JitControl, DivergentLoop) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in();
  // carried: count (uniform among the lanes that are in it), product (per lane), flag, pointer
  const auto v = b.loop({b.i32(0), b.i32(1), b.b1(true), b.wave_ptr()}, [&](std::span<const Value> c) {
    const Value n = b.iadd(c[0], b.i32(1));
    return Builder::LoopStep{b.ult(n, x), {n, b.imul(c[1], b.iadd(n, x)), b.not_(c[2]), b.ptr_add(c[3], b.i32(4))}};
  });
  r.put(v[0]);
  r.put(v[1]);
  r.put(b.convert(ir::Op::kZExt, Type::kI32, v[2]));
  r.put(b.load(Type::kI32, v[3], 0));
  r.check();
}

TEST(JitControl, UniformLoop) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in(), u = r.uniform();
  const auto v = b.loop({b.i32(0), x, b.i32(0), b.i32(1)}, [&](std::span<const Value> c) {  // Fibonacci in the last two
    return Builder::LoopStep{b.ult(c[0], u), {b.iadd(c[0], b.i32(1)), b.iadd(c[1], c[0]), c[3], b.iadd(c[2], c[3])}};
  });
  for (size_t i = 0; i < 4; ++i) r.put(v[i]);
  r.check();
}

TEST(JitControl, NestedLoopsAndBreaks) {
  ControlRig r;
  Builder& b = r.b;
  const Value x = r.in();
  const auto v = b.loop({b.i32(0), b.i32(0)}, [&](std::span<const Value> outer) {
    const auto inner = b.loop({b.i32(0), outer[1]}, [&](std::span<const Value> c) {
      const auto sum = b.if_else(
          b.ieq(b.and_(b.iadd(c[0], outer[0]), b.i32(1)), b.i32(0)), {Type::kI32},
          [&] { return std::vector{long_work(b, b.iadd(c[1], x))}; }, [&] { return std::vector{b.iadd(c[1], b.i32(1))}; });
      const Value n = b.iadd(c[0], b.i32(1));
      return Builder::LoopStep{b.and_(b.ult(n, b.i32(4)), b.ine(b.and_(sum[0], b.i32(7)), b.i32(0))), {n, sum[0]}};
    });
    const Value n = b.iadd(outer[0], inner[0]);
    b.if_(b.ult(x, b.i32(4)),
          [&] { b.store({.base = b.wave_ptr(), .offset = b.i32(offsetof(Wave, out) + 320), .lane_stride = 4}, n); });
    return Builder::LoopStep{b.ult(n, x), {n, inner[1]}};
  });
  r.put(v[0]);
  r.put(v[1]);
  r.check();
}

TEST(JitControl, AcrossLanes) {
  ControlRig r;
  for (Wave& w : r.waves) w.mask = 0xffff;
  Builder& b = r.b;
  const Value x = r.in(), small = b.ult(x, b.i32(6));
  r.put(b.quad_swizzle(x, 0b00011011));
  r.put(b.convert(ir::Op::kZExt, Type::kI32, b.quad_swizzle(small, 0b10110001)));
  r.put(b.ballot(small));
  r.put(b.convert(ir::Op::kZExt, Type::kI32, b.unpack_mask(b.imul(r.uniform(), b.i32(0x1357)))));
  b.if_(b.ult(x, b.i32(9)), [&] {
    r.put(b.ballot(small));
    r.put(b.ballot(b.ult(r.uniform(), b.i32(3))));
  });
  r.check();
}

TEST(JitControl, PrimitiveLoop) {
  ControlRig r;
  r.kernel.name = "with spaces, and: punctuation";
  Builder& b = r.b;
  const Value factor = b.load(Type::kI32, b.prim_ptr(), 0);
  r.put(b.imul(r.in(), factor));
  r.put(b.load(Type::kI32, b.draw_ptr(), 4));
  r.put(b.load(Type::kI32, b.thread_ptr(), 0));
  passes::rates(r.kernel);
  uint32_t draw[2] = {1, 42}, thread = 7;
  const uint32_t factors[3] = {2, 3, 5};
  expect_same(r.kernel, {.draw = draw,
                         .thread = &thread,
                         .prims = {{&factors[0], 4, 3}, {&factors[1], 0, 0}, {&factors[2], 9, 15}, {&factors[1], 1, 1}},
                         .waves = r.waves.data(),
                         .memory = r.waves.data(),
                         .memory_bytes = r.waves.size() * sizeof(Wave)});
  expect_same(r.kernel, {.waves = r.waves.data(), .memory = r.waves.data(), .memory_bytes = r.waves.size() * sizeof(Wave)});
}

TEST(JitControl, FragmentKernelsRunAllLanes) {
  ControlRig r;
  r.kernel.kind = ir::KernelKind::kFragment;
  for (Wave& w : r.waves) w.mask = 0xffff;
  Builder& b = r.b;
  const Value covered = b.unpack_mask(b.imul(r.uniform(), b.i32(0x1357)));
  b.if_(covered, [&] { r.put(long_work(b, r.in())); });
  r.put(b.ballot(b.b1(true)));
  r.check();
}

TEST(JitApi, DumpsOnRequest) {
  ControlRig r;
  r.put(r.in());
  const Compiled plain(r.kernel, {}), dumped(r.kernel, {.want_llvm_ir = true, .want_assembly = true});
  EXPECT_TRUE(plain.code.llvm_ir.empty() && plain.code.assembly.empty());
  EXPECT_NE(dumped.code.llvm_ir.find("pineda.control"), std::string::npos);
  EXPECT_NE(dumped.code.assembly.find("ret"), std::string::npos);
  EXPECT_GT(dumped.code.size_bytes, 0u);
}

TEST(JitApi, CompilesOnSeveralThreads) {
  std::vector<std::thread> threads;
  std::array<std::string, 4> errors;
  for (size_t t = 0; t < errors.size(); ++t) {
    threads.emplace_back([&errors, t] {
      for (uint32_t i = 0; i < 5; ++i) {
        ControlRig r(2);
        r.put(long_work(r.b, r.b.iadd(r.in(), r.b.i32(static_cast<uint32_t>(t) * 100 + i))));
        const Compiled compiled(r.kernel, {.isa = isas().back()});
        errors[t] += compiled.code.error;
        if (compiled.code.fn == nullptr) continue;
        const PrimRecord prim{nullptr, 0, 2};
        std::vector<Wave> expected = r.waves;
        eval::run(r.kernel, eval::Mode::kF32, nullptr, nullptr, &prim, 1, expected.data());
        KernelHandle{compiled.code.fn}(nullptr, nullptr, &prim, 1, r.waves.data());
        if (std::memcmp(expected.data(), r.waves.data(), 2 * sizeof(Wave)) != 0) errors[t] += "wrong result";
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& error : errors) EXPECT_EQ(error, "");
}

TEST(JitApi, SelectsAnIsaThatRuns) {
  std::string error;
  const Isa isa = select_isa(&error);
  EXPECT_TRUE(error.empty()) << error;
  EXPECT_TRUE(isa_supported(isa));
}

}  // namespace
}  // namespace pineda::jit::test
