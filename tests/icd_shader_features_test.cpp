// Shader extensions through the whole driver: each feature bit and execution mode that is advertised, used by a shader.
#include <bit>
#include <cmath>
#include <limits>

#include "shader_client.h"

namespace pineda::test {
namespace {

constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;
constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr auto kVertex = VK_SHADER_STAGE_VERTEX_BIT;

// ---- buffer device addresses ------------------------------------------------------------------------------------------------

struct AddressClient : ShaderClient {
  AddressClient() : ShaderClient(nullptr, {}, {VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME}) {}

  struct Addressed {
    uint32_t* data;
    VkDeviceAddress address;
  };
  Addressed addressed(VkDeviceSize size_bytes) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size_bytes;
    info.usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateBuffer)(device, &info, nullptr, &buffer), VK_SUCCESS);
    const VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, nullptr,
                                          VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT, 0};
    const VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, size_bytes, 0};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateMemory)(device, &allocate, nullptr, &memory), VK_SUCCESS);
    EXPECT_EQ(VK(*this, BindBufferMemory)(device, buffer, memory, 0), VK_SUCCESS);
    void* mapped = nullptr;
    EXPECT_EQ(VK(*this, MapMemory)(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
    defer([this, buffer, memory] {
      VK(*this, DestroyBuffer)(device, buffer, nullptr);
      VK(*this, FreeMemory)(device, memory, nullptr);
    });
    const VkBufferDeviceAddressInfo of{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer};
    return {static_cast<uint32_t*>(mapped), VK(*this, GetBufferDeviceAddressKHR)(device, &of)};
  }
};

const std::string kReference =
    "#extension GL_EXT_buffer_reference : require\n#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require\n";

// A list whose nodes lie in eight buffers, made on the host; and a shader that follows it, writes to each node and counts.
TEST(IcdShaderFeatures, PointersAcrossBuffers) {
  AddressClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  std::vector<AddressClient::Addressed> nodes;
  for (uint32_t i = 0; i < 8; ++i) nodes.push_back(client.addressed(64));
  for (uint32_t i = 0; i < 8; ++i) {
    const uint64_t next = i + 1 < 8 ? nodes[(i + 1) * 3 % 8].address : 0;
    uint32_t* node = nodes[i * 3 % 8].data;
    std::memcpy(node, &next, 8);
    node[2] = 100 + i;
  }
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  const Words words = glsl(kCompute, kReference + R"(layout(local_size_x = 32) in;
    layout(buffer_reference) buffer Node; layout(buffer_reference, buffer_reference_align = 8) buffer Node { Node next; uint value; uint seen; };
    layout(push_constant) uniform P { Node head; }; layout(binding = 0) buffer Out { uint sums[]; };
    void main() { uint sum = 0u; for (Node n = head; uint64_t(n) != 0ul; n = n.next) { sum += n.value; atomicAdd(n.seen, 1u); }
      sums[gl_LocalInvocationIndex] = sum; })",
                           "vulkan1.1");
  const uint64_t head = nodes[0].address;
  ASSERT_EQ(client.compute(words, 1, &head, 8), VK_SUCCESS);
  for (uint32_t i = 0; i < 32; ++i) EXPECT_EQ(out.as<uint32_t>()[i], 8u * 100 + 28);
  for (const auto& node : nodes) EXPECT_EQ(node.data[3], 32u);
}

// Pointers to nowhere read zero and write nothing, in every stage.
TEST(IcdShaderFeatures, PointersToNowhere) {
  AddressClient client;
  const auto memory = client.addressed(4096), other = client.addressed(4096);
  for (uint32_t i = 0; i < 1024; ++i) memory.data[i] = other.data[i] = i + 1;
  const uint64_t first = memory.address;
  const uint64_t pointers[] = {0,
                               4,
                               first - 4,
                               first + 4096,
                               first + 4097,
                               first + 4092,
                               ~uint64_t{0} - 3,
                               1ull << 47,
                               1ull << 63,
                               first + (1ull << 32),
                               first + 8};
  constexpr uint32_t kCount = std::size(pointers);
  const auto table = client.buffer(sizeof(pointers)), out = client.buffer(kCount * 4);
  std::memcpy(table.data, pointers, sizeof(pointers));
  client.bind({ShaderClient::storage(table), ShaderClient::storage(out)});
  const std::string head = kReference + R"(layout(buffer_reference, buffer_reference_align = 4) buffer Cell { uint v; };
    layout(binding = 0) buffer Table { uint64_t at[]; }; layout(binding = 1) buffer Out { uint found[]; };)";
  const std::string body = "Cell c = Cell(at[i]); found[i] = c.v + 1u; c.v = 7u; atomicAdd(c.v, 1u);";
  const auto check = [&](const char* stage) {
    for (uint32_t i = 0; i < kCount; ++i) {
      // Where two allocations touch, the end of one is the start of the other: only what is surely outside is asked for.
      const bool inside = i == 5 || i == 10;
      const bool may_be_other = i == 2 || i == 3 || i == 4;
      const uint32_t want = i == 5 ? 1025 : i == 10 ? 4 : 1;
      if (may_be_other) continue;
      EXPECT_EQ(out.as<uint32_t>()[i], inside ? want : 1) << stage << ' ' << i;
    }
    EXPECT_EQ(memory.data[1023], 8u) << stage;
    EXPECT_EQ(memory.data[2], 8u) << stage;
    for (uint32_t i = 3; i < 1023; ++i) ASSERT_EQ(memory.data[i], i + 1) << stage;
    memory.data[1023] = 1024, memory.data[2] = 3;
  };
  ASSERT_EQ(client.compute(glsl(kCompute,
                                head + "layout(local_size_x = " + std::to_string(kCount) +
                                    ") in; void main() { uint i = gl_LocalInvocationIndex;" + body + "}",
                                "vulkan1.1"),
                           1),
            VK_SUCCESS);
  check("compute");
  ASSERT_EQ(client.draw(ShaderClient::covering_vertex(),
                        glsl(kFragment,
                             head +
                                 "layout(location = 0) out uvec4 r; void main() { uint i = uint(gl_FragCoord.x); if "
                                 "(gl_FragCoord.y > 1.0 || i >= " +
                                 std::to_string(kCount) + "u) discard; " + body + " r = uvec4(1); }",
                             "vulkan1.1"),
                        3),
            VK_SUCCESS);
  check("fragment");
  ASSERT_EQ(client.draw(glsl(kVertex,
                             head + "void main() { uint i = uint(gl_VertexIndex);" + body +
                                 "gl_Position = vec4(0, 0, 0, 1); gl_PointSize = 1.0; }",
                             "vulkan1.1"),
                        glsl(kFragment, "layout(location = 0) out uvec4 r; void main() { r = uvec4(1); }"), kCount, nullptr,
                        VK_PRIMITIVE_TOPOLOGY_POINT_LIST),
            VK_SUCCESS);
  check("vertex");
}

