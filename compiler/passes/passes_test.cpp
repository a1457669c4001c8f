// Each pass but fold on small kernels, as text. That passes keep the bits of whole kernels is tested in random_test.cpp.
#include "compiler/passes/passes.h"

#include <gtest/gtest.h>

#include "compiler/passes/rewrite.h"
#include "compiler/passes/test_text.h"

namespace pineda::passes {
namespace {

// ---- ssa, dce -------------------------------------------------------------------------------------------------------------

TEST(Ssa, IfAndLoopMakeResultsAndCarriedValues) {
  const std::string out = run_on_text(R"(%a = local i32 1
%0 = const i32 0
%1 = const i32 1
%c = const b1 true
%i = if %c {
  local_store %a, %0, %1
  yield
} else {
  yield
}
%l = loop {
  %x = local_load i32 %a, %0
  %y = iadd i32 %x, %1
  local_store %a, %0, %y
  %z = ult b1 %y, %1
  yield %z
}
%p = wave_ptr ptr
%r = local_load i32 %a, %0
store %p, %0, %r
)",
                                      [](ir::Kernel& k) {
                                        ssa(k);
                                        dce(k);
                                      });
  EXPECT_EQ(out, R"(wave:
  %1 = const i32 0
  %2 = const i32 0
  %3 = const i32 1
  %4 = const b1 true
  %5 = if %4 {
    yield %3
  } else {
    yield %1
  }
  %6 = result i32 %5, 0
  %7 = loop %6 {
    %8 = loop_arg i32 0
    %9 = iadd i32 %8, %3
    %10 = ult b1 %9, %3
    yield %10, %9
  }
  %11 = result i32 %7, 0
  %12 = wave_ptr ptr
  store %12, %2, %11
)");
}

TEST(Ssa, ElementsOfArraysWithConstantIndicesAreVariables) {
  const std::string out = run_on_text(R"(%a = local i32 2
%p = wave_ptr ptr
%0 = const i32 0
%1 = const i32 1
%9 = const i32 9
local_store %a, %1, %9
local_store %a, %9, %1
%r = local_load i32 %a, %1
%s = local_load i32 %a, %0
%t = local_load i32 %a, %9
store %p, %0, %r
store %p, %0, %s
store %p, %0, %t
)",
                                      ssa);
  EXPECT_EQ(out, R"(wave:
  %1 = const i32 0
  %2 = wave_ptr ptr
  %3 = const i32 0
  %4 = const i32 1
  %5 = const i32 9
  %6 = const i32 0
  store %2, %3, %5
  store %2, %3, %1
  store %2, %3, %6
)");
}

TEST(Dce, RemovesWhatNobodyReads) {
  const std::string out = run_on_text(R"(%a = local i32 1
%p = wave_ptr ptr
%0 = const i32 0
%c = const b1 true
local_store %a, %0, %0
%l = loop %0, %0, %0 {
  %x = loop_arg i32 0
  %y = loop_arg i32 1
  %z = loop_arg i32 2
  %d = iadd i32 %y, %y
  %e = ult b1 %x, %x
  yield %e, %x, %d, %z
}
%r = result i32 %l, 2
%q = loop %0 {
  %u = loop_arg i32 0
  yield %c, %u
}
%i = if %c {
  %m = iadd i32 %0, %0
  yield %m, %0
} else {
  yield %0, %0
}
%j = result i32 %i, 0
%k = result i32 %i, 1
store %p, %0, %k
store %p, %0, %r
)",
                                      dce);
  EXPECT_EQ(out, R"(wave:
  %1 = wave_ptr ptr
  %2 = const i32 0
  %3 = const b1 true
  %4 = loop %2, %2 {
    %5 = loop_arg i32 0
    %6 = loop_arg i32 1
    %7 = ult b1 %5, %5
    yield %7, %5, %6
  }
  %8 = result i32 %4, 1
  %9 = if %3 {
    yield %2
  } else {
    yield %2
  }
  %10 = result i32 %9, 0
  store %1, %2, %10
  store %1, %2, %8
)");
}

