// Pointers that are values: variable pointers, physical addresses, pointers to parts of local variables; and instructions that
// only assembly reaches.
#include <random>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

// The head of a compute shader over `struct { uint d[]; }` at set 0, binding 0, up to the body of main.
std::string head(const std::string& capabilities, const std::string& types, const char* memory_model = "Logical GLSL450") {
  return "OpCapability Shader\n" + capabilities +
         "OpExtension \"SPV_KHR_storage_buffer_storage_class\"\nOpExtension \"SPV_KHR_variable_pointers\"\n"
         "OpExtension \"SPV_KHR_physical_storage_buffer\"\nOpExtension \"SPV_KHR_integer_dot_product\"\nOpMemoryModel " +
         memory_model + R"(
OpEntryPoint GLCompute %main "main" %index
OpExecutionMode %main LocalSize 16 1 1
OpDecorate %index BuiltIn LocalInvocationIndex
OpDecorate %array ArrayStride 4
OpDecorate %p_uint ArrayStride 4
OpMemberDecorate %block 0 Offset 0
OpDecorate %block Block
OpDecorate %data DescriptorSet 0
OpDecorate %data Binding 0
OpDecorate %other DescriptorSet 0
OpDecorate %other Binding 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
%uint = OpTypeInt 32 0
%int = OpTypeInt 32 1
%bool = OpTypeBool
%u0 = OpConstant %uint 0
%u1 = OpConstant %uint 1
%u3 = OpConstant %uint 3
%u16 = OpConstant %uint 16
%u100 = OpConstant %uint 100
%array = OpTypeRuntimeArray %uint
%block = OpTypeStruct %array
%p_block = OpTypePointer StorageBuffer %block
%p_uint = OpTypePointer StorageBuffer %uint
%p_in = OpTypePointer Input %uint
%data = OpVariable %p_block StorageBuffer
%other = OpVariable %p_block StorageBuffer
%index = OpVariable %p_in Input
)" + types +
         R"(
%main = OpFunction %void None %fn
%entry = OpLabel
)";
}

const char kEnd[] = "OpReturn\nOpFunctionEnd\n";

FakeStage two_buffers() {
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  for (uint32_t i = 0; i < 64; ++i) {
    stage.buffers[0].words.push_back(1000 + i);
    stage.buffers[10].words.push_back(2000 + i);
  }
  return stage;
}

// A pointer chosen by select, one that a loop moves along by phi and OpPtrAccessChain, one kept in a variable, compared and
// subtracted.
TEST(SpirvPointers, VariablePointers) {
  const std::string types = R"(
%p_var = OpTypePointer Function %p_uint
%null = OpConstantNull %p_uint
)";
  const std::string body = R"(
%var = OpVariable %p_var Function
%x = OpLoad %uint %index
%pa = OpAccessChain %p_uint %data %u0 %x
%pb = OpAccessChain %p_uint %other %u0 %x
%odd = OpBitwiseAnd %uint %x %u1
%is_odd = OpINotEqual %bool %odd %u0
%chosen = OpSelect %p_uint %is_odd %pa %pb
OpStore %var %chosen
OpBranch %header
%header = OpLabel
%p = OpPhi %p_uint %chosen %entry %p_next %body
%i = OpPhi %uint %u0 %entry %i_next %body
%sum = OpPhi %uint %u0 %entry %sum_next %body
OpLoopMerge %done %body None
OpBranch %body
%body = OpLabel
%v = OpLoad %uint %p
%sum_next = OpIAdd %uint %sum %v
%p_next = OpPtrAccessChain %p_uint %p %u1
%i_next = OpIAdd %uint %i %u1
%more = OpULessThan %bool %i_next %u3
OpBranchConditional %more %header %done
%done = OpLabel
%kept = OpLoad %p_uint %var
%steps = OpPtrDiff %uint %p_next %kept
%same = OpPtrEqual %bool %kept %chosen
%differs = OpPtrNotEqual %bool %p_next %chosen
%both = OpLogicalAnd %bool %same %differs
%bonus = OpSelect %uint %both %u100 %u0
%r0 = OpIAdd %uint %sum_next %steps
%r = OpIAdd %uint %r0 %bonus
%at = OpIAdd %uint %x %u16
%at2 = OpIAdd %uint %at %u16
%out = OpAccessChain %p_uint %data %u0 %at2
OpStore %out %r
%zero = OpLoad %uint %null
%far = OpPtrAccessChain %p_uint %null %x
OpStore %far %r
%at3 = OpIAdd %uint %at2 %u16
%out3 = OpAccessChain %p_uint %data %u0 %at3
OpStore %out3 %zero
)";
  FakeStage stage = two_buffers();
  const std::string text = head("OpCapability VariablePointers\n", types) + body + kEnd;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(text, "spv1.4")), "");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t first = (lane % 2 ? 1000 : 2000) + lane;
    EXPECT_EQ(stage.buffers[0].words[32 + lane], 3 * first + 3 + 3 + 100) << lane;
    EXPECT_EQ(stage.buffers[0].words[48 + lane], 0u) << "a null pointer reads zero and writes nothing";
  }
}