// ---- float controls ---------------------------------------------------------------------------------------------------------

// out[i] = in[2 i] op in[2 i + 1] for one operation and one float width, under the execution modes given.
std::string float_program(uint32_t bits, const std::string& op, const std::string& modes, const std::string& capabilities) {
  const std::string b = std::to_string(bits), stride = std::to_string(bits / 8);
  return "OpCapability Shader\n" + capabilities + R"(
OpExtension "SPV_KHR_float_controls"
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %id
OpExecutionMode %main LocalSize 16 1 1
)" + modes +
         R"(
OpDecorate %id BuiltIn GlobalInvocationId
OpDecorate %array ArrayStride )" +
         stride + R"(
OpDecorate %block BufferBlock
OpMemberDecorate %block 0 Offset 0
OpDecorate %in DescriptorSet 0
OpDecorate %in Binding 0
OpDecorate %out DescriptorSet 0
OpDecorate %out Binding 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
%float = OpTypeFloat )" +
         b + R"(
%uint = OpTypeInt 32 0
%uint3 = OpTypeVector %uint 3
%array = OpTypeRuntimeArray %float
%block = OpTypeStruct %array
%pblock = OpTypePointer Uniform %block
%pfloat = OpTypePointer Uniform %float
%puint3 = OpTypePointer Input %uint3
%in = OpVariable %pblock Uniform
%out = OpVariable %pblock Uniform
%id = OpVariable %puint3 Input
%zero = OpConstant %uint 0
%one = OpConstant %uint 1
%two = OpConstant %uint 2
%main = OpFunction %void None %fn
%begin = OpLabel
%ids = OpLoad %uint3 %id
%i = OpCompositeExtract %uint %ids 0
%j = OpIMul %uint %i %two
%k = OpIAdd %uint %j %one
%pa = OpAccessChain %pfloat %in %zero %j
%pb = OpAccessChain %pfloat %in %zero %k
%a = OpLoad %float %pa
%b = OpLoad %float %pb
%r = )" + op +
         R"( %float %a %b
%pr = OpAccessChain %pfloat %out %zero %i
OpStore %pr %r
OpReturn
OpFunctionEnd
)";
}

struct FloatControlsClient : ShaderClient {
  FloatControlsClient() : ShaderClient(nullptr, {}, {VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME}) {}
  VkPhysicalDeviceFloatControlsProperties properties() {
    VkPhysicalDeviceFloatControlsProperties out{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES};
    VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &out, {}};
    VK(*this, GetPhysicalDeviceProperties2)(physical, &all);
    return out;
  }
};

const std::string kAllModes(const std::string& bits) {
  return "OpExecutionMode %main DenormPreserve " + bits + "\nOpExecutionMode %main SignedZeroInfNanPreserve " + bits +
         "\nOpExecutionMode %main RoundingModeRTE " + bits + "\n";
}
const std::string kAllCapabilities =
    "OpCapability DenormPreserve\nOpCapability SignedZeroInfNanPreserve\nOpCapability RoundingModeRTE\n";