// ---- cse ------------------------------------------------------------------------------------------------------------------

TEST(Cse, LoadsMeetOnlyWhereNothingWrites) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%0 = const i32 0
%c = const b1 true
%a = load i32 %p, %0
%b = load i32 %p, %0
store %p, %0, %b
%d = load i32 %p, %0
%i = load i32 %p, %0 invariant
%l = loop {
  %e = load i32 %p, %0
  %j = load i32 %p, %0 invariant
  %f = iadd i32 %e, %j
  store %p, %0, %f
  %n = ult b1 %f, %d
  yield %n
}
%g = load i32 %p, %0
%h = iadd i32 %g, %i
store %p, %0, %h
)",
                                      cse);
  EXPECT_EQ(out, R"(wave:
  %1 = wave_ptr ptr
  %2 = const i32 0
  %3 = const b1 true
  %4 = load i32 %1, %2
  store %1, %2, %4
  %5 = load i32 %1, %2
  %6 = load i32 %1, %2 invariant
  %7 = loop {
    %8 = load i32 %1, %2
    %9 = iadd i32 %8, %6
    store %1, %2, %9
    %10 = ult b1 %9, %5
    yield %10
  }
  %11 = load i32 %1, %2
  %12 = iadd i32 %11, %6
  store %1, %2, %12
)");
}

TEST(Cse, RegionsSeeOnlyWhatEnclosesThem) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%0 = const i32 4
%c = const b1 true
%a = iadd i32 %0, %0
%i = if %c {
  %b = iadd i32 %0, %0
  %d = imul i32 %b, %0
  store %p, %0, %d
  yield
} else {
  %e = imul i32 %0, %a
  store %p, %0, %e
  yield
}
)",
                                      cse);
  EXPECT_EQ(out, R"(wave:
  %1 = wave_ptr ptr
  %2 = const i32 4
  %3 = const b1 true
  %4 = iadd i32 %2, %2
  %5 = if %3 {
    %6 = imul i32 %4, %2
    store %1, %2, %6
    yield
  } else {
    %7 = imul i32 %2, %4
    store %1, %2, %7
    yield
  }
)");
}

// ---- flatten_ifs ----------------------------------------------------------------------------------------------------------

TEST(FlattenIfs, ShortPureSidesBecomeSelects) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%l = lane i32
%c = ult b1 %l, %l
%i = if %c {
  %a = iadd i32 %l, %l
  %j = if %c {
    %d = imul i32 %a, %l
    yield %d
  } else {
    yield %l
  }
  %r = result i32 %j, 0
  yield %r
} else {
  yield %l
}
%s = result i32 %i, 0
%k = if %c {
  store %p, %l, %s
  yield
} else {
  yield
}
%m = if %c {
  %q = udiv i32 %l, %s
  yield %q
} else {
  yield %l
}
%n = result i32 %m, 0
)",
                                      [](ir::Kernel& k) {
                                        rates(k);
                                        flatten_ifs(k);
                                        for (ir::Inst& inst : k.insts) inst.rate = ir::Rate::kLane;
                                      });
  EXPECT_EQ(out, R"(wave:
  %1 = wave_ptr ptr
  %2 = lane i32
  %3 = ult b1 %2, %2
  %4 = iadd i32 %2, %2
  %5 = imul i32 %4, %2
  %6 = select i32 %3, %5, %2
  %7 = select i32 %3, %6, %2
  %8 = if %3 {
    store %1, %2, %7
    yield
  } else {
    yield
  }
  %9 = if %3 {
    %10 = udiv i32 %2, %7
    yield %10
  } else {
    yield %2
  }
  %11 = result i32 %9, 0
)");
}

// ---- unroll ---------------------------------------------------------------------------------------------------------------

