// Which of SPIR-V's instructions are translated, measured against the grammar that spirv-headers ships.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "compiler/spirv/opcodes.h"
#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

const nlohmann::json& grammar() {
  static const nlohmann::json parsed = [] {
    std::ifstream in("/usr/include/spirv/unified1/spirv.core.grammar.json");
    return in ? nlohmann::json::parse(in) : nlohmann::json();
  }();
  return parsed;
}

// The capabilities of the stages and features that Pineda has, all but those of vendors.
const std::set<std::string> kListed = {
    "Shader",
    "Matrix",
    "Int8",
    "Int16",
    "Int64",
    "Float16",
    "Float64",
    "Int64Atomics",
    "StorageBuffer8BitAccess",
    "UniformAndStorageBuffer8BitAccess",
    "StoragePushConstant8",
    "StorageBuffer16BitAccess",
    "UniformAndStorageBuffer16BitAccess",
    "StoragePushConstant16",
    "StorageInputOutput16",
    "Image1D",
    "Sampled1D",
    "ImageCubeArray",
    "SampledCubeArray",
    "ImageGatherExtended",
    "MinLod",
    "StorageImageExtendedFormats",
    "StorageImageReadWithoutFormat",
    "StorageImageWriteWithoutFormat",
    "ImageQuery",
    "SampledBuffer",
    "ImageBuffer",
    "InputAttachment",
    "DerivativeControl",
    "SampleRateShading",
    "InterpolationFunction",
    "ClipDistance",
    "CullDistance",
    "DrawParameters",
    "MultiView",
    "DeviceGroup",
    "StencilExportEXT",
    "UniformBufferArrayDynamicIndexing",
    "SampledImageArrayDynamicIndexing",
    "StorageBufferArrayDynamicIndexing",
    "StorageImageArrayDynamicIndexing",
    "UniformTexelBufferArrayDynamicIndexing",
    "StorageTexelBufferArrayDynamicIndexing",
    "ShaderNonUniform",
    "RuntimeDescriptorArray",
    "UniformBufferArrayNonUniformIndexing",
    "SampledImageArrayNonUniformIndexing",
    "StorageBufferArrayNonUniformIndexing",
    "StorageImageArrayNonUniformIndexing",
    "UniformTexelBufferArrayNonUniformIndexing",
    "StorageTexelBufferArrayNonUniformIndexing",
    "VariablePointersStorageBuffer",
    "VariablePointers",
    "PhysicalStorageBufferAddresses",
    "VulkanMemoryModel",
    "VulkanMemoryModelDeviceScope",
    "GroupNonUniform",
    "GroupNonUniformVote",
    "GroupNonUniformArithmetic",
    "GroupNonUniformBallot",
    "GroupNonUniformShuffle",
    "GroupNonUniformShuffleRelative",
    "GroupNonUniformClustered",
    "GroupNonUniformQuad",
    "GroupNonUniformRotateKHR",
    "SubgroupBallotKHR",
    "SubgroupVoteKHR",
    "DotProduct",
    "DotProductInputAll",
    "DotProductInput4x8Bit",
    "DotProductInput4x8BitPacked",
    "DemoteToHelperInvocation",
    "DenormPreserve",
    "SignedZeroInfNanPreserve",
    "RoundingModeRTE",
    "AtomicFloat32AddEXT",
    "AtomicFloat64AddEXT",
};

// Instructions that only describe the program.
const std::set<std::string> kSkipped = {"OpSourceContinued", "OpSource", "OpSourceExtension", "OpName",
                                        "OpMemberName",      "OpString", "OpModuleProcessed"};

bool is_listed(const nlohmann::json& op) {
  if (!op.contains("capabilities")) return true;
  return std::ranges::any_of(op["capabilities"], [](const auto& c) { return kListed.contains(c.template get<std::string>()); });
}

spv::Op opcode(const nlohmann::json& op) { return static_cast<spv::Op>(op["opcode"].get<uint32_t>()); }

