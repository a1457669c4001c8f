// Control flow: every shader computes d[lane] on 16 lanes; the same function in C++ is the oracle, so the numbers are exact.
#include "compiler/spirv/test_shaders.h"

#pragma GCC diagnostic ignored "-Wimplicit-fallthrough"  // wanted

namespace pineda::spirv::test {
namespace {

const Words kLaneNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

// Runs `body` (GLSL over `uint x`, the lane's number, writing `uint r`) and compares r with `oracle`.
void check(const std::string& body, uint32_t (*oracle)(uint32_t), const std::string& globals = "") {
  const std::string function = globals + "\nvoid body(uint x, inout uint r) {\n" + body + "\n}\n";
  const Words out = compute("uint r = 0u; body(d[lane], r); d[lane] = r;", kLaneNumbers, "uint", function);
  for (uint32_t x = 0; x < 16; ++x) EXPECT_EQ(out[x], oracle(x)) << "x = " << x << "\n" << body;
}

// Pastes one text into the shader and into C++.
#define SAME_IN_BOTH(...)                  \
  check(#__VA_ARGS__, [](uint32_t x) {     \
    uint32_t r = 0;                        \
    const auto body = [&] { __VA_ARGS__ }; \
    body();                                \
    return r;                              \
  })
using uint = uint32_t;

TEST(SpirvFlow, IfElse) { SAME_IN_BOTH(if (x > 7u) r = 1u; else if (x > 3u) r = 2u; else r = x + 10u;); }

TEST(SpirvFlow, LoopsCountPerLane) {
  SAME_IN_BOTH(for (uint i = 0u; i < x; ++i) r += i * i;);
  SAME_IN_BOTH(do {
    r += x;
    x >>= 1;
  } while (x > 2u););
  SAME_IN_BOTH(while (x != 0u) {
    x = x & (x - 1u);
    ++r;
  });
}

TEST(SpirvFlow, SeveralExits) {
  SAME_IN_BOTH(for (uint i = 0u; i < 20u; ++i) {
    if (i == x) break;
    r += 1u;
    if (r * i > 30u) break;
    if ((i & 1u) == 1u) continue;
    r += 100u;
  });
}

TEST(SpirvFlow, BreakOutOfNestedLoops) {
  SAME_IN_BOTH(for (uint i = 0u; i < 6u; ++i) {
    bool stop = false;
    for (uint j = 0u; j < 6u; ++j) {
      if (i * j == x) {
        stop = true;
        break;
      }
      if (j > i) {
        r += 1000u;
        continue;
      }
      r += i + j;
      for (uint k = 0u;; ++k) {
        if (k == j) break;
        r ^= k << 4u;
      }
    }
    if (stop) break;
    r += 7u;
  });
}

TEST(SpirvFlow, SwitchFallsThrough) {
  SAME_IN_BOTH(switch (x) {
    case 0u:
      r = 5u;
      break;
    case 1u:
      r += 1u;
    case 2u:
      r += 2u;
    case 3u:
      r += 3u;
      break;
    case 4u:
    case 5u:
      r = 45u;
    default:
      r += 1000u;
    case 6u:
      r += 6u;
      break;
    case 9u:
      if (r == 0u) {
        r = 9u;
        break;
      }
      r = 8u;
    case 10u:
      r += 10u;
  });
}

TEST(SpirvFlow, SwitchInLoopContinues) {
  SAME_IN_BOTH(for (uint i = 0u; i < 10u; ++i) {
    switch ((i + x) % 5u) {
      case 0u:
        continue;
      case 1u:
        r += 1u;
        break;
      case 2u:
        if (i > 5u) continue;
        r += 20u;
      case 3u: {
        for (uint j = 0u; j < 3u; ++j) {
          if (j == x % 3u) break;
          r += j;
        }
        break;
      }
      default:
        switch (x & 3u) {
          case 0u:
            r += 3u;
          case 1u:
            r += 5u;
            break;
          default:
            continue;
        }
    }
    r *= 3u;
  });
}

TEST(SpirvFlow, EarlyReturns) {
  SAME_IN_BOTH(
      if (x == 3u) {
        r = 33u;
        return;
      } r = 1u;
      if (x > 10u) {
        if (x == 12u) {
          r = 12u;
          return;
        }
        r += 2u;
      } r += 4u;);
  check(
      "r = f(x) + f(x + 1u) * 100u;",
      [](uint32_t x) {
        const auto f = [](uint32_t y) {
          for (uint32_t i = 0; i < 8; ++i) {
            for (uint32_t j = 0; j < 8; ++j) {
              if (i * 8 + j == y * 3) return i + 10 * j;
            }
            if (i == 5) return 77u;
          }
          return 99u;
        };
        return f(x) + f(x + 1) * 100;
      },
      "uint f(uint y) { for (uint i = 0u; i < 8u; ++i) { for (uint j = 0u; j < 8u; ++j) { if (i * 8u + j == y * 3u) return i + "
      "10u * j; }"
      " if (i == 5u) return 77u; } return 99u; }");
}

TEST(SpirvFlow, FunctionsWithReferences) {
  check(
      "uint a[4] = uint[](1u, 2u, 3u, x); for (uint i = 0u; i < 3u; ++i) twice(a[i], r); g(r, a); r += a[x & 3u];",
      [](uint32_t x) {
        uint32_t r = 0, a[4] = {1, 2, 3, x};
        for (uint32_t i = 0; i < 3; ++i) {
          a[i] *= 2;
          r += a[i];
        }
        a[1] += r;
        r += a[3];
        return r + a[x & 3];
      },
      "void twice(inout uint v, inout uint sum) { v *= 2u; sum += v; } void g(inout uint s, inout uint b[4]) { b[1] += s; s += "
      "b[3]; }");
}

TEST(SpirvFlow, ShortCircuit) {
  check(
      "if (x > 2u && f(r) || x == 0u) r += 50u;",
      [](uint32_t x) {
        uint32_t r = 0;
        const auto f = [&] {
          r += 1;
          return x % 2 == 0;
        };
        if ((x > 2 && f()) || x == 0) r += 50;
        return r;
      },
      "bool f(inout uint s) { s += 1u; return (gl_LocalInvocationIndex & 1u) == 0u; }");
}

// ---- SPIR-V that GLSL compilers do not write ----

// A compute shader in assembly: %x is the lane, blocks must end in %store_block, with %result in scope there.
Words blocks(const std::string& text) {
  return assembly(R"(
OpCapability Shader
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %index
OpExecutionMode %main LocalSize 16 1 1
%file = OpString "debug lines may stand between phis"
OpDecorate %index BuiltIn LocalInvocationIndex
OpDecorate %array ArrayStride 4
OpMemberDecorate %block 0 Offset 0
OpDecorate %block BufferBlock
OpDecorate %data DescriptorSet 0
OpDecorate %data Binding 0
%void = OpTypeVoid
%fn = OpTypeFunction %void
%uint = OpTypeInt 32 0
%bool = OpTypeBool
%array = OpTypeRuntimeArray %uint
%block = OpTypeStruct %array
%p_block = OpTypePointer Uniform %block
%p_uint = OpTypePointer Uniform %uint
%p_in = OpTypePointer Input %uint
%data = OpVariable %p_block Uniform
%index = OpVariable %p_in Input
%c0 = OpConstant %uint 0
%c1 = OpConstant %uint 1
%c2 = OpConstant %uint 2
%c3 = OpConstant %uint 3
%c7 = OpConstant %uint 7
%main = OpFunction %void None %fn
%entry = OpLabel
%x = OpLoad %uint %index
)" + text + R"(
%p = OpAccessChain %p_uint %data %c0 %x
OpStore %p %result
OpReturn
OpFunctionEnd
)");
}

void check_blocks(const std::string& text, uint32_t (*oracle)(uint32_t)) {
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  stage.buffers[0].words = kLaneNumbers;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, blocks(text)), "");
  for (uint32_t x = 0; x < 16; ++x) EXPECT_EQ(stage.buffers[0].words[x], oracle(x)) << "x = " << x;
}

