// The text form and the verifier.
#include "compiler/ir/ir.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "compiler/ir/builder.h"

namespace pineda::ir {
namespace {

Kernel parse_ok(const std::string& text) {
  ParseResult result = parse(text);
  EXPECT_EQ(result.error, "") << text;
  return std::move(result.kernel);
}

const char* const kHeader = "kernel compute \"t\" stride 8\n";
// Body of the wave region -> what verify() says.
std::string verify_wave(const std::string& body) { return verify(parse_ok(kHeader + std::string("wave:\n") + body)); }

TEST(IrText, RoundTripsEveryConstruct) {
  const std::string text = R"(kernel fragment "name" stride 16
draw:
  %1 = draw_ptr ptr @draw
  %2 = const i32 16 @draw
  %3 = load f32 %1, %2 invariant speculate @draw
prim:
  %4 = prim_ptr ptr @prim
wave:
  %5 = local f32 4
  %6 = local b1 1
  %7 = wave_ptr ptr @wave
  %8 = lane i32
  %9 = const i32 0xffffffff
  %10 = const f32 1.5
  %11 = const f32 -inf
  %12 = const f64 nan
  %13 = const b1 true
  %14 = load i32 %7, %8 limit %9 stride 4
  %15 = fadd f32 %3, %10 no_contract
  %16 = if %13 {
    local_store %5, %8, %15
    yield %15
  } else {
    yield %3
  }
  %17 = result f32 %16, 0
  %18 = loop %17, %8 {
    %19 = loop_arg f32 0
    %20 = loop_arg i32 1
    %21 = local_load f32 %5, %20
    %22 = flt b1 %19, %10
    yield %22, %21, %20
  }
  %23 = result i32 %18, 1
  %24 = quad_swizzle f32 %17, 177
  %25 = atomic compare_exchange i32 %7, %8, %14 limit %9 comparand %23
  %26 = atomic add i32 %7, %8, %14 stride 4
  store %7, %8, %24 limit %9 stride 4 all_lanes
)";
  const Kernel kernel = parse_ok(text);
  EXPECT_EQ(verify(kernel), "");
  EXPECT_EQ(print(kernel), text);
}

TEST(IrText, RoundTripsConstants) {
  Kernel kernel;
  Builder b(kernel);
  for (double v : {0.1, 1e-320, -0.0, 3.4028234663852886e38, 1.0 / 3}) b.f32(v);
  for (uint64_t v : {0ull, 65535ull, 65536ull, ~0ull}) b.i64(v);
  b.constant(Type::kI8, 0xff);
  const Kernel again = parse_ok(print(kernel));
  ASSERT_EQ(again.insts.size(), kernel.insts.size());
  for (size_t i = 1; i < kernel.insts.size(); ++i) EXPECT_EQ(again.insts[i].imm, kernel.insts[i].imm) << i;
}

TEST(IrText, NamesAreFree) {
  const Kernel kernel = parse_ok(std::string(kHeader) + "wave:\n  %x = const i32 -1  ; all ones\n  %sum = iadd i32 %x, %x\n");
  EXPECT_EQ(print(kernel), std::string(kHeader) + "wave:\n  %1 = const i32 0xffffffff\n  %2 = iadd i32 %1, %1\n");
}

TEST(IrText, RejectsMalformedText) {
  const std::pair<const char*, const char*> cases[] = {
      {"wave:\n  %1 = nonsense i32\n", "line 3: unknown operation"},
      {"wave:\n  %1 = iadd i32 %2, %2\n", "line 3: %2 is not defined"},
      {"wave:\n  %1 = const i32 4 5\n", "line 3: unexpected '5'"},
      {"wave:\n  %1 = const b1 true\n  %2 = if %1 {\n", "line 4: a region is not closed"},
      {"wave:\n  }\n", "line 3: '}' without a region"},
      {"wave:\n  %1 = lane i32\n  %1 = lane i32\n", "line 4: %1 is defined twice"},
      {"  %1 = lane i32\n", "line 2: instruction outside of a region"},
      {"", "line 1: no wave region"},
  };
  for (const auto& [text, error] : cases) EXPECT_EQ(parse(kHeader + std::string(text)).error, error);
}

TEST(IrText, EveryPrefixIsHandled) {
  const std::string text = std::string(kHeader) +
                           "wave:\n  %1 = const b1 true\n  %2 = if %1 {\n    yield %1\n  } else {\n    yield %1\n"
                           "  }\n  %3 = result b1 %2, 0\n";
  for (size_t n = 0; n <= text.size(); ++n) {
    const ParseResult result = parse(text.substr(0, n));
    if (result.error.empty()) verify(result.kernel);
  }
}

TEST(IrVerify, RejectsMalformedKernels) {
  const std::pair<const char*, const char*> cases[] = {
      {"%1 = const i32 1\n%2 = const f32 1\n%3 = iadd i32 %1, %2\n", "operands must have the result's type"},
      {"%1 = const f32 1\n%2 = iadd f32 %1, %1\n", "needs integers"},
      {"%1 = const i32 1\n%2 = fadd i32 %1, %1\n", "needs floats"},
      {"%1 = const f64 1\n%2 = fsin f64 %1\n", "needs f16 or f32"},
      {"%1 = const b1 true\n%2 = ieq b1 %1, %1\n", "needs integers"},
      {"%1 = const i8 256\n", "constant does not fit its type"},
      {"%1 = const i32 1\n%2 = bitcast i64 %1\n", "must keep the width"},
      {"%1 = const i32 1\n%2 = trunc i32 %1\n", "must narrow an integer"},
      {"%1 = const i32 1\n%2 = select i32 %1, %1, %1\n", "must be b1, T, T -> T"},
      {"%1 = wave_ptr ptr\n%2 = const b1 true\n%3 = const i32 0\nstore %1, %3, %2\n", "b1 is never in memory"},
      {"%1 = wave_ptr ptr\n%2 = const i64 0\n%3 = load i32 %1, %2\n", "offset must be i32"},
      {"%1 = const i32 0\n%2 = iadd i32 %1, %1 invariant\n", "has a flag that it cannot have"},
      {"%1 = const i32 0\n%2 = quad_swizzle i32 %1, 256\n", "pattern is out of range"},
      {"%1 = const i32 0\n%2 = local i32 1\n", "must stand at the head of the wave region"},
      {"%1 = local i32 1\n%2 = iadd i32 %1, %1\n", "a local is not a value"},
      {"%1 = const b1 true\nyield %1\n", "yield must end a region of if or loop"},
      {"%1 = const b1 true\n%2 = if %1 {\nyield %1\n} else {\nyield\n}\n", "its regions yield different types"},
      {"%1 = const b1 true\n%2 = if %1 {\n} else {\nyield\n}\n", "a region does not end with yield"},
      {"%1 = const b1 true\n%2 = if %1 {\n%3 = lane i32\nyield\n} else {\nyield\n}\n%4 = iadd i32 %3, %3\n",
       "operand 0 is not defined before it"},
      {"%1 = const b1 true\n%2 = if %1 {\nyield %1\n} else {\nyield %1\n}\n%3 = lane i32\n%4 = result b1 %2, 0\n",
       "must follow its if or loop"},
      {"%1 = const b1 true\n%2 = if %1 {\nyield %1\n} else {\nyield %1\n}\n%4 = result b1 %2, 1\n", "no such result"},
      {"%1 = const b1 true\n%2 = loop %1 {\nyield %1, %1\n}\n", "loop_arg 0 is not at its place"},
      {"%1 = const i32 0\n%2 = loop {\nyield %1\n}\n", "must yield b1 first"},
      {"%1 = loop_arg i32 0\n", "must stand in a loop body"},
      {"%1 = wave_ptr ptr\n%2 = const i32 0\n%3 = atomic add i32 %1, %2, %2 comparand %2\n",
       "comparand goes with compare_exchange"},
  };
  for (const auto& [body, fault] : cases) EXPECT_TRUE(verify_wave(body).ends_with(fault)) << body << verify_wave(body);
}

TEST(IrVerify, RejectsWhatTextCannotSay) {
  const auto verdict = [](const std::function<void(Kernel&)>& damage) {
    Kernel kernel;
    Builder b(kernel);
    const Value x = b.lane();
    b.if_(b.ieq(x, x), [&] { b.iadd(x, x); });
    EXPECT_EQ(verify(kernel), "");
    damage(kernel);
    return verify(kernel);
  };
  EXPECT_NE(verdict([](Kernel& k) { k.wave = 0; }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.regions[k.wave].insts.push_back({99999}); }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.regions[k.wave].insts.push_back(k.regions[k.wave].insts[0]); }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.insts[1].op = Op::kCount; }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.insts[3].region[0] = k.wave; }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.insts[3].region[1] = 0; }), "");
  EXPECT_NE(verdict([](Kernel& k) { k.insts[3].region[1] = 77; }), "");
  EXPECT_NE(verdict([](Kernel& k) { std::swap(k.draw, k.wave); }), "");
}

