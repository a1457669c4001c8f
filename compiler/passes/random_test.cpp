// Passes keep the bits: random kernels store the same before and after.
#include <gtest/gtest.h>

#include <functional>

#include "compiler/eval/eval.h"
#include "compiler/ir/random_kernel.h"
#include "compiler/passes/passes.h"

namespace pineda::passes {
namespace {

constexpr uint64_t kFirstSeed = 1, kSeeds = 300;

struct NamedPass {
  const char* name;
  void (*run)(ir::Kernel&);
};

// Every pass that keeps bits, alone and in optimize()'s order. fuse_fma is left out: it defines them.
const NamedPass kPasses[] = {
    {"ssa", ssa},
    {"dce", dce},
    {"fold", [](ir::Kernel& k) { fold(k); }},
    {"cse", cse},
    {"hoist", hoist},
    {"hoist_loops", hoist_loops},
    {"rates", rates},
    {"unroll",
     [](ir::Kernel& k) {
       ssa(k);
       dce(k);
       while (unroll(k)) fold(k);
     }},
    {"flatten_ifs",
     [](ir::Kernel& k) {
       ssa(k);  // whose Results make for pure sides
       rates(k);
       flatten_ifs(k);
     }},
    {"narrow_loops",
     [](ir::Kernel& k) {
       ssa(k);
       dce(k);
       rates(k);
       narrow_loops(k);
     }},
    {"all",
     [](ir::Kernel& k) {
       for (const auto& pass : {ssa, dce}) pass(k);
       fold(k);
       ssa(k);
       fold(k);
       for (const auto& pass : {cse, dce, rates, flatten_ifs, narrow_loops}) pass(k);
       fold(k);
       for (const auto& pass : {cse, dce, hoist, hoist_loops, cse, dce, rates}) pass(k);
     }},
};

std::vector<uint8_t> evaluate(ir::RandomKernel& random, const ir::Kernel& kernel, eval::Mode mode = eval::Mode::kF32) {
  return random.run([&](auto... args) { eval::run(kernel, mode, args...); });
}

class RandomKernels : public testing::TestWithParam<NamedPass> {};

TEST_P(RandomKernels, KeepTheirBits) {
  for (uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed) {
    ir::RandomKernel random(seed);
    ir::Kernel kernel = random.kernel();
    GetParam().run(kernel);
    ASSERT_EQ(ir::verify(kernel), "") << "seed " << seed << "\n" << ir::print(kernel);
    ASSERT_EQ(evaluate(random, random.kernel()), evaluate(random, kernel)) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Passes, RandomKernels, testing::ValuesIn(kPasses), [](const auto& info) { return info.param.name; });

// optimize() with fused products equals fuse_fma alone: nothing after it changes bits.
TEST(RandomKernels, OptimizeKeepsWhatFuseFmaDefines) {
  for (uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed) {
    ir::RandomKernel random(seed);
    ir::Kernel fused = random.kernel(), optimized = random.kernel();
    ssa(fused);
    fuse_fma(fused);
    optimize(optimized, Form::kMachine);
    ASSERT_EQ(ir::verify(optimized), "") << "seed " << seed;
    ASSERT_EQ(evaluate(random, fused), evaluate(random, optimized)) << "seed " << seed;
    ASSERT_EQ(ir::print(ir::parse(ir::print(optimized)).kernel), ir::print(optimized)) << "seed " << seed;
  }
}

// The truth is the truth of the kernel as it was built.
TEST(RandomKernels, OptimizeKeepsTheTruth) {
  for (uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed) {
    ir::RandomKernel random(seed, {.transcendentals = true});
    ir::Kernel optimized = random.kernel();
    optimize(optimized, Form::kTruth);
    ASSERT_EQ(ir::verify(optimized), "") << "seed " << seed;
    ASSERT_EQ(evaluate(random, random.kernel(), eval::Mode::kF64), evaluate(random, optimized, eval::Mode::kF64))
        << "seed " << seed;
  }
}

TEST(RandomKernels, DryRunEqualsRun) {
  for (uint64_t seed = kFirstSeed; seed < kFirstSeed + 50; ++seed) {
    ir::RandomKernel random(seed);
    std::vector<eval::WrittenByte> written;
    const uint8_t* output = nullptr;
    auto dry = random.run([&](const void* draw, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
      output = *static_cast<uint8_t* const*>(thread);
      written = eval::dry_run(random.kernel(), draw, thread, prims, count, waves);
    });
    for (const eval::WrittenByte& byte : written) {
      const uint64_t index = byte.address - reinterpret_cast<uint64_t>(output);
      ASSERT_LT(index, dry.size());
      dry[index] = byte.value;
    }
    ASSERT_EQ(dry, evaluate(random, random.kernel())) << "seed " << seed;
  }
}

}  // namespace
}  // namespace pineda::passes
