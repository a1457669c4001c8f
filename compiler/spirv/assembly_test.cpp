// Instructions that GLSL compilers do not write, in assembly: relations of both orders, NaN rules, remainders, forms with
// pointers.
#include <cmath>
#include <limits>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

using Pair = std::array<float, 2>;

std::vector<Pair> special_pairs() {
  const float values[] = {0.0f, -0.0f, 1.0f, -1.5f, 2.5f, 0x1p-149f, -0x1p-127f, 3.4e38f, -3.4e38f, kInf, -kInf, kNan};
  std::vector<Pair> out;
  for (float a : values) {
    for (float b : values) out.push_back({a, b});
  }
  return out;
}

struct AssemblyRow {
  const char* op;
  bool (*oracle)(float a, float b);
};
const AssemblyRow kRelations[] = {
    {"OpFOrdEqual", [](float a, float b) { return a == b; }},
    {"OpFUnordEqual", [](float a, float b) { return !(a < b) && !(b < a); }},
    {"OpFOrdNotEqual", [](float a, float b) { return a < b || b < a; }},
    {"OpFUnordNotEqual", [](float a, float b) { return a != b; }},
    {"OpFOrdLessThan", [](float a, float b) { return a < b; }},
    {"OpFUnordLessThan", [](float a, float b) { return !(a >= b); }},
    {"OpFOrdGreaterThan", [](float a, float b) { return a > b; }},
    {"OpFUnordGreaterThan", [](float a, float b) { return !(a <= b); }},
    {"OpFOrdLessThanEqual", [](float a, float b) { return a <= b; }},
    {"OpFUnordLessThanEqual", [](float a, float b) { return !(a > b); }},
    {"OpFOrdGreaterThanEqual", [](float a, float b) { return a >= b; }},
    {"OpFUnordGreaterThanEqual", [](float a, float b) { return !(a < b); }},
};
struct AssemblyFloatRow {
  const char* text;
  float (*oracle)(float a, float b);
};
const AssemblyFloatRow kFloatInstructions[] = {
    {"OpFRem %float %a %b", [](float a, float b) { return a - b * std::trunc(a / b); }},
    {"OpExtInst %float %glsl NMin %a %b", [](float a, float b) { return std::fmin(a, b); }},
    {"OpExtInst %float %glsl NMax %a %b", [](float a, float b) { return std::fmax(a, b); }},
    {"OpExtInst %float %glsl NClamp %a %c0 %c1", [](float a, float) { return std::fmin(std::fmax(a, 0.0f), 1.0f); }},
    {"OpQuantizeToF16 %float %a",
     [](float a, float) {
       if (std::isnan(a) || std::isinf(a) || a == 0) return a;
       if (std::fabs(a) >= 65520) return std::copysign(kInf, a);
       if (std::fabs(a) < 0x1p-14f) return std::copysign(0.0f, a);
       const float unit = std::ldexp(1.0f, std::ilogb(a) - 10);
       return std::nearbyint(a / unit) * unit;
     }},
};

std::string float_assembly(const std::string& body) {
  return R"(
OpCapability Shader
%glsl = OpExtInstImport "GLSL.std.450"
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %index
OpExecutionMode %main LocalSize 16 1 1
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
%float = OpTypeFloat 32
%array = OpTypeRuntimeArray %float
%block = OpTypeStruct %array
%p_block = OpTypePointer Uniform %block
%p_float = OpTypePointer Uniform %float
%p_in = OpTypePointer Input %uint
%data = OpVariable %p_block Uniform
%index = OpVariable %p_in Input
%u0 = OpConstant %uint 0
%u16 = OpConstant %uint 16
%c0 = OpConstant %float 0
%c1 = OpConstant %float 1
%main = OpFunction %void None %fn
%entry = OpLabel
%x = OpLoad %uint %index
%pa = OpAccessChain %p_float %data %u0 %x
%a = OpLoad %float %pa
%x1 = OpIAdd %uint %x %u16
%pb = OpAccessChain %p_float %data %u0 %x1
%b = OpLoad %float %pb
)" + body +
         "OpReturn\nOpFunctionEnd\n";
}