// The CPU's own arithmetic is IEEE 754's, so it is the oracle.
template <typename Float, typename Bits>
void check_float_controls(FloatControlsClient& client, const std::string& more_capabilities) {
  using Limits = std::numeric_limits<Float>;
  const Float values[] = {0,
                          -Float(0),
                          Limits::denorm_min(),
                          -Limits::denorm_min() * 3,
                          Limits::min() / 2,
                          Limits::min(),
                          1,
                          Float(1) / 3,
                          -2,
                          Limits::max(),
                          Limits::infinity(),
                          -Limits::infinity(),
                          Limits::quiet_NaN(),
                          1 + Limits::epsilon(),
                          Limits::epsilon() / 2,
                          1e-30f};
  std::vector<Float> pairs;
  for (Float a : values) {
    for (Float c : values) pairs.insert(pairs.end(), {a, c});
  }
  const size_t count = pairs.size() / 2;
  const auto in = client.buffer(pairs.size() * sizeof(Float)), out = client.buffer(count * sizeof(Float));
  std::memcpy(in.data, pairs.data(), pairs.size() * sizeof(Float));
  client.bind({ShaderClient::storage(in), ShaderClient::storage(out)});
  const std::string bits = std::to_string(8 * sizeof(Float));
  struct Operation {
    const char* op;
    Float (*apply)(Float, Float);
  };
  const Operation operations[] = {{"OpFAdd", [](Float a, Float c) { return a + c; }},
                                  {"OpFSub", [](Float a, Float c) { return a - c; }},
                                  {"OpFMul", [](Float a, Float c) { return a * c; }},
                                  {"OpFDiv", [](Float a, Float c) { return a / c; }}};
  for (const Operation& operation : operations) {
    const Words words =
        assembly(float_program(8 * sizeof(Float), operation.op, kAllModes(bits), kAllCapabilities + more_capabilities));
    ASSERT_EQ(client.compute(words, static_cast<uint32_t>(count / 16)), VK_SUCCESS);
    for (size_t i = 0; i < count; ++i) {
      const Float want = operation.apply(pairs[2 * i], pairs[2 * i + 1]), got = out.as<Float>()[i];
      if (std::isnan(want))
        EXPECT_TRUE(std::isnan(got)) << operation.op << ' ' << pairs[2 * i] << ' ' << pairs[2 * i + 1];
      else
        EXPECT_EQ(std::bit_cast<Bits>(got), std::bit_cast<Bits>(want))
            << operation.op << ' ' << pairs[2 * i] << ' ' << pairs[2 * i + 1];
    }
  }
}

TEST(IcdShaderFeatures, FloatControlsKeepDenormalsZerosAndRounding) {
  FloatControlsClient client;
  const auto p = client.properties();
  EXPECT_TRUE(p.shaderDenormPreserveFloat16 && p.shaderDenormPreserveFloat32 && p.shaderDenormPreserveFloat64);
  EXPECT_TRUE(p.shaderRoundingModeRTEFloat16 && p.shaderRoundingModeRTEFloat32 && p.shaderRoundingModeRTEFloat64);
  EXPECT_TRUE(p.shaderSignedZeroInfNanPreserveFloat32 && p.shaderSignedZeroInfNanPreserveFloat64);
  check_float_controls<float, uint32_t>(client, "");
  check_float_controls<double, uint64_t>(client, "OpCapability Float64\n");
}

// Halves against floats rounded by the conversion: sums and products of halves are exact in binary32 or rounded once from it.
TEST(IcdShaderFeatures, FloatControlsOfHalves) {
  FloatControlsClient client;
  const auto in = client.buffer(32 * 16), out = client.buffer(32 * 16);
  const uint16_t pairs[16][2] = {{0x0001, 0x0001}, {0x0001, 0x8001}, {0x03ff, 0x0001}, {0x8000, 0x8000},
                                 {0x0400, 0x8001}, {0x7c00, 0x3c00}, {0x7bff, 0x7bff}, {0x3c00, 0x1000},
                                 {0x3c00, 0x1001}, {0x3c01, 0x1000}, {0x0000, 0x8000}, {0xfc00, 0x7bff},
                                 {0x7bff, 0x4c00}, {0x7bff, 0x4bff}, {0x0010, 0x0020}, {0x8001, 0x8002}};
  const uint16_t sums[16] = {0x0002, 0x0000, 0x0400, 0x8000, 0x03ff, 0x7c00, 0x7c00, 0x3c00,
                             0x3c01, 0x3c02, 0x0000, 0xfc00, 0x7c00, 0x7bff, 0x0030, 0x8003};
  std::memcpy(in.data, pairs, sizeof(pairs));
  client.bind({ShaderClient::storage(in), ShaderClient::storage(out)});
  const Words words = assembly(float_program(
      16, "OpFAdd", kAllModes("16"),
      kAllCapabilities +
          "OpCapability Float16\nOpCapability StorageUniformBufferBlock16\nOpExtension \"SPV_KHR_16bit_storage\"\n"));
  ASSERT_EQ(client.compute(words, 1), VK_SUCCESS);
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(out.as<uint16_t>()[i], sums[i]) << i;
}