TEST(IrBuilder, MakesVerifiedKernels) {
  Kernel kernel;
  kernel.name = "builder";
  Builder b(kernel);
  const Value x = b.load(Type::kF32, b.draw_ptr(), 16, kInvariant);
  const Var v = b.variable(Type::kF32);
  const auto r = b.if_else(
      b.flt(x, b.f32(0)), {Type::kF32}, [&] { return std::vector{b.fneg(x)}; }, [&] { return std::vector{x}; });
  b.set(v, r[0]);
  const Var late = b.variable(Type::kI32);  // made after instructions, placed before them
  const auto count = b.loop({b.i32(0)}, [&](std::span<const Value> carried) {
    b.set(late, carried[0]);
    const Value next = b.iadd(carried[0], b.i32(1));
    return Builder::LoopStep{b.ult(next, b.i32(4)), {next}};
  });
  b.store({.base = b.wave_ptr(), .offset = count[0], .lane_stride = 4}, b.get(v));
  EXPECT_EQ(verify(kernel), "");
  EXPECT_EQ(print(parse_ok(print(kernel))), print(kernel));
}

TEST(IrBuilder, CanonicalisesOnlyArithmetic) {
  Kernel kernel;
  Builder b(kernel);
  const auto canons = [&] { return std::ranges::count(kernel.insts, Op::kFCanon, &Inst::op); };
  const Value loaded = b.load(Type::kF32, b.wave_ptr(), 0);
  b.bitcast(Type::kI32, loaded);
  b.store({.base = b.wave_ptr()}, b.bitcast(Type::kF32, b.lane()));
  b.bitcast(Type::kI32, b.f32(1));
  EXPECT_EQ(canons(), 0);
  b.bitcast(Type::kI32, b.fadd(loaded, loaded));
  EXPECT_EQ(canons(), 1);
  b.store({.base = b.wave_ptr()}, b.fcanon(loaded));
  EXPECT_EQ(canons(), 2);
  EXPECT_EQ(verify(kernel), "");
}

}  // namespace
}  // namespace pineda::ir
