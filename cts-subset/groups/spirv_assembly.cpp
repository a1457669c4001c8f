// spirv_assembly.*: instructions that GLSL does not give directly, assembled by hand into a compute shader.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kCount = 64;

// A module that reads words a and b (and their float views), and stores %result (uint).
std::string module_text(const std::string& types, const std::string& body, const std::string& functions) {
  return R"(
OpCapability Shader
%glsl = OpExtInstImport "GLSL.std.450"
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %gid
OpExecutionMode %main LocalSize 16 1 1
OpDecorate %gid BuiltIn GlobalInvocationId
OpDecorate %array ArrayStride 4
OpMemberDecorate %block 0 Offset 0
OpDecorate %block BufferBlock
OpDecorate %in_a DescriptorSet 0
OpDecorate %in_a Binding 0
OpDecorate %in_b DescriptorSet 0
OpDecorate %in_b Binding 1
OpDecorate %out DescriptorSet 0
OpDecorate %out Binding 2
%void = OpTypeVoid
%bool = OpTypeBool
%uint = OpTypeInt 32 0
%int = OpTypeInt 32 1
%float = OpTypeFloat 32
%v2uint = OpTypeVector %uint 2
%v3uint = OpTypeVector %uint 3
%v4uint = OpTypeVector %uint 4
%v4float = OpTypeVector %float 4
%array = OpTypeRuntimeArray %uint
%block = OpTypeStruct %array
%block_pointer = OpTypePointer Uniform %block
%word_pointer = OpTypePointer Uniform %uint
%input_pointer = OpTypePointer Input %v3uint
%local_pointer = OpTypePointer Function %uint
%u0 = OpConstant %uint 0
%u1 = OpConstant %uint 1
%u2 = OpConstant %uint 2
%u3 = OpConstant %uint 3
%u4 = OpConstant %uint 4
%u7 = OpConstant %uint 7
%i0 = OpConstant %int 0
%f0 = OpConstant %float 0
%f1 = OpConstant %float 1
%true = OpConstantTrue %bool
%false = OpConstantFalse %bool
%gid = OpVariable %input_pointer Input
%in_a = OpVariable %block_pointer Uniform
%in_b = OpVariable %block_pointer Uniform
%out = OpVariable %block_pointer Uniform
%main_type = OpTypeFunction %void
)" + types +
         R"(
%main = OpFunction %void None %main_type
%entry = OpLabel
%local = OpVariable %local_pointer Function
%id3 = OpLoad %v3uint %gid
%id = OpCompositeExtract %uint %id3 0
%pa = OpAccessChain %word_pointer %in_a %u0 %id
%pb = OpAccessChain %word_pointer %in_b %u0 %id
%a = OpLoad %uint %pa
%b = OpLoad %uint %pb
%ia = OpBitcast %int %a
%ib = OpBitcast %int %b
%fa = OpBitcast %float %a
%fb = OpBitcast %float %b
)" + body +
         R"(
%po = OpAccessChain %word_pointer %out %u0 %id
OpStore %po %result
OpReturn
OpFunctionEnd
)" + functions;
}

struct Instruction {
  const char* name;
  const char* body;
  uint32_t (*want)(uint32_t a, uint32_t b);
  const char* types = "";
  const char* functions = "";
  bool floats = false;  // a and b are finite floats
};

float f(uint32_t bits) { return std::bit_cast<float>(bits); }
uint32_t u(float value) { return std::bit_cast<uint32_t>(value); }
int32_t s(uint32_t bits) { return static_cast<int32_t>(bits); }

// "Quantize to f16": flush to zero of the sign below the smallest normal half is allowed; the inputs avoid that range.
float quantize(float value) {
  const double magnitude = std::abs(static_cast<double>(value));
  if (magnitude >= 65520) return std::copysign(std::numeric_limits<float>::infinity(), value);
  int exponent;
  std::frexp(magnitude, &exponent);
  const double step = std::ldexp(1.0, std::max(exponent - 11, -24));
  return std::copysign(static_cast<float>(std::nearbyint(magnitude / step) * step), value);
}