TEST(SpirvAssembly, RelationsAndNanRules) {
  std::string body, last = "%x1";
  const auto store = [&](const std::string& name, const std::string& value) {
    body += "%n" + name + " = OpIAdd %uint " + last + " %u16\n%p" + name + " = OpAccessChain %p_float %data %u0 %n" + name +
            "\nOpStore %p" + name + " " + value + "\n";
    last = "%n" + name;
  };
  for (size_t i = 0; i < std::size(kRelations); ++i) {
    const std::string name = "r" + std::to_string(i);
    body += "%" + name + " = " + kRelations[i].op + " %bool %a %b\n%s" + name + " = OpSelect %float %" + name + " %c1 %c0\n";
    store(name, "%s" + name);
  }
  for (size_t i = 0; i < std::size(kFloatInstructions); ++i) {
    const std::string name = "f" + std::to_string(i);
    body += "%" + name + " = " + kFloatInstructions[i].text + "\n";
    store(name, "%" + name);
  }
  const Words words = assembly(float_assembly(body));
  const std::vector<Pair> inputs = special_pairs();
  for (size_t first = 0; first < inputs.size(); first += 16) {
    FakeStage stage;
    stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
    Words& data = stage.buffers[0].words;
    data.resize(16 * (2 + std::size(kRelations) + std::size(kFloatInstructions)));
    for (uint32_t lane = 0; lane < 16; ++lane) {
      data[lane] = word(inputs[first + lane][0]);
      data[16 + lane] = word(inputs[first + lane][1]);
    }
    ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words), "");
    for (uint32_t lane = 0; lane < 16; ++lane) {
      const float a = inputs[first + lane][0], b = inputs[first + lane][1];
      size_t at = 2;
      for (const AssemblyRow& row : kRelations) {
        EXPECT_EQ(real(data[16 * at++ + lane]), row.oracle(a, b) ? 1.0f : 0.0f) << row.op << " of " << a << ", " << b;
      }
      for (const AssemblyFloatRow& row : kFloatInstructions) {
        const float want = row.oracle(a, b), got = real(data[16 * at++ + lane]);
        // a - b * q may be fused: where b * q needs more than 24 bits the answer is not one number
        if (std::fabs(a / b) > 0x1p20f && row.text[3] == 'R') continue;
        if (std::isnan(want))
          EXPECT_TRUE(std::isnan(got)) << row.text << " of " << a << ", " << b;
        else
          EXPECT_EQ(got, want) << row.text << " of " << a << ", " << b;
      }
    }
  }
}

// The forms that write through a pointer, and copies, dynamic components and undefined values, which GLSL compilers avoid.
TEST(SpirvAssembly, PointersAndDynamicComponents) {
  const std::string types = R"(
%int = OpTypeInt 32 1
%vec3 = OpTypeVector %float 3
%p_int = OpTypePointer Function %int
%p_f = OpTypePointer Function %float
%c5 = OpConstant %float 5
%u3 = OpConstant %uint 3
%undef3 = OpUndef %vec3
%main = )";
  const std::string body = R"(
%whole = OpVariable %p_f Function
%copy = OpVariable %p_f Function
%exponent = OpVariable %p_int Function
%fraction = OpExtInst %float %glsl Modf %a %whole
OpCopyMemory %copy %whole
%w = OpLoad %float %copy
%significand = OpExtInst %float %glsl Frexp %b %exponent
%e = OpLoad %int %exponent
%ef = OpConvertSToF %float %e
%m = OpUMod %uint %x %u3
%v = OpCompositeConstruct %vec3 %fraction %w %significand
%v1 = OpVectorInsertDynamic %vec3 %v %c5 %m
%picked = OpVectorExtractDynamic %float %v %m
%r0 = OpCompositeExtract %float %v1 0
%r1 = OpCompositeExtract %float %v1 1
%mixed = OpVectorShuffle %vec3 %v1 %undef3 2 4 0
%r2 = OpCompositeExtract %float %mixed 0
%same = OpCopyObject %float %ef
)";
  std::string text = float_assembly("");
  const std::string end = "OpReturn\nOpFunctionEnd\n";
  text.resize(text.size() - end.size());
  const size_t main = text.find("%main = OpFunction"), entry = text.find("%entry = OpLabel\n");
  const size_t variables = body.find("%fraction");
  std::string stores, last = "%x1";
  for (const char* value : {"%r0", "%r1", "%r2", "%picked", "%same"}) {
    const std::string n = std::string("%n") + (value + 1), p = std::string("%q") + (value + 1);
    stores += n + " = OpIAdd %uint " + last + " %u16\n" + p + " = OpAccessChain %p_float %data %u0 " + n + "\nOpStore " + p +
              " " + value + "\n";
    last = n;
  }
  const size_t label_end = entry + std::string("%entry = OpLabel\n").size();
  text = text.substr(0, main) + types + text.substr(main + 8, label_end - main - 8) + body.substr(0, variables) +
         text.substr(label_end) + body.substr(variables) + stores + end;
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  Words& data = stage.buffers[0].words;
  data.resize(16 * 7);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    data[lane] = word(1.25f * lane - 7);
    data[16 + lane] = word(std::ldexp(0.75f, static_cast<int>(lane) - 8));
  }
  const Words in = data;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(text)), "");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const float a = real(in[lane]);
    const float v[3] = {a - std::trunc(a), std::trunc(a), 0.75f};
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(real(data[32 + 16 * i + lane]), lane % 3 == i ? 5.0f : v[i]) << lane << "." << i;
    EXPECT_EQ(real(data[80 + lane]), v[lane % 3]) << lane;
    EXPECT_EQ(real(data[96 + lane]), static_cast<float>(lane) - 8) << lane;
  }
}

}  // namespace
}  // namespace pineda::spirv::test