// Without the capability a pointer to a buffer is no value.
TEST(SpirvPointers, NeedsItsCapability) {
  FakeStage stage = two_buffers();
  const std::string body = R"(
%x = OpLoad %uint %index
%pa = OpAccessChain %p_uint %data %u0 %x
%pb = OpAccessChain %p_uint %other %u0 %x
%odd = OpINotEqual %bool %x %u0
%chosen = OpSelect %p_uint %odd %pa %pb
)";
  EXPECT_NE(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(head("", "") + body + kEnd)), "");
}

// A linked list in two buffers, and addresses that lie in no buffer, just before one, and across its end.
TEST(SpirvPointers, PhysicalAddresses) {
  const std::string text = R"(
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
layout(local_size_x = 16) in;
layout(buffer_reference, std430, buffer_reference_align = 8) buffer Node;
layout(buffer_reference, std430, buffer_reference_align = 8) buffer Node { Node next; uint value; uint more[]; };
layout(std430, set = 0, binding = 0) buffer Data { uint64_t start[16]; uint sum[16]; uint wide[16]; };
void main() { uint i = gl_LocalInvocationIndex; Node n = Node(start[i]); uint s = 0u;
  for (int k = 0; k < 4; ++k) { s = s * 10u + n.value; if (uint64_t(n) == 0UL) break; n.value = n.value + 1u; n = n.next; }
  sum[i] = s; wide[i] = Node(start[i]).more[i]; })";
  struct Node {
    uint64_t next;
    uint32_t value, more[5];
  };
  std::vector<Node> pool(8);
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  const auto address = [&](size_t i) { return reinterpret_cast<uint64_t>(&pool[i]); };
  for (size_t i = 0; i < pool.size(); ++i) {
    pool[i] = {i == 5 ? 0 : address((i + 3) % 8), static_cast<uint32_t>(i + 1), {}};
    for (uint32_t k = 0; k < 5; ++k) pool[i].more[k] = static_cast<uint32_t>(100 * i + k);
  }
  // Nodes 0..3 and 4..6 are buffers; node 7 is not.
  stage.ranges = {{address(0), 4 * sizeof(Node), 0}, {address(4), 3 * sizeof(Node), 0}};
  std::vector<uint64_t> start(16);
  for (size_t i = 0; i < 16; ++i)
    start[i] = i < 8 ? address(i) : i == 8 ? 0 : i == 9 ? address(0) - 8 : i == 10 ? ~0ull - 3 : address(6);
  stage.buffers[0].words.resize(64);
  std::memcpy(stage.buffers[0].words.data(), start.data(), 128);
  std::vector<Node> model = pool;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, "vulkan1.2")), "");
  // All lanes run in step: each round reads, then writes what it read plus one (the last lane wins, and all write the same).
  const auto find = [&](uint64_t at) -> Node* {
    for (size_t i = 0; i < 7; ++i) {
      if (at == address(i)) return &model[i];
    }
    return nullptr;
  };
  std::vector<uint64_t> at = start;
  std::vector<uint32_t> sum(16), done(16);
  for (int k = 0; k < 4; ++k) {
    std::vector<uint32_t> value(16);
    for (size_t i = 0; i < 16; ++i) value[i] = find(at[i]) ? find(at[i])->value : 0;
    for (size_t i = 0; i < 16; ++i) {
      if (done[i]) continue;
      sum[i] = sum[i] * 10 + value[i];
      done[i] = at[i] == 0;
    }
    std::vector<uint64_t> next(16);
    for (size_t i = 0; i < 16; ++i) {
      next[i] = done[i] ? at[i] : find(at[i]) ? find(at[i])->next : 0;
    }
    for (size_t i = 0; i < 16; ++i) {
      if (!done[i] && find(at[i])) find(at[i])->value = value[i] + 1;
    }
    at = next;
  }
  for (size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(stage.buffers[0].words[32 + i], sum[i]) << i;
    const Node* node = find(start[i]);
    const size_t offset = 12 + 4 * i;  // of more[i]
    const bool inside =
        node && (node - model.data() < 4 ? (node - model.data()) * sizeof(Node) + offset + 4 <= 4 * sizeof(Node)
                                         : (node - model.data() - 4) * sizeof(Node) + offset + 4 <= 3 * sizeof(Node));
    uint32_t want = 0;
    if (inside) std::memcpy(&want, reinterpret_cast<const uint8_t*>(&model[0]) + (start[i] - address(0)) + offset, 4);
    EXPECT_EQ(stage.buffers[0].words[48 + i], want) << i;
  }
  EXPECT_EQ(stage.buffers[0].words[32 + 9], 0u) << "an address before a buffer reads nothing of it";
  EXPECT_EQ(pool[7].value, 8u) << "memory that belongs to no buffer is never written";
}

// Switches over 16- and 64-bit selectors, the latter with literals of two words.
TEST(SpirvPointers, SwitchWidths) {
  const std::string types = R"(
%ulong = OpTypeInt 64 0
%short = OpTypeInt 16 1
%big = OpConstant %ulong 4294967296
%m3 = OpConstant %short -3
)";
  const std::string body = R"(