// for (y = 0; y < 3; ++y) for (x = 0; x < 2; ++x) sum += 10 * y + x, in the form that SPIR-V's loops come in, with break flags.
TEST(Unroll, NestedLoopsWithConstantCountersBecomeTheirSum) {
  const std::string out = run_on_text(R"(%z = const i32 0
%n = const i32 1
%2 = const i32 2
%3 = const i32 3
%10 = const i32 10
%f = const b1 false
%o = loop %z, %z, %f {
  %s = loop_arg i32 0
  %y = loop_arg i32 1
  %b = loop_arg b1 2
  %c = slt b1 %y, %3
  %i = if %c {
    %u = loop %s, %z {
      %t = loop_arg i32 0
      %x = loop_arg i32 1
      %m = imul i32 %y, %10
      %a = iadd i32 %m, %x
      %w = iadd i32 %t, %a
      %k = iadd i32 %x, %n
      %g = ult b1 %k, %2
      yield %g, %w, %k
    }
    %v = result i32 %u, 0
    yield %v
  } else {
    yield %s
  }
  %r = result i32 %i, 0
  %d = not b1 %c
  %e = or b1 %d, %b
  %h = not b1 %b
  %j = and b1 %c, %h
  %q = iadd i32 %y, %n
  yield %j, %r, %q, %e
}
%l = result i32 %o, 0
%p = wave_ptr ptr
store %p, %z, %l
)",
                                      [](ir::Kernel& k) {
                                        while (unroll(k)) fold(k);
                                        dce(k);
                                        compact(k);
                                      });
  EXPECT_EQ(out, R"(wave:
  %1 = const i32 0
  %2 = const i32 63
  %3 = wave_ptr ptr
  store %3, %1, %2
)");
}

TEST(Unroll, LoopsThatDependOnWhatIsReadStay) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%z = const i32 0
%n = const i32 1
%x = load i32 %p, %z
%u = loop %z {
  %i = loop_arg i32 0
  %k = iadd i32 %i, %n
  %g = ult b1 %k, %x
  yield %g, %k
}
%v = result i32 %u, 0
store %p, %z, %v
)",
                                      [](ir::Kernel& k) { EXPECT_FALSE(unroll(k)); });
  EXPECT_NE(out.find("loop"), std::string::npos);
}

// ---- consecutive_accesses -------------------------------------------------------------------------------------------------

// A buffer's word at index + lane, guarded as spirv/pointer.cpp does it: one comparison, whose room is a value of the limit.
TEST(ConsecutiveAccesses, OneComparisonForAllLanes) {
  const std::string out = run_on_text(R"(%0 = const i32 0
%4 = const i32 4
%8 = const i32 8
%m = const i32 0x3fffffff
%k = const i32 0xfffffff7
%p = draw_ptr ptr
%l = load i32 %p, %0 invariant speculate
%i = load i32 %p, %4 invariant speculate
%x = lane i32
%n = iadd i32 %i, %x
%c = ule b1 %n, %m
%s = imul i32 %n, %4
%d = ule b1 %s, %k
%e = and b1 %c, %d
%g = select i32 %e, %l, %0
%o = iadd i32 %s, %8
%v = load f32 %p, %o limit %g
store %p, %0, %v stride 4
)",
                                      [](ir::Kernel& k) {
                                        rates(k);
                                        EXPECT_TRUE(consecutive_accesses(k));
                                        dce(k);
                                        cse(k);
                                        rates(k);
                                      });
  // rest = 8 + 64 - 4 bytes
  EXPECT_NE(out.find("const i32 68"), std::string::npos) << out;
  EXPECT_NE(out.find("umax"), std::string::npos) << out;
  EXPECT_NE(out.find(" likely @"), std::string::npos) << out;
  const size_t whole = out.find("stride 4\n    yield"), each = out.find("limit");
  EXPECT_LT(whole, each) << out;
  EXPECT_EQ(out.substr(0, out.find("likely")).find("ule"), std::string::npos) << "guards are for single lanes:\n" << out;
}

