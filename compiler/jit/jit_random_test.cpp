// Random kernels: the machine code of every ISA leaves the bytes that the evaluator leaves, with and without the passes (rates,
// hoisting and flattened Ifs give the back end different work).
#include "compiler/ir/random_kernel.h"
#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

// Compiling takes most of the time, so few seeds here; PINEDA_RANDOM_SEEDS=N runs more.
uint64_t seed_count() {
  const char* wanted = std::getenv("PINEDA_RANDOM_SEEDS");
  return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 12;
}

void check_seed(uint64_t seed, const ir::Kernel& kernel, ir::RandomKernel& random) {
  const auto expected = random.run([&](auto... args) { eval::run(kernel, eval::Mode::kF32, args...); });
  for (Isa isa : isas()) {
    const Compiled compiled(kernel, {.isa = isa});
    ASSERT_EQ(compiled.code.error, "") << "seed " << seed << " " << isa_name(isa);
    const KernelHandle handle{compiled.code.fn, nullptr};
    const auto got = random.run([&](auto... args) { handle(args...); });
    ASSERT_EQ(first_difference(expected, got), -1) << "seed " << seed << " " << isa_name(isa) << "\n" << ir::print(kernel);
  }
}

TEST(JitRandom, AsBuilt) {
  for (uint64_t seed = 1; seed <= seed_count() && !HasFatalFailure(); ++seed) {
    ir::RandomKernel random(seed, {.statements = 24});
    check_seed(seed, random.kernel(), random);
  }
}

TEST(JitRandom, Optimized) {
  for (uint64_t seed = 1000; seed < 1000 + 2 * seed_count() && !HasFatalFailure(); ++seed) {
    ir::RandomKernel random(seed);
    ir::Kernel kernel = random.kernel();
    passes::optimize(kernel, passes::Form::kMachine);
    check_seed(seed, kernel, random);
  }
}

TEST(JitRandom, OptimizedWithTranscendentals) {
  for (uint64_t seed = 5000; seed < 5000 + seed_count() && !HasFatalFailure(); ++seed) {
    ir::RandomKernel random(seed, {.statements = 24, .other_widths = seed % 2 == 0, .transcendentals = true, .atomics = false});
    ir::Kernel kernel = random.kernel();
    passes::optimize(kernel, passes::Form::kMachine, static_cast<Precision>(seed % 3));
    check_seed(seed, kernel, random);
  }
}

// Barriers at any depth, also where lanes and waves disagree.
TEST(JitRandom, Barriers) {
  for (uint64_t seed = 9000; seed < 9000 + seed_count() && !HasFatalFailure(); ++seed) {
    ir::RandomKernel random(seed, {.statements = 30, .barriers = true});
    ir::Kernel kernel = random.kernel();
    check_seed(seed, kernel, random);
    passes::optimize(kernel, passes::Form::kMachine);
    check_seed(seed, kernel, random);
  }
}

}  // namespace
}  // namespace pineda::jit::test
