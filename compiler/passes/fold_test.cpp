// passes/fold on small kernels, as text.
#include <gtest/gtest.h>

#include "compiler/passes/passes.h"
#include "compiler/passes/test_text.h"

namespace pineda::passes {
namespace {

// What fold and dce make of `body`, whose %v is stored. Unknown values: %x, %y (i32), %f, %g (f32), %h (f16), %c (b1). Gives the
// instructions after the sources, with the sources under these names.
std::string folded(const std::string& body) {
  static const std::string kSources = R"(%p = wave_ptr ptr
%o = const i32 4
%x = load i32 %p, %o
%y = load i32 %p, %o stride 4
%f = load f32 %p, %o
%g = load f32 %p, %o stride 4
%h = load f16 %p, %o
%c = ult b1 %x, %y
%k = zext i32 %c
store %p, %o, %x
store %p, %o, %y
store %p, %o, %f
store %p, %o, %g
store %p, %o, %h
store %p, %o, %k
)";
  const bool is_b1 = body.find("%v = not b1") != std::string::npos || body.find("%v = ieq") != std::string::npos ||
                     body.find("%v = ine") != std::string::npos || body.find("%v = select b1") != std::string::npos;
  const std::string store = is_b1 ? "%w = zext i32 %v\nstore %p, %o, %w\n" : "store %p, %o, %v\n";
  std::string text = run_on_text(kSources + body + store, [](ir::Kernel& k) {
    fold(k);
    dce(k);
  });
  for (int i = 0; i < 6; ++i) text = text.substr(text.find("store") + 5);  // past the stores that keep the sources alive
  text = text.substr(text.find('\n') + 1);
  const std::string names = "poxyfghck";
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string number = "%" + std::to_string(i + 1);
    for (size_t at = 0; (at = text.find(number, at)) != std::string::npos; ++at) {
      const bool whole = at + number.size() >= text.size() || !isdigit(static_cast<unsigned char>(text[at + number.size()]));
      if (whole) text.replace(at, number.size(), std::string("%") + names[i]);
    }
  }
  return text;
}

struct Case {
  const char *body, *expected;
};

void expect_all(std::initializer_list<Case> cases) {
  for (const Case& c : cases) EXPECT_EQ(folded(c.body), c.expected) << c.body;
}

TEST(Fold, Integers) {
  expect_all({
      {"%z = const i32 0\n%v = iadd i32 %z, %x\n", "  store %p, %o, %x\n"},
      {"%a = const i32 5\n%s = iadd i32 %x, %a\n%v = iadd i32 %s, %a\n",
       "  %10 = const i32 10\n  %11 = iadd i32 %x, %10\n  store %p, %o, %11\n"},
      {"%a = const i32 5\n%v = isub i32 %x, %a\n",
       "  %10 = const i32 0xfffffffb\n  %11 = iadd i32 %x, %10\n  store %p, %o, %11\n"},
      {"%v = isub i32 %x, %x\n", "  %10 = const i32 0\n  store %p, %o, %10\n"},
      {"%n = not i32 %x\n%v = not i32 %n\n", "  store %p, %o, %x\n"},
      {"%n = not i32 %x\n%v = and i32 %n, %x\n", "  %10 = const i32 0\n  store %p, %o, %10\n"},
      {"%v = umin i32 %x, %x\n", "  store %p, %o, %x\n"},
      {"%a = const i32 0\n%v = imul i32 %x, %a\n", "  %10 = const i32 0\n  store %p, %o, %10\n"},
      {"%a = const i32 64\n%v = shl i32 %x, %a\n", "  store %p, %o, %x\n"},
      {"%n = zext i64 %x\n%v = trunc i32 %n\n", "  store %p, %o, %x\n"},
  });
}

TEST(Fold, Floats) {
  expect_all({
      {"%a = const f32 1\n%v = fmul f32 %a, %f\n", "  store %p, %o, %f\n"},
      {"%a = const f32 -1\n%v = fmul f32 %f, %a\n", "  %10 = fneg f32 %f\n  store %p, %o, %10\n"},
      {"%a = const f32 0\n%v = fsub f32 %f, %a\n", "  store %p, %o, %f\n"},
      {"%a = const f32 -0\n%v = fadd f32 %f, %a\n", "  store %p, %o, %f\n"},
      {"%a = const f32 4\n%v = fdiv f32 %f, %a\n",
       "  %10 = const f32 0.25\n  %11 = fmul f32 %f, %10 no_contract\n  store %p, %o, %11\n"},
      {"%a = const f32 1\n%v = fma f32 %a, %f, %g\n", "  %10 = fadd f32 %f, %g no_contract\n  store %p, %o, %10\n"},
      {"%n = fneg f32 %f\n%v = fabs f32 %n\n", "  %10 = fabs f32 %f\n  store %p, %o, %10\n"},
      {"%n = fcanon f32 %f\n%v = fcanon f32 %n\n", "  %10 = fcanon f32 %f\n  store %p, %o, %10\n"},
      {"%n = bitcast i32 %f\n%v = bitcast f32 %n\n", "  store %p, %o, %f\n"},
      {"%n = fconvert f32 %h\n%v = fconvert f16 %n\n", "  store %p, %o, %h\n"},
  });
}

