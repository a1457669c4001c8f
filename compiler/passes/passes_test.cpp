// Each pass on small kernels, as text. That passes keep the bits of whole kernels is tested in random_test.cpp.
#include "compiler/passes/passes.h"

#include <gtest/gtest.h>

#include <functional>

#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using Pass = std::function<void(ir::Kernel&)>;

// Runs the pass on a wave region and gives the regions that are not empty, as text.
std::string after(const std::string& wave, const Pass& pass) {
  ir::ParseResult parsed = ir::parse("kernel compute \"t\" stride 8\nwave:\n" + wave);
  EXPECT_EQ(parsed.error, "");
  EXPECT_EQ(ir::verify(parsed.kernel), "");
  pass(parsed.kernel);
  EXPECT_EQ(ir::verify(parsed.kernel), "") << ir::print(parsed.kernel);
  for (ir::RegionId* root : {&parsed.kernel.draw, &parsed.kernel.prim}) {
    if (parsed.kernel.regions[*root].insts.empty()) *root = 0;
  }
  const std::string text = ir::print(parsed.kernel);
  return text.substr(text.find('\n') + 1);
}

const Pass kFold = [](ir::Kernel& k) {
  fold(k);
  dce(k);
};

// Text of a wave that stores %v, to keep it alive.
std::string stored(const std::string& body) {
  return "%p = wave_ptr ptr\n%o = const i32 0\n%x = load i32 %p, %o\n%f = load f32 %p, %o\n" + body + "store %p, %o, %v\n";
}

// What fold makes of the %v of `body`, without the four lines in front of it and the store.
std::string folded(const std::string& body) {
  const std::string text = after(stored(body), kFold);
  const auto begin = text.find("wave_ptr ptr\n") + 13;
  return text.substr(begin);
}

TEST(Ssa, IfAndLoopMakeResultsAndCarriedValues) {
  const std::string out = after(R"(%a = local i32 1
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

}  // namespace
}  // namespace pineda::passes