// What is not advertised is refused, by name.
TEST(IcdShaderFeatures, OtherFloatControlsAreRefused) {
  breaks_on_purpose({"VUID-RuntimeSpirv-shaderDenormFlushToZeroFloat32-06300",
                     "VUID-RuntimeSpirv-shaderRoundingModeRTZFloat32-06306", "VUID-VkShaderModuleCreateInfo-pCode-01091"});
  FloatControlsClient client;
  const auto p = client.properties();
  EXPECT_FALSE(p.shaderDenormFlushToZeroFloat16 || p.shaderDenormFlushToZeroFloat32 || p.shaderDenormFlushToZeroFloat64);
  EXPECT_FALSE(p.shaderRoundingModeRTZFloat16 || p.shaderRoundingModeRTZFloat32 || p.shaderRoundingModeRTZFloat64);
  const auto in = client.buffer(64), out = client.buffer(64);
  client.bind({ShaderClient::storage(in), ShaderClient::storage(out)});
  for (const std::string mode : {"DenormFlushToZero", "RoundingModeRTZ"}) {
    const Words words =
        assembly(float_program(32, "OpFAdd", "OpExecutionMode %main " + mode + " 32\n", "OpCapability " + mode + "\n"));
    EXPECT_NE(client.compute(words, 1), VK_SUCCESS) << mode;
  }
}

// ---- one extension each -----------------------------------------------------------------------------------------------------

// GLSL compute programs that fill `out` (64 words) with 1 where they find what they should.
void expect_ones(ShaderClient& client, const Words& words, uint32_t count = 64) {
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  ASSERT_EQ(client.compute(words, 1), VK_SUCCESS);
  for (uint32_t i = 0; i < count; ++i) EXPECT_EQ(out.as<uint32_t>()[i], 1u) << i;
}
const std::string kOnes = "layout(binding = 0) buffer Out { uint ok[]; };";

TEST(IcdShaderFeatures, WorkgroupMemoryStartsAtZero) {
  ShaderClient client(nullptr, {}, {VK_KHR_ZERO_INITIALIZE_WORKGROUP_MEMORY_EXTENSION_NAME});
  const Words words = glsl(kCompute,
                           "#extension GL_EXT_null_initializer : require\nlayout(local_size_x = 64) in;" + kOnes +
                               "shared uint a[64] = {}; shared vec4 b[64] = {}; void main() { uint i = gl_LocalInvocationIndex;"
                               "bool zero = a[i] == 0u && b[63u - i] == vec4(0); barrier(); a[i] = ~i; b[i] = vec4(i); barrier();"
                               "ok[i] = uint(zero && a[63u - i] != 0u); }",
                           "vulkan1.1");
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  for (int again = 0; again < 2; ++again) {  // the second time the memory has been used
    ASSERT_EQ(client.compute(words, 20), VK_SUCCESS);
    for (uint32_t i = 0; i < 64; ++i) EXPECT_EQ(out.as<uint32_t>()[i], 1u) << i;
  }
}

TEST(IcdShaderFeatures, VulkanMemoryModel) {
  ShaderClient client(nullptr, {}, {VK_KHR_VULKAN_MEMORY_MODEL_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  // Message passing between workgroups: whoever sees the flag sees the data.
  const auto out = client.buffer(256), data = client.buffer(8192);
  client.bind({ShaderClient::storage(out), ShaderClient::storage(data)});
  const Words words = glsl(kCompute, R"(#pragma use_vulkan_memory_model
#extension GL_KHR_memory_scope_semantics : require
layout(local_size_x = 1) in; layout(binding = 0) buffer Out { uint ok[]; }; layout(binding = 1) nonprivate buffer Data { uint flag; uint data[]; };
void main() { uint g = gl_WorkGroupID.x;
  if (g % 2u == 0u) { for (uint i = 0u; i < 16u; ++i) data[g / 2u * 16u + i] = 5u;
    atomicAdd(flag, 1u, gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelease | gl_SemanticsMakeAvailable); return; }
  uint seen = atomicLoad(flag, gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsAcquire | gl_SemanticsMakeVisible);
  uint sum = 0u; for (uint i = 0u; i < 1024u; ++i) sum += data[i]; ok[g / 2u] = uint(sum >= seen * 80u); })",
                           "vulkan1.1");
  ASSERT_EQ(client.compute(words, 128), VK_SUCCESS);
  for (uint32_t i = 0; i < 64; ++i) EXPECT_EQ(out.as<uint32_t>()[i], 1u) << i;
}

TEST(IcdShaderFeatures, Spirv14AndNonSemanticInfo) {
  ShaderClient client(nullptr, {},
                      {VK_KHR_SPIRV_1_4_EXTENSION_NAME, VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME,
                       VK_KHR_SHADER_NON_SEMANTIC_INFO_EXTENSION_NAME});
  const std::string text =
      "layout(local_size_x = 64) in;" + kOnes +
      "struct S { uint a[3]; uint b; }; layout(binding = 1) uniform U { uint u; }; void main() { uint i = "
      "gl_LocalInvocationIndex; S s = S(uint[](i, "
      "i, i), 2u), r = i > 5u ? s : S(uint[](1u, 2u, 3u), 2u); debug_line ok[i] = uint(r.b == 2u && (i <= 5u || r.a[2] == i)); }";
  const auto with = [&](const std::string& line) {
    std::string out = text;
    return out.replace(out.find("debug_line"), 10, line);
  };
  expect_ones(client, glsl(kCompute, with(""), "vulkan1.1 --target-env spirv1.4"));
  expect_ones(client,
              glsl(kCompute, "#extension GL_EXT_debug_printf : require\n" + with("debugPrintfEXT(\"%u\", i);"), "vulkan1.1"));
}

TEST(IcdShaderFeatures, SubgroupExtendedTypes) {
  ShaderClient client(nullptr, {},
                      {VK_KHR_SHADER_SUBGROUP_EXTENDED_TYPES_EXTENSION_NAME, VK_KHR_SHADER_FLOAT16_INT8_EXTENSION_NAME});
  std::string text =
      "#extension GL_KHR_shader_subgroup_arithmetic : require\n#extension GL_KHR_shader_subgroup_shuffle : require\n#extension "
      "GL_KHR_shader_subgroup_vote : require\n";
  for (const char* type : {"int8", "int16", "int64", "float16"}) {
    text += "#extension GL_EXT_shader_explicit_arithmetic_types_" + std::string(type) +
            " : require\n#extension GL_EXT_shader_subgroup_extended_types_" + type + " : require\n";
  }
  text += "layout(local_size_x = 64) in;" + kOnes +
          R"(void main() { uint i = gl_LocalInvocationIndex, lane = gl_SubgroupInvocationID; bool fine = true;
    fine = fine && subgroupAdd(uint8_t(lane * 20u)) == uint8_t(2400u); fine = fine && subgroupMax(int8_t(int(lane) - 20)) == int8_t(-5);
    fine = fine && subgroupAdd(uint16_t(lane * 5000u)) == uint16_t(600000u); fine = fine && subgroupMin(int16_t(300 - int(lane))) == int16_t(285);
    fine = fine && subgroupAdd(uint64_t(lane) << 40) == (uint64_t(120) << 40); fine = fine && subgroupXor(int64_t(lane) << 33) == int64_t(0);
    fine = fine && subgroupAdd(float16_t(lane)) == float16_t(120.0); fine = fine && subgroupInclusiveAdd(float16_t(1.0)) == float16_t(lane + 1u);
    fine = fine && subgroupShuffleXor(uint64_t(lane) << 35, 3u) == uint64_t(lane ^ 3u) << 35; fine = fine && subgroupShuffle(uint8_t(lane), 9u) == uint8_t(9u);
    fine = fine && subgroupAllEqual(int16_t(-3)) && !subgroupAllEqual(uint8_t(lane)); ok[i] = uint(fine); })";
  expect_ones(client, glsl(kCompute, text, "vulkan1.1"));
}

