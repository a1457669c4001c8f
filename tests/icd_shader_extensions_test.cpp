// Shader extensions of one feature each, through the whole driver.
#include <algorithm>
#include <functional>

#include "shader_client.h"

namespace pineda::test {
namespace {

constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;

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

std::string dot_program(const std::string& body) {
  return R"(OpCapability Shader
OpCapability DotProduct
OpCapability DotProductInput4x8Bit
OpCapability DotProductInput4x8BitPacked
OpCapability DotProductInputAll
OpCapability Int8
OpExtension "SPV_KHR_integer_dot_product")" +
         buffers_head("LocalInvocationIndex", "", 4) + R"(%uint = OpTypeInt 32 0
%int = OpTypeInt 32 1
%byte = OpTypeInt 8 0
%byte4 = OpTypeVector %byte 4
%int2 = OpTypeVector %int 2
)" + buffers_variables("%uint", "%uint") +
         R"(%n0 = OpConstant %uint 0
%n3 = OpConstant %uint 3
%n1 = OpConstant %uint 1
%n2 = OpConstant %uint 2
%main = OpFunction %void None %fn
%begin = OpLabel
%i = OpLoad %uint %id
%j = OpIMul %uint %i %n3
%j1 = OpIAdd %uint %j %n1
%j2 = OpIAdd %uint %j %n2
%pa = OpAccessChain %pelement %in %n0 %j
%pb = OpAccessChain %pelement %in %n0 %j1
%pc = OpAccessChain %pelement %in %n0 %j2
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
%pr = OpAccessChain %pelement %out %n0 %i
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

}  // namespace
}  // namespace pineda::test