TEST(SpirvFlow, PhisOfALoopAreAssignedAtOnce) {  // a, b = b, a + b: Fibonacci
  check_blocks(R"(
OpBranch %head
%head = OpLabel
%a = OpPhi %uint %c0 %entry %b %next
OpLine %file 1 1
%b = OpPhi %uint %c1 %entry %sum %next
OpNoLine
%i = OpPhi %uint %c0 %entry %i1 %next
%go = OpULessThan %bool %i %x
OpLoopMerge %done %next None
OpBranchConditional %go %next %done
%next = OpLabel
%sum = OpIAdd %uint %a %b
%i1 = OpIAdd %uint %i %c1
OpBranch %head
%done = OpLabel
%result = OpPhi %uint %a %head
)",
               [](uint32_t x) {
                 uint32_t a = 0, b = 1;
                 for (uint32_t i = 0; i < x; ++i) {
                   const uint32_t s = a + b;
                   a = b;
                   b = s;
                 }
                 return a;
               });
}

TEST(SpirvFlow, ValuesOutliveTheirLoopAndBranch) {  // %v and %w dominate their uses but stand in inner regions
  check_blocks(R"(
OpBranch %head
%head = OpLabel
%i = OpPhi %uint %c0 %entry %i1 %next
OpLoopMerge %done %next None
OpBranch %body
%body = OpLabel
%v = OpIMul %uint %i %c7
%odd = OpBitwiseAnd %uint %i %c1
%is_odd = OpIEqual %bool %odd %c1
OpSelectionMerge %joined None
OpBranchConditional %is_odd %odd_side %even_side
%odd_side = OpLabel
%at_x = OpUGreaterThanEqual %bool %i %x
OpBranchConditional %at_x %done %joined
%even_side = OpLabel
OpBranch %joined
%joined = OpLabel
%w = OpIAdd %uint %v %x
%far = OpUGreaterThan %bool %w %x
%past = OpUGreaterThan %bool %i %x
%both = OpLogicalAnd %bool %far %past
OpBranchConditional %both %done %next
%next = OpLabel
%i1 = OpIAdd %uint %i %c1
OpBranch %head
%done = OpLabel
%result = OpIAdd %uint %v %i
)",
               [](uint32_t x) {
                 for (uint32_t i = 0;; ++i) {
                   if (i % 2 == 1 && i >= x) return 8 * i;
                   if (7 * i + x > x && i > x) return 8 * i;
                 }
               });
}