// The older instructions of SPV_KHR_shader_ballot and SPV_KHR_subgroup_vote.
TEST(IcdShaderFeatures, OlderBallotsAndVotes) {
  ShaderClient client(nullptr, {}, {VK_EXT_SHADER_SUBGROUP_BALLOT_EXTENSION_NAME, VK_EXT_SHADER_SUBGROUP_VOTE_EXTENSION_NAME});
  const std::string text =
      R"(#extension GL_ARB_shader_ballot : require
#extension GL_ARB_shader_group_vote : require
#extension GL_ARB_gpu_shader_int64 : require
layout(local_size_x = 64) in;)" +
      kOnes +
      R"(void main() { uint i = gl_LocalInvocationIndex, lane = gl_SubGroupInvocationARB; bool fine = gl_SubGroupSizeARB == 16u;
    fine = fine && ballotARB(lane % 3u == 0u) == uint64_t(0x9249u); fine = fine && readInvocationARB(lane * 7u, 5u) == 35u; fine = fine && readFirstInvocationARB(i) == i / 16u * 16u;
    fine = fine && anyInvocationARB(lane == 4u) && !anyInvocationARB(lane == 16u) && allInvocationsARB(lane < 16u) && !allInvocationsARB(lane < 15u);
    fine = fine && allInvocationsEqualARB(i / 16u == gl_WorkGroupID.x + i / 16u); if (lane > 3u) fine = fine && ballotARB(true) == uint64_t(0xfff0u); ok[i] = uint(fine); })";
  expect_ones(client, glsl(kCompute, text, "vulkan1.0"));
}

// ---- integer dot products -----------------------------------------------------------------------------------------------------

std::string dot_program(const std::string& body) {
  return R"(OpCapability Shader
OpCapability DotProduct
OpCapability DotProductInput4x8Bit
OpCapability DotProductInput4x8BitPacked
OpCapability DotProductInputAll
OpCapability Int8
OpExtension "SPV_KHR_integer_dot_product"
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main" %id
OpExecutionMode %main LocalSize 16 1 1
OpDecorate %id BuiltIn LocalInvocationIndex
OpDecorate %array ArrayStride 4
OpDecorate %block BufferBlock
OpMemberDecorate %block 0 Offset 0
OpDecorate %in DescriptorSet 0
OpDecorate %in Binding 0
OpDecorate %out DescriptorSet 0
OpDecorate %out Binding 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
%uint = OpTypeInt 32 0
%int = OpTypeInt 32 1
%byte = OpTypeInt 8 0
%byte4 = OpTypeVector %byte 4
%int2 = OpTypeVector %int 2
%array = OpTypeRuntimeArray %uint
%block = OpTypeStruct %array
%pblock = OpTypePointer Uniform %block
%puint = OpTypePointer Uniform %uint
%pid = OpTypePointer Input %uint
%in = OpVariable %pblock Uniform
%out = OpVariable %pblock Uniform
%id = OpVariable %pid Input
%n0 = OpConstant %uint 0
%n3 = OpConstant %uint 3
%n1 = OpConstant %uint 1
%n2 = OpConstant %uint 2
%main = OpFunction %void None %fn
%begin = OpLabel
%i = OpLoad %uint %id
%j = OpIMul %uint %i %n3
%j1 = OpIAdd %uint %j %n1
%j2 = OpIAdd %uint %j %n2
%pa = OpAccessChain %puint %in %n0 %j
%pb = OpAccessChain %puint %in %n0 %j1
%pc = OpAccessChain %puint %in %n0 %j2
%a = OpLoad %uint %pa
%b = OpLoad %uint %pb
%c = OpLoad %uint %pc
%ia = OpBitcast %int %a
%ib = OpBitcast %int %b
%ic = OpBitcast %int %c
%av = OpBitcast %byte4 %a
%bv = OpBitcast %byte4 %b
)" + body +
         R"(
