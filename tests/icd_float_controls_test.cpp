// VK_KHR_shader_float_controls through the whole driver: each execution mode that is advertised, and the refusal of the others.
#include <bit>
#include <cmath>
#include <limits>

#include "shader_client.h"

namespace pineda::test {
namespace {

// out[i] = in[2 i] op in[2 i + 1] for one operation and one float width, under the execution modes given.
std::string float_program(uint32_t bits, const std::string& op, const std::string& modes, const std::string& capabilities) {
  return "OpCapability Shader\n" + capabilities + "OpExtension \"SPV_KHR_float_controls\"" +
         buffers_head("GlobalInvocationId", modes, bits / 8) + "%float = OpTypeFloat " + std::to_string(bits) + R"(
%uint = OpTypeInt 32 0
%uint3 = OpTypeVector %uint 3
)" + buffers_variables("%float", "%uint3") +
         R"(%zero = OpConstant %uint 0
%one = OpConstant %uint 1
%two = OpConstant %uint 2
%main = OpFunction %void None %fn
%begin = OpLabel
%ids = OpLoad %uint3 %id
%i = OpCompositeExtract %uint %ids 0
%j = OpIMul %uint %i %two
%k = OpIAdd %uint %j %one
%pa = OpAccessChain %pelement %in %zero %j
%pb = OpAccessChain %pelement %in %zero %k
%a = OpLoad %float %pa
%b = OpLoad %float %pb
%r = )" + op +
         R"( %float %a %b
%pr = OpAccessChain %pelement %out %zero %i
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

}  // namespace
}  // namespace pineda::test