TEST(SpirvFlow, SingleBlockLoop) {
  check_blocks(R"(
OpBranch %loop
%loop = OpLabel
%i = OpPhi %uint %c0 %entry %i1 %loop
%s = OpPhi %uint %c3 %entry %s1 %loop
%i1 = OpIAdd %uint %i %c1
%s1 = OpIMul %uint %s %c3
%go = OpULessThan %bool %i1 %x
OpLoopMerge %done %loop None
OpBranchConditional %go %loop %done
%done = OpLabel
%result = OpIAdd %uint %s1 %i1
)",
               [](uint32_t x) {
                 uint32_t i = 0, s = 3;
                 do {
                   ++i;
                   s *= 3;
                 } while (i < x);
                 return s + i;
               });
}

TEST(SpirvFlow, ContinueFromANestedSwitchAndConditionalBackEdge) {
  check_blocks(R"(
OpBranch %head
%head = OpLabel
%i = OpPhi %uint %c0 %entry %i1 %next
%s = OpPhi %uint %c0 %entry %s1 %next
OpLoopMerge %done %next None
OpBranch %body
%body = OpLabel
%kind = OpUMod %uint %i %c3
OpSelectionMerge %joined None
OpSwitch %kind %other 0 %zero 1 %next
%zero = OpLabel
%s_zero = OpIAdd %uint %s %x
OpBranch %joined
%other = OpLabel
%s_other = OpIAdd %uint %s %c7
%big = OpUGreaterThan %bool %s_other %x
OpBranchConditional %big %done %joined
%joined = OpLabel
%s_joined = OpPhi %uint %s_zero %zero %s_other %other
OpBranch %next
%next = OpLabel
%s1 = OpPhi %uint %s %body %s_joined %joined
%i1 = OpIAdd %uint %i %c1
%go = OpULessThan %bool %i1 %c7
OpBranchConditional %go %head %done
%done = OpLabel
%result = OpPhi %uint %s_other %other %s1 %next
)",
               [](uint32_t x) {
                 uint32_t s = 0, i = 0;
                 do {
                   if (i % 3 == 0)
                     s += x;
                   else if (i % 3 == 2) {
                     s += 7;
                     if (s > x) return s;
                   }
                   ++i;
                 } while (i < 7);
                 return s;
               });
}

TEST(SpirvFlow, RefusesWhatIsNotStructured) {
  FakeStage stage;
  stage.buffers[0].words = kLaneNumbers;
  // Two ways into one block that is nobody's merge block.
  const Words shared = blocks(R"(
%even = OpULessThan %bool %x %c3
OpSelectionMerge %end None
OpBranchConditional %even %a %b
%a = OpLabel
OpBranch %c
%b = OpLabel
OpBranch %c
%c = OpLabel
OpBranch %end
%end = OpLabel
%result = OpCopyObject %uint %x
)");
  EXPECT_NE(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, shared).find("not structured"), std::string::npos);
  // A cycle without OpLoopMerge.
  const Words cycle = blocks(R"(
OpBranch %a
%a = OpLabel
%c = OpULessThan %bool %x %c3
OpSelectionMerge %end None
OpBranchConditional %c %a %end
%end = OpLabel
%result = OpCopyObject %uint %x
)");
  EXPECT_NE(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, cycle).find("not structured"), std::string::npos);
}