TEST(Fold, LeavesWhatWouldChangeBits) {
  expect_all({
      {"%a = const f32 0\n%v = fadd f32 %f, %a\n",  // turns -0 into +0
       "  %10 = const f32 0\n  %11 = fadd f32 %f, %10\n  store %p, %o, %11\n"},
      {"%a = const f32 0\n%v = fmul f32 %f, %a\n",  // NaN, infinity, -0
       "  %10 = const f32 0\n  %11 = fmul f32 %f, %10\n  store %p, %o, %11\n"},
      {"%v = fsub f32 %f, %f\n", "  %10 = fsub f32 %f, %f\n  store %p, %o, %10\n"},
      {"%a = const f32 3\n%v = fdiv f32 %f, %a\n", "  %10 = const f32 3\n  %11 = fdiv f32 %f, %10\n  store %p, %o, %11\n"},
      {"%a = const f32 1e-40\n%v = fdiv f32 %f, %a\n",  // 1 / a overflows
       "  %10 = const f32 1e-40\n  %11 = fdiv f32 %f, %10\n  store %p, %o, %11\n"},
      {"%n = flt b1 %f, %g\n%v = not b1 %n\n",  // fle %g, %f differs on NaN
       "  %10 = flt b1 %f, %g\n  %11 = not b1 %10\n  %12 = zext i32 %11\n  store %p, %o, %12\n"},
      {"%n = fconvert f16 %f\n%v = fconvert f32 %n\n",  // rounds
       "  %10 = fconvert f16 %f\n  %11 = fconvert f32 %10\n  store %p, %o, %11\n"},
  });
}

TEST(Fold, Conditions) {
  const char* const kStoreC = "  %10 = zext i32 %c\n  store %p, %o, %10\n";
  expect_all({
      {"%n = zext i32 %c\n%z = const i32 0\n%v = ine b1 %n, %z\n", kStoreC},
      {"%a = const i32 7\n%b = const i32 9\n%n = select i32 %c, %a, %b\n%v = ieq b1 %n, %a\n", kStoreC},
      {"%t = const b1 true\n%e = const b1 false\n%v = select b1 %c, %t, %e\n", kStoreC},
      {"%v = select i32 %c, %x, %x\n", "  store %p, %o, %x\n"},
      {"%n = not b1 %c\n%v = select i32 %n, %x, %y\n", "  %10 = select i32 %c, %y, %x\n  store %p, %o, %10\n"},
  });
}

TEST(Fold, Memory) {
  expect_all({
      {"%l = const i32 8\n%a = const i32 0\n%v = load i32 %p, %a limit %l\n",  // the check holds
       "  %10 = const i32 0\n  %11 = load i32 %p, %10 speculate\n  store %p, %o, %11\n"},
      {"%l = const i32 63\n%a = const i32 0\n%v = load i32 %p, %a limit %l stride 4\n",  // but not for lane 15
       "  %10 = const i32 63\n  %11 = const i32 0\n  %12 = load i32 %p, %11 limit %10 stride 4\n  store %p, %o, %12\n"},
      {"%l = const i32 8\n%a = const i32 6\n%v = load i32 %p, %a limit %l\n", "  %10 = const i32 0\n  store %p, %o, %10\n"},
      {"%a = const i32 8\n%q = ptr_add ptr %p, %a\n%r = ptr_add ptr %q, %a\n%v = load i32 %r, %o\n",
       "  %10 = const i64 16\n  %11 = ptr_add ptr %p, %10\n  %12 = load i32 %11, %o\n  store %p, %o, %12\n"},
  });
}

