// Control flow: every shader computes d[lane] on 16 lanes; the same function in C++ is the oracle, so the numbers are exact.
#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

// Runs `body` (GLSL over `uint x`, the lane's number, writing `uint r`) and compares r with `oracle`.
void check(const std::string& body, uint32_t (*oracle)(uint32_t), const std::string& globals = "") {
  const Words out = compute("uint x = d[lane]; uint r = 0u;\n" + body + "\nd[lane] = r;", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
                            "uint", globals);
  for (uint32_t x = 0; x < 16; ++x) EXPECT_EQ(out[x], oracle(x)) << "x = " << x << "\n" << body;
}

TEST(SpirvFlow, IfElse) {
  check("if (x > 7u) r = 1u; else if (x > 3u) r = 2u; else r = x + 10u;",
        [](uint32_t x) { return x > 7 ? 1 : x > 3 ? 2 : x + 10; });
}

TEST(SpirvFlow, LoopsCountPerLane) {
  check("for (uint i = 0u; i < x; ++i) r += i * i;", [](uint32_t x) {
    uint32_t r = 0;
    for (uint32_t i = 0; i < x; ++i) r += i * i;
    return r;
  });
}

TEST(SpirvFlow, DoWhile) {
  check("do { r += x; x >>= 1; } while (x > 2u);", [](uint32_t x) {
    uint32_t r = 0;
    do { r += x; x >>= 1; } while (x > 2);
    return r;
  });
}

}  // namespace
}  // namespace pineda::spirv::test