TEST(ConsecutiveAccesses, KnownRangesNeedNone) {
  const std::string out = run_on_text(R"(%0 = const i32 0
%1 = const i32 31
%4 = const i32 4
%z = const i32 192
%p = draw_ptr ptr
%i = load i32 %p, %4 invariant speculate
%j = and i32 %i, %1
%x = lane i32
%n = iadd i32 %j, %x
%s = imul i32 %n, %4
%v = load f32 %p, %s limit %z
store %p, %0, %v stride 4
)",
                                      [](ir::Kernel& k) {
                                        rates(k);
                                        EXPECT_TRUE(consecutive_accesses(k));
                                        dce(k);
                                      });
  EXPECT_EQ(out.find("limit"), std::string::npos) << out;
  EXPECT_EQ(out.find("if "), std::string::npos) << out;
}

// ---- narrow_loops ---------------------------------------------------------------------------------------------------------

// for (i = 0; i < 8; ++i) { if (p[lane] < i) break; a += p[lane]; } with i read afterwards: the body's i is uniform, the other's
// is not.
// A flag of the form "left already, or leaves now" is false in every turn that runs.
TEST(NarrowLoops, FlagsThatOnlyEndTheLoopAreConstants) {
  const std::string out = run_on_text(R"(%0 = const i32 0
%1 = const i32 1
%f = const b1 false
%w = wave_ptr ptr
%n = load i32 %w, %0
%l = loop %0, %f {
  %i = loop_arg i32 0
  %b = loop_arg b1 1
  %c = ult b1 %i, %n
  store %w, %0, %i
  %d = not b1 %c
  %e = or b1 %d, %b
  %g = not b1 %b
  %h = and b1 %c, %g
  %j = iadd i32 %i, %1
  yield %h, %j, %e
}
)",
                                      [](ir::Kernel& k) {
                                        rates(k);
                                        narrow_loops(k);
                                        fold(k);
                                        dce(k);
                                      });
  EXPECT_EQ(out.find("loop_arg b1"), std::string::npos) << out;
  EXPECT_EQ(out.find("= not"), std::string::npos) << out;
}

TEST(NarrowLoops, ACounterIsUniformInSpiteOfABreak) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%l = lane i32
%z = const i32 0
%n = const i32 1
%8 = const i32 8
%f = const b1 false
%x = load i32 %p, %l
%u = loop %z, %z, %f {
  %i = loop_arg i32 0
  %a = loop_arg i32 1
  %b = loop_arg b1 2
  %c = ult b1 %x, %i
  %j = if %c {
    yield %f, %i, %a, %c
  } else {
    %k = iadd i32 %i, %n
    %d = iadd i32 %a, %x
    %g = ult b1 %k, %8
    yield %g, %k, %d, %b
  }
  %q = result b1 %j, 0
  %r = result i32 %j, 1
  %s = result i32 %j, 2
  %t = result b1 %j, 3
  yield %q, %r, %s, %t
}
%v = result i32 %u, 0
%w = result i32 %u, 1
store %p, %l, %v
store %p, %l, %w
)",
                                      [](ir::Kernel& k) {
                                        rates(k);
                                        narrow_loops(k);
                                        fold(k);
                                        dce(k);
                                        rates(k);
                                      });
  EXPECT_NE(out.find(R"(  %8 = loop %3, %3, %3 {
    %9 = loop_arg i32 0
    %10 = loop_arg i32 1
    %11 = loop_arg i32 2 @wave
    %12 = ult b1 %7, %11
)"),
            std::string::npos)
      << out;
}

TEST(NarrowLoops, OfAConjunctionThatIsFalseNothingIsKnown) {
  const std::string text = R"(%l = lane i32
%z = const i32 0
%u = loop %z {
  %i = loop_arg i32 0
  %c = ult b1 %l, %i
  %d = ieq b1 %i, %l
  %b = and b1 %c, %d
  %s = select i32 %c, %i, %l
  %n = not b1 %b
  yield %n, %s
}
)";
  const auto narrow = [](ir::Kernel& k) {
    rates(k);
    narrow_loops(k);
  };
  EXPECT_EQ(run_on_text(text, narrow), run_on_text(text, rates));
}

// ---- fuse_fma -------------------------------------------------------------------------------------------------------------