TEST(SpirvCoverage, EveryInstructionOfTheListedCapabilitiesIsTranslated) {
  ASSERT_FALSE(grammar().is_null()) << "spirv-headers is not installed";
  uint32_t translated = 0;
  for (const auto& op : grammar()["instructions"]) {
    const auto name = op["opname"].get<std::string>();
    if (!is_listed(op) || kSkipped.contains(name)) continue;
    EXPECT_NE(find_op(opcode(op)), nullptr) << name;
    ++translated;
  }
  EXPECT_GE(translated, 260u);
}

TEST(SpirvCoverage, OtherInstructionsAreRefusedByNameAndCapability) {
  uint32_t refused = 0;
  for (const auto& op : grammar()["instructions"]) {
    if (is_listed(op) || find_op(opcode(op))) continue;
    ++refused;
    EXPECT_NE(op_name(opcode(op)).find("Op"), std::string::npos) << op["opname"];
    const std::string why = why_unsupported(opcode(op));
    const bool named = std::ranges::any_of(
        op["capabilities"], [&](const auto& c) { return why.find(c.template get<std::string>()) != std::string::npos; });
    EXPECT_TRUE(named) << op["opname"] << ": " << why;
  }
  EXPECT_GE(refused, 300u);
}

Words header() { return {spv::MagicNumber, 0x00010600, 0, 100, 0}; }

// A module that declares any capability is accepted so far or refused by the capability's name.
TEST(SpirvCoverage, CapabilitiesAreAcceptedOrRefusedByName) {
  for (const auto& kind : grammar()["operand_kinds"]) {
    if (kind["kind"] != "Capability") continue;
    for (const auto& capability : kind["enumerants"]) {
      const auto name = capability["enumerant"].get<std::string>();
      Words words = header();
      words.insert(words.end(), {2u << 16 | spv::OpCapability, capability["value"].get<uint32_t>()});
      const auto module = parse({.words = words, .entry_point = "main", .stage = VK_SHADER_STAGE_COMPUTE_BIT});
      ASSERT_FALSE(module) << name << ": a module without functions";
      const bool refused = module.error().text.find("OpCapability") != std::string::npos;
      if (kListed.contains(name)) {
        EXPECT_FALSE(refused) << module.error().text;
      }
      if (!refused) continue;
      // Aliases have their first name.
      const auto& all = kind["enumerants"];
      const auto first = std::ranges::find_if(all, [&](const auto& c) { return c["value"] == capability["value"]; });
      EXPECT_NE(module.error().text.find((*first)["enumerant"].template get<std::string>()), std::string::npos)
          << module.error().text;
    }
  }
}

// An instruction whose capability nobody declared.
TEST(SpirvCoverage, AnInstructionIsRefusedByNameAndCapability) {
  FakeStage stage;
  const std::string text = R"(OpCapability Shader
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main "main"
OpExecutionMode %main LocalSize 1 1 1
%void = OpTypeVoid
%fn = OpTypeFunction %void
%main = OpFunction %void None %fn
%begin = OpLabel
OpEmitVertex
OpReturn
OpFunctionEnd
)";
  const std::string error = run(stage, VK_SHADER_STAGE_COMPUTE_BIT, assembly(text));
  EXPECT_NE(error.find("OpEmitVertex"), std::string::npos) << error;
  EXPECT_NE(error.find("Geometry"), std::string::npos) << error;
}

// names.inc is what tools/spirv_names.py makes of the grammar; a newer one may have more.
TEST(SpirvCoverage, NamesAreTheGrammars) {
  for (const auto& op : grammar()["instructions"]) {
    const auto& all = grammar()["instructions"];
    const auto first = std::ranges::find_if(all, [&](const auto& o) { return o["opcode"] == op["opcode"]; });
    EXPECT_EQ(op_name(opcode(op)), (*first)["opname"].get<std::string>());
  }
}

}  // namespace
}  // namespace pineda::spirv::test