const Instruction kInstructions[] = {
    {"OpCopyObject", "%result = OpCopyObject %uint %a", [](uint32_t a, uint32_t) { return a; }},
    {"OpConstantNull", "%result = OpBitwiseOr %uint %a %null", [](uint32_t a, uint32_t) { return a; },
     "%null = OpConstantNull %uint"},
    {"OpUndef_unused",
     "%undef = OpUndef %uint\n%v = OpCompositeConstruct %v2uint %a %undef\n%result = OpCompositeExtract %uint %v 0",
     [](uint32_t a, uint32_t) { return a; }},
    {"OpSRem", "%safe = OpBitwiseOr %int %ib %one\n%r = OpSRem %int %ia %safe\n%result = OpBitcast %uint %r",
     [](uint32_t a, uint32_t b) {
       const int64_t d = s(b | 1);
       return static_cast<uint32_t>(s(a) % d);
     },
     "%one = OpConstant %int 1"},
    {"OpSMod", "%safe = OpBitwiseOr %int %ib %one\n%r = OpSMod %int %ia %safe\n%result = OpBitcast %uint %r",
     [](uint32_t a, uint32_t b) {
       const int64_t d = s(b | 1), r = s(a) % d;
       return static_cast<uint32_t>(r != 0 && (r < 0) != (d < 0) ? r + d : r);
     },
     "%one = OpConstant %int 1"},
    {"OpUMulExtended", "%m = OpUMulExtended %pair %a %b\n%result = OpCompositeExtract %uint %m 1",
     [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(uint64_t{a} * b >> 32); }, "%pair = OpTypeStruct %uint %uint"},
    {"OpSMulExtended", "%m = OpSMulExtended %pair %ia %ib\n%h = OpCompositeExtract %int %m 1\n%result = OpBitcast %uint %h",
     [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(static_cast<uint64_t>(int64_t{s(a)} * s(b)) >> 32); },
     "%pair = OpTypeStruct %int %int"},
    {"OpIAddCarry", "%m = OpIAddCarry %pair %a %b\n%result = OpCompositeExtract %uint %m 1",
     [](uint32_t a, uint32_t b) { return a + b < a ? 1u : 0u; }, "%pair = OpTypeStruct %uint %uint"},
    {"OpISubBorrow", "%m = OpISubBorrow %pair %a %b\n%result = OpCompositeExtract %uint %m 1",
     [](uint32_t a, uint32_t b) { return a < b ? 1u : 0u; }, "%pair = OpTypeStruct %uint %uint"},
    {"OpBitFieldInsert", "%c = OpBitwiseAnd %uint %b %u7\n%result = OpBitFieldInsert %uint %a %b %c %u7",
     [](uint32_t a, uint32_t b) {
       const uint32_t at = b & 7, mask = 127u << at;
       return (a & ~mask) | (b << at & mask);
     }},
    {"OpBitFieldSExtract",
     "%c = OpBitwiseAnd %uint %b %u7\n%r = OpBitFieldSExtract %int %ia %c %u7\n%result = OpBitcast %uint %r",
     [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(s(a << (25 - (b & 7))) >> 25); }},
    {"OpBitFieldUExtract", "%c = OpBitwiseAnd %uint %b %u7\n%result = OpBitFieldUExtract %uint %a %c %u7",
     [](uint32_t a, uint32_t b) { return a >> (b & 7) & 127; }},
    {"OpBitReverse", "%result = OpBitReverse %uint %a",
     [](uint32_t a, uint32_t) {
       uint32_t r = 0;
       for (int i = 0; i < 32; ++i) r |= (a >> i & 1) << (31 - i);
       return r;
     }},
    {"OpBitCount", "%result = OpBitCount %uint %a", [](uint32_t a, uint32_t) { return static_cast<uint32_t>(std::popcount(a)); }},
    {"OpVectorShuffle_undefined_component",
     "%v = OpCompositeConstruct %v2uint %a %b\n%w = OpVectorShuffle %v4uint %v %v 3 0xFFFFFFFF 0 1\n"
     "%x = OpCompositeExtract %uint %w 0\n%y = OpCompositeExtract %uint %w 2\n%result = OpISub %uint %x %y",
     [](uint32_t a, uint32_t b) { return b - a; }},
    {"OpVectorExtractDynamic",
     "%v = OpCompositeConstruct %v4uint %a %b %u7 %id\n%c = OpBitwiseAnd %uint %b %u3\n"
     "%result = OpVectorExtractDynamic %uint %v %c",
     nullptr},
    {"OpVectorInsertDynamic",
     "%v = OpCompositeConstruct %v4uint %u0 %u1 %u2 %u3\n%c = OpBitwiseAnd %uint %b %u3\n"
     "%w = OpVectorInsertDynamic %v4uint %v %a %c\n%result = OpVectorExtractDynamic %uint %w %u2",
     [](uint32_t a, uint32_t b) { return (b & 3) == 2 ? a : 2u; }},
    {"OpCompositeInsert_nested",
     "%s0 = OpCompositeConstruct %inner %a %b\n%s1 = OpCompositeConstruct %outer %s0 %s0\n"
     "%s2 = OpCompositeInsert %outer %b %s1 1 0\n%x = OpCompositeExtract %uint %s2 1 0\n%y = OpCompositeExtract %uint %s2 0 0\n"
     "%result = OpISub %uint %x %y",
     [](uint32_t a, uint32_t b) { return b - a; }, "%inner = OpTypeStruct %uint %uint\n%outer = OpTypeStruct %inner %inner"},
    {"OpCopyMemory", "OpCopyMemory %local %pb\n%l = OpLoad %uint %local\n%result = OpIAdd %uint %l %a",
     [](uint32_t a, uint32_t b) { return a + b; }},
    {"OpSelect_vector",
     "%x = OpULessThan %bool %a %b\n%y = OpLogicalNot %bool %x\n%c = OpCompositeConstruct %v2bool %x %y\n"
     "%v = OpCompositeConstruct %v2uint %a %b\n%w = OpCompositeConstruct %v2uint %b %a\n%m = OpSelect %v2uint %c %v %w\n"
     "%p = OpCompositeExtract %uint %m 0\n%q = OpCompositeExtract %uint %m 1\n%k = OpIMul %uint %q %u3\n%result = OpIAdd %uint "
     "%p %k",
     [](uint32_t a, uint32_t b) { return (a < b ? a : b) + 3 * (a < b ? a : b); }, "%v2bool = OpTypeVector %bool 2"},
    {"OpPhi_diamond",
     "%c = OpULessThan %bool %a %b\nOpSelectionMerge %merge None\nOpBranchConditional %c %then %else\n"
     "%then = OpLabel\n%x = OpIAdd %uint %a %u1\nOpBranch %merge\n%else = OpLabel\n%y = OpIMul %uint %b %u3\nOpBranch %merge\n"
     "%merge = OpLabel\n%result = OpPhi %uint %x %then %y %else",
     [](uint32_t a, uint32_t b) { return a < b ? a + 1 : b * 3; }},
    {"OpPhi_swap_in_loop",  // phis of one block read the values from before the block
     "%n = OpBitwiseAnd %uint %b %u7\nOpBranch %head\n%head = OpLabel\n%x = OpPhi %uint %a %entry %y %cont\n"
     "%y = OpPhi %uint %b %entry %x %cont\n%i = OpPhi %uint %u0 %entry %i1 %cont\n"
     "OpLoopMerge %merge %cont None\nOpBranch %test\n%test = OpLabel\n%c = OpULessThan %bool %i %n\nOpBranchConditional %c %body "
     "%merge\n"
     "%body = OpLabel\nOpBranch %cont\n%cont = OpLabel\n%i1 = OpIAdd %uint %i %u1\nOpBranch %head\n"
     "%merge = OpLabel\n%result = OpCopyObject %uint %x",
     [](uint32_t a, uint32_t b) { return (b & 1) ? b : a; }},
    {"OpSwitch_fall_through",
     "%k = OpBitwiseAnd %uint %b %u3\nOpSelectionMerge %merge None\nOpSwitch %k %default 0 %c0 1 %c1 2 %c2\n"
     "%c0 = OpLabel\nOpBranch %c1\n%c1 = OpLabel\n%p1 = OpPhi %uint %u7 %c0 %u1 %entry\n%x1 = OpIAdd %uint %a %p1\nOpBranch "
     "%merge\n"
     "%c2 = OpLabel\nOpBranch %merge\n%default = OpLabel\nOpBranch %merge\n"
     "%merge = OpLabel\n%result = OpPhi %uint %x1 %c1 %u2 %c2 %b %default",
     [](uint32_t a, uint32_t b) {
       const uint32_t k = b & 3;
       return k == 0 ? a + 7 : k == 1 ? a + 1 : k == 2 ? 2u : b;
     }},
    {"OpUnreachable",
     "%c = OpIEqual %bool %a %a\nOpSelectionMerge %merge None\nOpBranchConditional %c %then %never\n"
     "%never = OpLabel\nOpUnreachable\n%then = OpLabel\nOpBranch %merge\n%merge = OpLabel\n%result = OpCopyObject %uint %a",
     [](uint32_t a, uint32_t) { return a; }},
    {"OpFunctionCall_early_return", "%result = OpFunctionCall %uint %f %a %b",
     [](uint32_t a, uint32_t b) { return a < b ? a * 3 : a - b; }, "%f_type = OpTypeFunction %uint %uint %uint",
     "%f = OpFunction %uint None %f_type\n%fx = OpFunctionParameter %uint\n%fy = OpFunctionParameter %uint\n%f_entry = OpLabel\n"
     "%fc = OpULessThan %bool %fx %fy\nOpSelectionMerge %f_merge None\nOpBranchConditional %fc %f_then %f_merge\n"
     "%f_then = OpLabel\n%fr1 = OpIMul %uint %fx %u3\nOpReturnValue %fr1\n%f_merge = OpLabel\n%f2 = OpISub %uint %fx %fy\n"
     "OpReturnValue %f2\nOpFunctionEnd\n"},
    {"OpFunctionCall_pointer_argument",
     "OpStore %local %a\n%n = OpFunctionCall %void %f %local %b\n%result = OpLoad %uint %local",
     [](uint32_t a, uint32_t b) { return a ^ b; }, "%f_type = OpTypeFunction %void %local_pointer %uint",
     "%f = OpFunction %void None %f_type\n%fx = OpFunctionParameter %local_pointer\n%fy = OpFunctionParameter %uint\n"
     "%f_entry = OpLabel\n%fl = OpLoad %uint %fx\n%fr = OpBitwiseXor %uint %fl %fy\nOpStore %fx %fr\nOpReturn\nOpFunctionEnd\n"},
    {"OpQuantizeToF16", "%q = OpQuantizeToF16 %float %fa\n%result = OpBitcast %uint %q",
     [](uint32_t a, uint32_t) { return u(quantize(f(a))); }, "", "", true},
    {"OpFUnordLessThan", "%c = OpFUnordLessThan %bool %fa %fb\n%result = OpSelect %uint %c %u1 %u0",
     [](uint32_t a, uint32_t b) { return !(f(a) >= f(b)) ? 1u : 0u; }, "", "", true},
    {"OpFOrdNotEqual", "%c = OpFOrdNotEqual %bool %fa %fb\n%result = OpSelect %uint %c %u1 %u0",
     [](uint32_t a, uint32_t b) { return f(a) != f(b) ? 1u : 0u; }, "", "", true},
    {"OpFMod", "%m = OpFMod %float %fa %f1\n%c = OpFOrdLessThan %bool %m %f0\n%result = OpSelect %uint %c %u1 %u0",
     [](uint32_t, uint32_t) { return 0u; }, "", "", true},  // the sign is the divisor's
    {"OpFNegate_twice", "%n = OpFNegate %float %fa\n%m = OpFNegate %float %n\n%result = OpBitcast %uint %m",
     [](uint32_t a, uint32_t) { return a; }, "", "", true},
    {"OpConvertFToS_trunc", "%c = OpConvertFToS %int %fa\n%result = OpBitcast %uint %c",
     [](uint32_t a, uint32_t) { return static_cast<uint32_t>(static_cast<int32_t>(f(a))); }, "", "", true},
    {"OpArrayLength", "%n = OpArrayLength %uint %in_a 0\n%result = OpIAdd %uint %n %a",
     [](uint32_t a, uint32_t) { return a + kCount; }},
    {"OpLogicalNotEqual",
     "%x = OpULessThan %bool %a %b\n%y = OpULessThan %bool %b %u7\n%z = OpLogicalNotEqual %bool %x %y\n"
     "%result = OpSelect %uint %z %u1 %u0",
     [](uint32_t a, uint32_t b) { return (a < b) != (b < 7) ? 1u : 0u; }},
    {"OpAny_OpAll",
     "%x = OpULessThan %bool %a %b\n%y = OpULessThan %bool %b %u7\n%v = OpCompositeConstruct %v2bool %x %y\n"
     "%p = OpAny %bool %v\n%q = OpAll %bool %v\n%r = OpLogicalAnd %bool %p %q\n%result = OpSelect %uint %r %u1 %u0",
     [](uint32_t a, uint32_t b) { return a < b && b < 7 ? 1u : 0u; }, "%v2bool = OpTypeVector %bool 2"},
    {"OpLine_and_names", "OpLine %file 3 4\n%result = OpIAdd %uint %a %b\nOpNoLine", [](uint32_t a, uint32_t b) { return a + b; },
     nullptr},
    {"OpLoopMerge_unroll_hint",
     "OpBranch %head\n%head = OpLabel\n%i = OpPhi %uint %u0 %entry %i1 %cont\n%x = OpPhi %uint %a %entry %x1 %cont\n"
     "OpLoopMerge %merge %cont Unroll\nOpBranch %test\n%test = OpLabel\n%c = OpULessThan %bool %i %u4\n"
     "OpBranchConditional %c %body %merge\n%body = OpLabel\nOpBranch %cont\n%cont = OpLabel\n%x1 = OpIMul %uint %x %u3\n"
     "%i1 = OpIAdd %uint %i %u1\nOpBranch %head\n%merge = OpLabel\n%result = OpCopyObject %uint %x",
     [](uint32_t a, uint32_t) { return a * 81; }},
    {"loop_with_two_exits",
     "OpBranch %head\n%head = OpLabel\n%i = OpPhi %uint %u0 %entry %i1 %cont\n%x = OpPhi %uint %a %entry %x1 %cont\n"
     "OpLoopMerge %merge %cont None\nOpBranch %test\n%test = OpLabel\n%c = OpULessThan %bool %i %u7\n"
     "OpBranchConditional %c %body %merge\n%body = OpLabel\n%x1 = OpBitwiseXor %uint %x %i\n%k = OpBitwiseAnd %uint %x1 %u4\n"
     "%d = OpIEqual %bool %k %u0\nOpBranchConditional %d %merge %cont\n%cont = OpLabel\n%i1 = OpIAdd %uint %i %u1\n"
     "OpBranch %head\n%merge = OpLabel\n%result = OpPhi %uint %x %test %x1 %body",
     [](uint32_t a, uint32_t) {
       for (uint32_t i = 0; i < 7; ++i) {
         a ^= i;
         if (!(a & 4)) return a;
       }
       return a;
     }},
};