TEST(FuseFma, TheLeftProductWins) {
  const std::string out = run_on_text(R"(%a = const f32 2
%b = const f32 3
%m = fmul f32 %a, %b
%n = fmul f32 %b, %b
%u = fadd f32 %m, %n
%v = fsub f32 %a, %n
%w = fsub f32 %m, %b
%x = fadd f32 %a, %m no_contract
%k = fmul f32 %a, %a no_contract
%y = fadd f32 %k, %b
)",
                                      fuse_fma);
  EXPECT_EQ(out, R"(wave:
  %1 = const f32 2
  %2 = const f32 3
  %3 = fmul f32 %1, %2 no_contract
  %4 = fmul f32 %2, %2 no_contract
  %5 = fma f32 %1, %2, %4
  %6 = fneg f32 %2
  %7 = fma f32 %6, %2, %1
  %8 = fneg f32 %2
  %9 = fma f32 %1, %2, %8
  %10 = fadd f32 %1, %3 no_contract
  %11 = fmul f32 %1, %1 no_contract
  %12 = fadd f32 %11, %2 no_contract
)");
}

// A vec4 attribute that is (x, y, z, 1) in memory and a vec3 one, whose w the vertex fetch makes a constant 1, must give the same
// bits, so products are fused before fold sees the 1.
TEST(FuseFma, ComesBeforeFold) {
  const auto optimized = [](const std::string& w) {
    return run_on_text("%p = wave_ptr ptr\n%o = const i32 4\n%a = load f32 %p, %o\n" + w +
                           "%m = fmul f32 %a, %w\n%n = fmul f32 %a, %a\n%s = fadd f32 %m, %n\nstore %p, %o, %s\n",
                       [](ir::Kernel& k) { optimize(k, Form::kMachine); });
  };
  EXPECT_NE(optimized("%w = load f32 %p, %o stride 4\n").find("fma"), std::string::npos);
  const std::string one = optimized("%w = const f32 1\n");
  EXPECT_EQ(one.find("fma"), std::string::npos) << one;  // round(a + round(a * a)), as the fma gives when w is 1
  EXPECT_NE(one.find("fmul"), std::string::npos) << one;
}

// ---- rates, hoist ---------------------------------------------------------------------------------------------------------

TEST(Rates, FixedPoint) {
  const std::string out = run_on_text(R"(%d = draw_ptr ptr
%p = prim_ptr ptr
%w = wave_ptr ptr
%o = const i32 4
%a = load i32 %d, %o invariant
%b = load i32 %d, %o
%c = load i32 %p, %o invariant
%e = load i32 %w, %o invariant stride 4
%f = iadd i32 %a, %c
%l = lane i32
%m = unpack_mask b1 %b
%n = ballot i32 %m
%q = quad_swizzle i32 %f, 0
%u = ult b1 %a, %c
%i = if %u {
  yield %a, %l
} else {
  yield %c, %a
}
%r = result i32 %i, 0
%s = result i32 %i, 1
%j = if %m {
  yield %a
} else {
  yield %a
}
%t = result i32 %j, 0
%x = loop %a, %a, %o {
  %y = loop_arg i32 0
  %z = loop_arg i32 1
  %k = loop_arg i32 2
  %v = iadd i32 %y, %k
  %g = ult b1 %v, %f
  yield %g, %v, %l, %z
}
%aa = loop %a {
  %ab = loop_arg i32 0
  %ac = iadd i32 %ab, %o
  %ad = ult b1 %ac, %f
  yield %ad, %ac
}
)",
                                      rates);
  EXPECT_EQ(out, R"(wave:
  %1 = draw_ptr ptr @draw
  %2 = prim_ptr ptr @prim
  %3 = wave_ptr ptr @wave
  %4 = const i32 4 @draw
  %5 = load i32 %1, %4 invariant @draw
  %6 = load i32 %1, %4 @wave
  %7 = load i32 %2, %4 invariant @prim
  %8 = load i32 %3, %4 stride 4 invariant
  %9 = iadd i32 %5, %7 @prim
  %10 = lane i32
  %11 = unpack_mask b1 %6
  %12 = ballot i32 %11 @wave
  %13 = quad_swizzle i32 %9, 0 @prim
  %14 = ult b1 %5, %7 @prim
  %15 = if %14 @wave {
    yield %5, %10
  } else {
    yield %7, %5
  }
  %16 = result i32 %15, 0 @wave
  %17 = result i32 %15, 1
  %18 = if %11 {
    yield %5
  } else {
    yield %5
  }
  %19 = result i32 %18, 0
  %20 = loop %5, %5, %4 {
    %21 = loop_arg i32 0
    %22 = loop_arg i32 1
    %23 = loop_arg i32 2
    %24 = iadd i32 %21, %23
    %25 = ult b1 %24, %9
    yield %25, %24, %10, %22
  }
  %26 = loop %5 @wave {
    %27 = loop_arg i32 0 @wave
    %28 = iadd i32 %27, %4 @wave
    %29 = ult b1 %28, %9 @wave
    yield %29, %28
  }
)");
}