TEST(SpirvFlow, RefusesRecursion) {
  const Words words = assembly(R"(
OpCapability Shader
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main"
OpExecutionMode %main LocalSize 1 1 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
%main = OpFunction %void None %fn
%a = OpLabel
%r = OpFunctionCall %void %f
OpReturn
OpFunctionEnd
%f = OpFunction %void None %fn
%b = OpLabel
%s = OpFunctionCall %void %f
OpReturn
OpFunctionEnd
)");
  FakeStage stage;
  EXPECT_NE(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words).find("recursion"), std::string::npos);
}

// Hundreds of early exits of each kind: they do not nest, so there is no limit on their number.
TEST(SpirvFlow, ManyEarlyExits) {
  constexpr uint32_t kExits = 600;
  std::string returns, loop;
  for (uint32_t i = 0; i < kExits; ++i) {
    const std::string k = std::to_string(i);
    returns += "uint v" + k + " = r + " + k + "u; if ((r ^ x) % 997u == " + k + "u) return v" + k + " + 5000u; r = r * 5u + v" +
               k + ";\n";
    loop += "r = r * 3u + i; if (r % 389u == " + k + "u) " +
            (i % 3 == 0   ? "continue"
             : i % 3 == 1 ? "break"
                          : "return r") +
            ";\n";
  }
  const std::string functions = "uint f(uint x) { uint r = x;\n" + returns + "return r; }\n" +
                                "uint g(uint x) { uint r = x + 7u; for (uint i = 0u; i < 5u; ++i) {\n" + loop +
                                "} return r + 1u; }\n";
  const Words out = compute("d[lane] = f(lane); d[lane + 16u] = g(lane);", Words(32), "uint", functions);
  for (uint32_t x = 0; x < 16; ++x) {
    const auto f = [&] {
      uint32_t r = x;
      for (uint32_t i = 0; i < kExits; ++i) {
        const uint32_t v = r + i;
        if ((r ^ x) % 997 == i) return v + 5000;
        r = r * 5 + v;
      }
      return r;
    };
    const auto g = [&] {
      uint32_t r = x + 7;
      for (uint32_t i = 0; i < 5; ++i) {
        bool left = false;
        for (uint32_t k = 0; k < kExits && !left; ++k) {
          r = r * 3 + i;
          if (r % 389 != k) continue;
          if (k % 3 == 2) return r;
          if (k % 3 == 1) return r + 1;
          left = true;
        }
      }
      return r + 1;
    };
    EXPECT_EQ(out[x], f()) << x;
    EXPECT_EQ(out[16 + x], g()) << x;
  }
}

// As deep as SPIR-V lets constructs nest (2.17, universal limits).
TEST(SpirvFlow, DeepNests) {
  constexpr uint32_t kDepth = 1000;
  std::string body = "uint r = lane;";
  for (uint32_t i = 0; i < kDepth; ++i)
    body += "if (r % " + std::to_string(i % 7 + 2) + "u != 9u) { r += " + std::to_string(i) + "u;\n";
  const Words out = compute(body + std::string(kDepth, '}') + " d[lane] = r;", Words(16));
  for (uint32_t x = 0; x < 16; ++x) EXPECT_EQ(out[x], x + kDepth * (kDepth - 1) / 2);
}

// More of them than constructs may nest: each goes on beside the one before, not inside of it.
TEST(SpirvFlow, ThousandsOfEarlyReturns) {
  constexpr uint32_t kReturns = 3000;
  std::string function = "uint f(uint x) {\n";
  for (uint32_t i = 0; i < kReturns; ++i) {
    const std::string n = std::to_string(i);
    function += "if (x == " + n + "u * 37u) return x + " + n + "u; x += " + n + "u & 3u;\n";
  }
  const Words out = compute("d[lane] = f(lane);", Words(16), "uint", function + "return x; }");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    uint32_t x = lane;
    bool returned = false;
    for (uint32_t i = 0; i < kReturns && !returned; ++i) {
      returned = x == i * 37;
      x += returned ? i : i & 3;
    }
    EXPECT_EQ(out[lane], x) << lane;
  }
}

}  // namespace
}  // namespace pineda::spirv::test