void run(Device& device, const Instruction& instruction) {
  Random random(instruction.name);
  std::vector<uint32_t> a(kCount), b(kCount);
  for (uint32_t i = 0; i < kCount; ++i) {
    if (instruction.floats) {
      const double magnitude = std::exp2(random.between(-8, 17));
      a[i] = u(static_cast<float>((random.bits() & 1 ? -1 : 1) * magnitude));
      b[i] = random.below(4) ? u(static_cast<float>(random.between(-100, 100))) : a[i];
    } else {
      a[i] = random.below(3) ? random.bits() : random.below(10);
      b[i] = random.below(3) ? random.bits() : random.below(10);
    }
  }
  const Buffer in_a = create_buffer(device, a), in_b = create_buffer(device, b), out = create_buffer(device, kCount * 4);
  Resources resources;
  resources.descriptors = {storage_buffer(0, in_a), storage_buffer(1, in_b), storage_buffer(2, out)};
  std::string text = module_text(instruction.types ? instruction.types : "", instruction.body, instruction.functions);
  if (!instruction.types) {  // debug instructions stand before the decorations
    text.insert(text.find("OpDecorate"), "%file = OpString \"a file\"\nOpName %a \"\"\nOpName %main \"another name\"\n");
  }
  dispatch(device, assemble(text), resources, {kCount / 16, 1, 1});
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint32_t got = out.as<uint32_t>()[i];
    uint32_t want;
    if (instruction.want) {
      want = instruction.want(a[i], b[i]);
    } else {  // OpVectorExtractDynamic has the invocation's number among its components
      const uint32_t components[4] = {a[i], b[i], 7, i};
      want = components[b[i] & 3];
    }
    expect(got == want, fmt::format("({:#x}, {:#x}) gave {:#x}, not {:#x}", a[i], b[i], got, want));
  }
}

}  // namespace

void register_spirv_assembly() {
  for (const Instruction& instruction : kInstructions) {
    add_case("spirv_assembly.instruction.compute", instruction.name, fmt::format("SPIR-V 3.42: {}", instruction.name),
             [&instruction](Device& device) { run(device, instruction); });
  }
}

}  // namespace pineda::cts