%pr = OpAccessChain %puint %out %n0 %i
OpStore %pr %r
OpReturn
OpFunctionEnd
)";
}

TEST(IcdShaderFeatures, IntegerDotProducts) {
  ShaderClient client(nullptr, {}, {VK_KHR_SHADER_INTEGER_DOT_PRODUCT_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  uint32_t data[16][3];
  for (uint32_t i = 0; i < 16; ++i) {
    for (uint32_t k = 0; k < 3; ++k) data[i][k] = (i * 3 + k + 1) * 2654435761u;
  }
  data[0][0] = data[0][1] = 0x80808080u, data[0][2] = 0x7fffffffu;
  data[1][0] = data[1][1] = 0xffffffffu, data[1][2] = 0xffffffffu;
  data[2][0] = 0x80808080u, data[2][1] = 0x7f7f7f7fu, data[2][2] = 0x80000000u;
  const auto in = client.buffer(sizeof(data)), out = client.buffer(64);
  std::memcpy(in.data, data, sizeof(data));
  client.bind({ShaderClient::storage(in), ShaderClient::storage(out)});
  const auto dot = [](uint32_t a, uint32_t b, bool a_signed, bool b_signed) {
    int64_t sum = 0;
    for (int k = 0; k < 32; k += 8) {
      const int64_t x = a_signed ? int8_t(a >> k) : uint8_t(a >> k), y = b_signed ? int8_t(b >> k) : uint8_t(b >> k);
      sum += x * y;
    }
    return sum;
  };
  const auto saturate = [](int64_t v) { return static_cast<uint32_t>(std::clamp<int64_t>(v, INT32_MIN, INT32_MAX)); };
  struct Case {
    const char* body;
    std::function<uint32_t(const uint32_t*)> want;
  };
  const Case cases[] = {
      {"%s = OpSDotKHR %int %a %b PackedVectorFormat4x8BitKHR\n%r = OpBitcast %uint %s",
       [&](const uint32_t* d) { return static_cast<uint32_t>(dot(d[0], d[1], true, true)); }},
      {"%r = OpUDotKHR %uint %a %b PackedVectorFormat4x8BitKHR",
       [&](const uint32_t* d) { return static_cast<uint32_t>(dot(d[0], d[1], false, false)); }},
      {"%s = OpSUDotKHR %int %a %b PackedVectorFormat4x8BitKHR\n%r = OpBitcast %uint %s",
       [&](const uint32_t* d) { return static_cast<uint32_t>(dot(d[0], d[1], true, false)); }},
      {"%s = OpSDotAccSatKHR %int %a %b %ic PackedVectorFormat4x8BitKHR\n%r = OpBitcast %uint %s",
       [&](const uint32_t* d) { return saturate(dot(d[0], d[1], true, true) + int32_t(d[2])); }},
      {"%r = OpUDotAccSatKHR %uint %a %b %c PackedVectorFormat4x8BitKHR",
       [&](const uint32_t* d) { return static_cast<uint32_t>(std::min<int64_t>(dot(d[0], d[1], false, false) + d[2], ~0u)); }},
      {"%s = OpSUDotAccSatKHR %int %a %b %ic PackedVectorFormat4x8BitKHR\n%r = OpBitcast %uint %s",
       [&](const uint32_t* d) { return saturate(dot(d[0], d[1], true, false) + int32_t(d[2])); }},
      {"%s = OpSDotKHR %int %av %bv\n%r = OpBitcast %uint %s",
       [&](const uint32_t* d) { return static_cast<uint32_t>(dot(d[0], d[1], true, true)); }},
      {"%r = OpUDotKHR %uint %av %bv", [&](const uint32_t* d) { return static_cast<uint32_t>(dot(d[0], d[1], false, false)); }},
      {"%x = OpCompositeConstruct %int2 %ia %ib\n%y = OpCompositeConstruct %int2 %ic %ia\n%s = OpSDotKHR %int %x %y\n%r = "
       "OpBitcast %uint %s",
       [&](const uint32_t* d) { return d[0] * d[2] + d[1] * d[0]; }},
  };
  for (const Case& c : cases) {
    ASSERT_EQ(client.compute(assembly(dot_program(c.body)), 1), VK_SUCCESS) << c.body;
    for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(out.as<uint32_t>()[i], c.want(data[i])) << c.body << ' ' << i;
  }
}

// ---- discards -----------------------------------------------------------------------------------------------------------------

// Fragments of even columns end or become helpers: nothing of them is seen, but derivatives of their neighbours are right.
TEST(IcdShaderFeatures, TerminateAndDemote) {
  ShaderClient client(
      nullptr, {}, {VK_KHR_SHADER_TERMINATE_INVOCATION_EXTENSION_NAME, VK_EXT_SHADER_DEMOTE_TO_HELPER_INVOCATION_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const struct {
    const char *extension, *discard, *after;
  } cases[] = {
      {"GL_EXT_terminate_invocation", "terminateInvocation;", "float slope = 1.0; bool helper = false;"},
      {"GL_EXT_demote_to_helper_invocation", "demote;", "float slope = dFdx(x * x + y); bool helper = helperInvocationEXT();"}};
  for (const auto& c : cases) {
    const auto count = client.buffer(64);
    client.bind({ShaderClient::storage(count)});
    Words target;
    const Words fragment = glsl(kFragment,
                                "#extension " + std::string(c.extension) + " : require\n" +
                                    R"(layout(location = 0) out uvec4 r; layout(binding = 0) buffer Count { uint n; };
      void main() { float x = gl_FragCoord.x - 0.5, y = gl_FragCoord.y; if (int(x) % 2 == 0) )" +
                                    c.discard + c.after + R"(
        atomicAdd(n, 1u); r = uvec4(1, helper ? 1 : 0, uint(slope), 9); })",
                                "vulkan1.1");
    ASSERT_EQ(client.draw(ShaderClient::covering_vertex(), fragment, 3, &target), VK_SUCCESS);
    EXPECT_EQ(count.as<uint32_t>()[0], kTargetSize * kTargetSize / 2) << c.discard;
    for (uint32_t y = 0; y < kTargetSize; ++y) {
      for (uint32_t x = 0; x < kTargetSize; ++x) {
        const uint32_t* pixel = &target[4 * (y * kTargetSize + x)];
        const uint32_t slope = c.after[14] == '1' ? 1 : 2 * (x - 1) + 1;  // of x², between the columns x - 1 and x
        const bool seen = x % 2 == 1;
        EXPECT_EQ(pixel[0], seen ? 1u : 0u) << c.discard << x << ' ' << y;
        EXPECT_EQ(pixel[1], 0u);
        EXPECT_EQ(pixel[2], seen ? slope : 0u) << c.discard << x << ' ' << y;
      }
    }
  }
}

// textureSamples (OpImageQuerySamples) of images with every count.
TEST(IcdShaderFeatures, SampleCountsOfImages) {
  ShaderClient client;
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.extent = {4, 4, 1};
    info.mipLevels = info.arrayLayers = 1;
    info.samples = static_cast<VkSampleCountFlagBits>(samples);
    info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    VkImage image = VK_NULL_HANDLE;
    ASSERT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(client, GetImageMemoryRequirements)(client.device, image, &requirements);
    ASSERT_EQ(VK(client, BindImageMemory)(client.device, image, client.memory(requirements.size), 0), VK_SUCCESS);
    client.defer([&client, image] { VK(client, DestroyImage)(client.device, image, nullptr); });
    client.to_general(image, info.format);
    const auto out = client.buffer(64);
    client.bind(
        {{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, VK_NULL_HANDLE, client.view(image, info.format)}, ShaderClient::storage(out)});
    const Words words =
        glsl(kCompute,
             "#extension GL_ARB_shader_texture_image_samples : require\n#extension GL_EXT_samplerless_texture_functions : "
             "require\nlayout(local_size_x = 1) in; layout(binding = 0) uniform texture2DMS t; layout(binding = 1) buffer "
             "Out { int n; }; void main() { n = textureSamples(t) + 100 * textureSize(t).x; }");
    ASSERT_EQ(client.compute(words, 1), VK_SUCCESS);
    EXPECT_EQ(out.as<uint32_t>()[0], samples + 400);
  }
}

// ---- subgroups of draws -------------------------------------------------------------------------------------------------------

const std::string kSubgroups =
    "#extension GL_KHR_shader_subgroup_basic : require\n#extension GL_KHR_shader_subgroup_ballot : require\n"
    "#extension GL_KHR_shader_subgroup_vote : require\n#extension GL_KHR_shader_subgroup_arithmetic : require\n"
    "#extension GL_KHR_shader_subgroup_quad : require\n#extension GL_KHR_shader_subgroup_shuffle : require\n";

// Counts by elected invocations are the counts of fragments, with triangles that cover blocks in part, and discards.
TEST(IcdShaderFeatures, FragmentSubgroupsHaveNoHelpers) {
  ShaderClient client;
  VkPhysicalDeviceSubgroupProperties properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &properties, {}};
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &all);
  EXPECT_EQ(properties.supportedStages, VkShaderStageFlags{kVertex | kFragment | kCompute});
  const Words vertex =
      glsl(kVertex,
           "void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 0.93 : -0.81, gl_VertexIndex == 2 ? 0.77 : -0.9, 0, 1); }");
  for (const std::string discard : {"", "if ((x + y) % 3u == 0u) discard;"}) {
    SCOPED_TRACE(discard);
    const auto out = client.buffer(256);
    client.bind({ShaderClient::storage(out)});
    const Words fragment = glsl(
        kFragment,
        kSubgroups +
            R"(layout(location = 0) out uvec4 r; layout(binding = 0) buffer Out { uint n, by_ballot, by_add, sum, all_wrong, rounds; };
      void main() { uint x = uint(gl_FragCoord.x), y = uint(gl_FragCoord.y); float slope = dFdx(gl_FragCoord.x);)" +
            discard + R"(
        atomicAdd(n, 1u); uint ones = subgroupAdd(1u), weight = subgroupAdd(x * 100u + y); uvec4 ballot = subgroupBallot(true);
        if (subgroupElect()) { atomicAdd(by_ballot, subgroupBallotBitCount(ballot)); atomicAdd(by_add, ones); atomicAdd(sum, weight); }
        if (subgroupAny(gl_HelperInvocation) || !subgroupAll(!gl_HelperInvocation)) atomicAdd(all_wrong, 1u);
        uint wanted = x % 5u, mine = 0u; for (int i = 0; i < 64; ++i) { uint first = subgroupBroadcastFirst(wanted); if (first == wanted) { mine = first + 1u; break; } }
        if (mine != x % 5u + 1u) atomicAdd(rounds, 1u);
        r = uvec4(1, ones, weight, uint(slope)); })",
        "vulkan1.1");
    Words target;
    ASSERT_EQ(client.draw(vertex, fragment, 3, &target), VK_SUCCESS);
    uint32_t fragments = 0, sum = 0;
    for (uint32_t i = 0; i < kTargetSize * kTargetSize; ++i) {
      if (target[4 * i] == 0) continue;
      ++fragments;
      sum += i % kTargetSize * 100 + i / kTargetSize;
      EXPECT_EQ(target[4 * i + 3], 1u) << "a derivative";
      EXPECT_GE(target[4 * i + 1], 1u);
    }
    EXPECT_GT(fragments, 30u);
    const uint32_t want[] = {fragments, fragments, fragments, sum, 0, 0};
    for (uint32_t i = 0; i < 6; ++i) EXPECT_EQ(out.as<uint32_t>()[i], want[i]) << i;
  }
}