TEST(Hoist, MovesWhatLanesCannotChange) {
  const std::string out = run_on_text(R"(%w = wave_ptr ptr
%l = lane i32
%o = const i32 4
%c = ult b1 %l, %o
%i = if %c {
  %d = draw_ptr ptr
  %p = prim_ptr ptr
  %a = load i32 %d, %o invariant speculate
  %b = load i32 %p, %o limit %a invariant
  %e = load i32 %d, %o invariant
  %f = load i32 %d, %o speculate
  %g = iadd i32 %b, %a
  %q = quad_swizzle i32 %g, 0
  %s = iadd i32 %e, %f
  %t = iadd i32 %q, %s
  store %w, %l, %t
  yield
} else {
  yield
}
)",
                                      hoist);
  EXPECT_EQ(out, R"(draw:
  %1 = const i32 4
  %2 = draw_ptr ptr
  %3 = load i32 %2, %1 invariant speculate
prim:
  %4 = prim_ptr ptr
  %5 = load i32 %4, %1 limit %3 invariant
  %6 = iadd i32 %5, %3
wave:
  %7 = wave_ptr ptr
  %8 = lane i32
  %9 = ult b1 %8, %1
  %10 = if %9 {
    %11 = load i32 %2, %1 invariant
    %12 = load i32 %2, %1 speculate
    %13 = iadd i32 %11, %12
    %14 = iadd i32 %6, %13
    store %7, %8, %14
    yield
  } else {
    yield
  }
)");
}

TEST(HoistLoops, MovesToTheOutermostLoopThatAllowsIt) {
  const std::string out = run_on_text(R"(%p = wave_ptr ptr
%l = lane i32
%u = loop %l {
  %i = loop_arg i32 0
  %c = ult b1 %i, %l
  %j = if %c {
    %a = iadd i32 %l, %l
    %x = load i32 %p, %a invariant speculate
    %y = load i32 %p, %a invariant
    %b = imul i32 %i, %a
    %v = loop {
      %d = isub i32 %b, %a
      %e = xor i32 %d, %x
      store %p, %e, %y
      yield %c
    }
    yield %a
  } else {
    yield %l
  }
  %r = result i32 %j, 0
  yield %c, %r
}
)",
                                      hoist_loops);
  EXPECT_EQ(out, R"(wave:
  %1 = wave_ptr ptr
  %2 = lane i32
  %3 = iadd i32 %2, %2
  %4 = load i32 %1, %3 invariant speculate
  %5 = loop %2 {
    %6 = loop_arg i32 0
    %7 = ult b1 %6, %2
    %8 = if %7 {
      %9 = load i32 %1, %3 invariant
      %10 = imul i32 %6, %3
      %11 = isub i32 %10, %3
      %12 = xor i32 %11, %4
      %13 = loop {
        store %1, %12, %9
        yield %7
      }
      yield %3
    } else {
      yield %2
    }
    %14 = result i32 %8, 0
    yield %7, %14
  }
)");
}

}  // namespace
}  // namespace pineda::passes