TEST(Fold, RoundsEachOperationToItsType) {
  // 2^24 + 1 is 2^24 in binary32
  EXPECT_EQ(folded("%a = const f32 16777216\n%b = const f32 1\n%s = fadd f32 %a, %b\n%v = fsub f32 %s, %a\n"),
            "  %10 = const f32 0\n  store %p, %o, %10\n");
  // constants are doubles that round on use: 0.1 + 0.2 in binary32
  EXPECT_EQ(folded("%a = const f32 0.1\n%b = const f32 0.2\n%v = fadd f32 %a, %b\n"),
            "  %10 = const f32 0.30000001192092896\n  store %p, %o, %10\n");
}

TEST(Fold, TheTruthRoundsNothing) {
  const std::string text = run_on_text(
      "%p = wave_ptr ptr\n%o = const i32 0\n%a = const f32 16777216\n%b = const f32 1\n%s = fadd f32 %a, %b\n%v = fsub f32 %s, "
      "%a\n"
      "store %p, %o, %v\n",
      [](ir::Kernel& k) {
        fold(k, Form::kTruth);
        dce(k);
      });
  EXPECT_NE(text.find("const f32 1\n"), std::string::npos) << text;
}

TEST(Fold, DecidedIfsFallOut) {
  EXPECT_EQ(
      folded("%t = const b1 false\n%i = if %t {\n%a = iadd i32 %x, %x\nyield %a\n} else {\n%b = imul i32 %x, %y\nyield %b\n}\n"
             "%v = result i32 %i, 0\n"),
      "  %10 = imul i32 %x, %y\n  store %p, %o, %10\n");
}

TEST(Fold, ResultsThatNeedNoIfBecomeSelects) {
  const std::string text = folded("%i = if %c {\n%a = const i32 1\nyield %a\n} else {\nyield %x\n}\n%v = result i32 %i, 0\n");
  EXPECT_EQ(text, "  %10 = const i32 1\n  %11 = select i32 %c, %10, %x\n  store %p, %o, %11\n");
}

TEST(Fold, AConditionIsKnownInsideItsIf) {
  const std::string text = folded(R"(%i = if %c {
%j = if %c {
%a = imul i32 %x, %y
yield %a
} else {
%b = iadd i32 %x, %y
yield %b
}
%r = result i32 %j, 0
yield %r
} else {
%s = select i32 %c, %x, %y
%d = imul i32 %s, %s
yield %d
}
%v = result i32 %i, 0
)");
  EXPECT_EQ(text, R"(  %10 = if %c {
    %11 = imul i32 %x, %y
    yield %11
  } else {
    %12 = imul i32 %y, %y
    yield %12
  }
  %13 = result i32 %10, 0
  store %p, %o, %13
)");
}

// Where lanes race, the order of the sides shows.
TEST(Fold, SidesThatBothWriteAreNotSwapped) {
  const auto with_else = [](const std::string& otherwise) {
    return folded("%t = flt b1 %f, %g\n%n = not b1 %t\n%i = if %n {\nstore %p, %o, %x\nyield\n} else {\n" + otherwise +
                  "yield\n}\n%v = iadd i32 %x, %y\n");
  };
  EXPECT_EQ(
      with_else("store %p, %o, %y\n").find("  %10 = flt b1 %f, %g\n  %11 = not b1 %10\n  %12 = if %11 {\n    store %p, %o, %x"),
      0u);
  EXPECT_EQ(with_else("").find("  %10 = flt b1 %f, %g\n  %11 = if %10 {\n    yield\n  } else {\n    store %p, %o, %x"), 0u);
}

TEST(Fold, LoopsLoseWhatDoesNotChange) {
  EXPECT_EQ(folded(R"(%l = loop %x, %y {
%a = loop_arg i32 0
%b = loop_arg i32 1
%d = iadd i32 %a, %b
%n = ult b1 %d, %y
yield %n, %d, %b
}
%v = result i32 %l, 0
)"),
            R"(  %10 = loop %x {
    %11 = loop_arg i32 0
    %12 = iadd i32 %11, %y
    %13 = ult b1 %12, %y
    yield %13, %12
  }
  %14 = result i32 %10, 0
  store %p, %o, %14
)");
}

TEST(Fold, ALoopThatRunsOnceIsItsBody) {
  EXPECT_EQ(folded("%e = const b1 false\n%l = loop %x {\n%a = loop_arg i32 0\n%d = iadd i32 %a, %y\nyield %e, %d\n}\n"
                   "%v = result i32 %l, 0\n"),
            "  %10 = iadd i32 %x, %y\n  store %p, %o, %10\n");
}

}  // namespace
}  // namespace pineda::passes