// Quads of fragments: neighbours' values, those of helpers included.
TEST(IcdShaderFeatures, FragmentQuads) {
  ShaderClient client;
  client.bind({});
  const Words vertex =
      glsl(kVertex,
           "void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 0.93 : -0.81, gl_VertexIndex == 2 ? 0.77 : -0.9, 0, 1); }");
  const Words fragment = glsl(
      kFragment,
      kSubgroups + R"(layout(location = 0) out uvec4 r; void main() { uint v = uint(gl_FragCoord.x) + 64u * uint(gl_FragCoord.y);
    r = uvec4(subgroupQuadSwapHorizontal(v), subgroupQuadSwapVertical(v), subgroupQuadSwapDiagonal(v), subgroupQuadBroadcast(v, 2u) + 1u); })",
      "vulkan1.1");
  Words target;
  ASSERT_EQ(client.draw(vertex, fragment, 3, &target), VK_SUCCESS);
  uint32_t seen = 0;
  for (uint32_t y = 0; y < kTargetSize; ++y) {
    for (uint32_t x = 0; x < kTargetSize; ++x) {
      const uint32_t* pixel = &target[4 * (y * kTargetSize + x)];
      if (pixel[3] == 0) continue;
      ++seen;
      EXPECT_EQ(pixel[0], (x ^ 1) + 64 * y);
      EXPECT_EQ(pixel[1], x + 64 * (y ^ 1));
      EXPECT_EQ(pixel[2], (x ^ 1) + 64 * (y ^ 1));
      EXPECT_EQ(pixel[3], (x & ~1u) + 64 * (y | 1) + 1);
    }
  }
  EXPECT_GT(seen, 30u);
}