%x = OpLoad %uint %index
%wide = OpUConvert %ulong %x
%scaled = OpIMul %ulong %wide %big
%narrow = OpUConvert %short %x
%moved = OpIAdd %short %narrow %m3
OpSelectionMerge %after None
OpSwitch %scaled %other1 8589934592 %two 21474836480 %five
%two = OpLabel
OpBranch %after
%five = OpLabel
OpBranch %after
%other1 = OpLabel
OpBranch %after
%after = OpLabel
%r1 = OpPhi %uint %u3 %two %u16 %five %u1 %other1
OpSelectionMerge %end None
OpSwitch %moved %end -2 %minus 4 %four
%minus = OpLabel
OpBranch %end
%four = OpLabel
OpBranch %end
%end = OpLabel
%r2 = OpPhi %uint %u0 %after %u100 %minus %u16 %four
%r = OpIAdd %uint %r1 %r2
%out = OpAccessChain %p_uint %data %u0 %x
OpStore %out %r
)";
  FakeStage stage = two_buffers();
  const std::string text = head("OpCapability Int64\nOpCapability Int16\n", types) + body + kEnd;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(text)), "");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t want = (lane == 2 ? 3 : lane == 5 ? 16 : 1) + (lane == 1 ? 100 : lane == 7 ? 16 : 0);
    EXPECT_EQ(stage.buffers[0].words[lane], want) << lane;
  }
}

TEST(SpirvPointers, DotProducts) {
  const std::string capabilities =
      "OpCapability Int8\nOpCapability Int16\nOpCapability DotProductKHR\nOpCapability DotProductInput4x8BitKHR\n"
      "OpCapability DotProductInput4x8BitPackedKHR\nOpCapability DotProductInputAllKHR\n";
  const std::string types = R"(
%short = OpTypeInt 16 1
%char = OpTypeInt 8 1
%c4 = OpTypeVector %char 4
)";
  const std::string body = R"(
%x = OpLoad %uint %index
%pa = OpAccessChain %p_uint %data %u0 %x
%pb = OpAccessChain %p_uint %other %u0 %x
%a = OpLoad %uint %pa
%b = OpLoad %uint %pb
%s = OpSDotKHR %int %a %b PackedVectorFormat4x8BitKHR
%u = OpUDotKHR %uint %a %b PackedVectorFormat4x8BitKHR
%su = OpSUDotKHR %int %a %b PackedVectorFormat4x8BitKHR
%ab = OpBitcast %int %a
%sat = OpSDotAccSatKHR %int %a %b %ab PackedVectorFormat4x8BitKHR
%usat = OpUDotAccSatKHR %uint %a %b %b PackedVectorFormat4x8BitKHR
%va = OpBitcast %c4 %a
%vb = OpBitcast %c4 %b
%n = OpSDotKHR %short %va %vb
%ne = OpSConvert %int %n
)";
  const char* results[] = {"%s", "%u", "%su", "%sat", "%usat", "%ne"};
  std::string stores, last = "%x";
  for (const char* result : results) {
    const std::string n = std::string(result + 1);
    stores += "%i" + n + " = OpIAdd %uint " + last + " %u16\n%p" + n + " = OpAccessChain %p_uint %data %u0 %i" + n + "\n%w" + n +
              " = OpBitcast %uint " + result + "\nOpStore %p" + n + " %w" + n + "\n";
    last = "%i" + n;
  }
  std::mt19937 random(3);
  FakeStage stage = two_buffers();
  stage.buffers[0].words.resize(16 * 7);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    stage.buffers[0].words[lane] = lane == 0 ? 0x7fffffff : lane == 1 ? 0x80808080 : random();
    stage.buffers[10].words[lane] = lane == 0 ? 0x7f7f7f7f : lane == 1 ? 0x80808080 : lane == 2 ? 0xffffffff : random();
  }
  const Words in = stage.buffers[0].words;
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(head(capabilities, types) + body + stores + kEnd)), "");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t a = in[lane], b = stage.buffers[10].words[lane];
    int64_t s = 0, u = 0, su = 0;
    for (int k = 0; k < 32; k += 8) {
      const auto sa = static_cast<int8_t>(a >> k), sb = static_cast<int8_t>(b >> k);
      const auto ua = static_cast<uint8_t>(a >> k), ub = static_cast<uint8_t>(b >> k);
      s += sa * sb, u += ua * ub, su += sa * ub;
    }
    const auto sat = static_cast<uint32_t>(std::clamp<int64_t>(s + static_cast<int32_t>(a), INT32_MIN, INT32_MAX));
    const auto usat = static_cast<uint32_t>(std::min<int64_t>(u + b, UINT32_MAX));
    const uint32_t want[] = {static_cast<uint32_t>(s),
                             static_cast<uint32_t>(u),
                             static_cast<uint32_t>(su),
                             sat,
                             usat,
                             static_cast<uint32_t>(static_cast<int16_t>(s))};
    for (size_t k = 0; k < std::size(want); ++k)
      EXPECT_EQ(stage.buffers[0].words[16 * (k + 1) + lane], want[k]) << results[k] << lane;
  }
}

}  // namespace
}  // namespace pineda::spirv::test