TEST(IcdShaderFeatures, VertexSubgroups) {
  ShaderClient client;
  const auto out = client.buffer(256);
  client.bind({ShaderClient::storage(out)});
  const Words vertex = glsl(kVertex, kSubgroups + R"(layout(binding = 0) buffer Out { uint n, by_ballot, sum, by_add, wrong; };
    void main() { uint v = uint(gl_VertexIndex) + 1u; atomicAdd(n, 1u); atomicAdd(sum, v); uvec4 ballot = subgroupBallot(true); uint weight = subgroupAdd(v);
      if (subgroupElect()) { atomicAdd(by_ballot, subgroupBallotBitCount(ballot)); atomicAdd(by_add, weight); }
      if (subgroupBroadcastFirst(v) != subgroupMin(v) || subgroupInclusiveAdd(1u) != gl_SubgroupInvocationID + 1u) atomicAdd(wrong, 1u);
      gl_Position = vec4(0, 0, 0, 1); gl_PointSize = 1.0; })",
                            "vulkan1.1");
  ASSERT_EQ(client.draw(vertex, glsl(kFragment, "layout(location = 0) out uvec4 r; void main() { r = uvec4(1); }"), 77, nullptr,
                        VK_PRIMITIVE_TOPOLOGY_POINT_LIST),
            VK_SUCCESS);
  const uint32_t* got = out.as<uint32_t>();
  EXPECT_GE(got[0], 77u);
  EXPECT_EQ(got[1], got[0]);
  EXPECT_EQ(got[3], got[2]);
  EXPECT_EQ(got[4], 0u);
}

}  // namespace
}  // namespace pineda::test
