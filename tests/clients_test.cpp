// Programs that use the driver as any user would: vulkaninfo, the validation layer, the `pineda` command with good and bad input.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/paths.h"
#include "tests/process.h"

namespace pineda::tests {
namespace {

const std::string kCommand = build_dir() + "/pineda";

TEST(Clients, VulkaninfoListsTheDriver) {
  const ProcessResult result = run_process("VK_DRIVER_FILES=" + build_dir() + "/pineda_icd.json VK_ICD_FILENAMES=" + build_dir() +
                                           "/pineda_icd.json vulkaninfo --summary");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find("deviceName         = Pineda"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("PHYSICAL_DEVICE_TYPE_CPU"), std::string::npos) << result.output;
}

// All of it, features and formats included, while the validation layer watches.
TEST(Clients, VulkaninfoPrintsEverything) {
  const ProcessResult result = run_process(
      "XDG_RUNTIME_DIR=" + build_dir() + " VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation VK_DRIVER_FILES=" + build_dir() +
      "/pineda_icd.json VK_ICD_FILENAMES=" + build_dir() + "/pineda_icd.json vulkaninfo --show-formats");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  for (const char* complaint : {"ERROR", "Validation Error", "VK_ERROR"}) {
    EXPECT_EQ(result.output.find(complaint), std::string::npos) << complaint << " in\n" << result.output;
  }
  for (const char* part : {"FORMAT_ASTC_12x12_SRGB_BLOCK", "maxImageDimension2D", "VkPhysicalDeviceDescriptorIndexingFeatures"}) {
    EXPECT_NE(result.output.find(part), std::string::npos) << part << " missing in\n" << result.output;
  }
}

TEST(Clients, ScenesAreCleanUnderTheValidationLayer) {
  const ProcessResult result = run_process(kCommand + " golden --validate " + source_dir() + "/tests/golden/scenes.txt");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_EQ(result.output.find("validation:"), std::string::npos) << result.output;
}

TEST(Clients, ScenesAreCleanUnderSynchronizationValidation) {
  const ProcessResult result = run_process("VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT " +
                                           kCommand + " golden --validate " + source_dir() + "/tests/golden/scenes.txt");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_EQ(result.output.find("validation:"), std::string::npos) << result.output;
}

// The quick ones of `./run clients`; what is not installed is skipped, and its row says so.
TEST(Clients, OtherPeoplesProgramsWork) {
  const ProcessResult result = run_process(source_dir() + "/tests/clients/run_clients.sh " + build_dir() + " " + build_dir() +
                                           "/clients-test vulkaninfo vkcube_wayland gfxrecon");
  EXPECT_EQ(result.exit_status, 0) << result.output;
}

TEST(Clients, OnlyTheLoaderInterfaceIsExported) {
  const ProcessResult result = run_process("nm -D --defined-only --format=posix " + build_dir() + "/libvk_pineda.so");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  std::istringstream lines(result.output);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_TRUE(line.starts_with("vk_icd")) << "not the loader's business: " << line;
  }
  EXPECT_EQ(count, 3) << "negotiation and the two look-ups:\n" << result.output;
}

struct BadInput {
  const char* name;
  const char* arguments;
  const char* message;  // that must appear
};

void PrintTo(const BadInput& input, std::ostream* out) { *out << "pineda " << input.arguments; }

class BadInputTest : public testing::TestWithParam<BadInput> {};

TEST_P(BadInputTest, GetsAClearError) {
  const ProcessResult result = run_process(kCommand + " " + GetParam().arguments);
  EXPECT_GT(result.exit_status, 0) << result.output;
  EXPECT_LT(result.exit_status, 128) << "ended by a signal: " << result.output;
  EXPECT_NE(result.output.find(GetParam().message), std::string::npos) << result.output;
}

INSTANTIATE_TEST_SUITE_P(Clients, BadInputTest,
                         testing::Values(BadInput{"MissingFile", "compare --out /tmp/pineda-bad /no/such/model.glb",
                                                  "/no/such/model.glb"},
                                         BadInput{"UnknownScene", "compare --out /tmp/pineda-bad nonsense", "nonsense"},
                                         BadInput{"MissingDriver", "render triangle --driver /no/such/driver.json", "driver"},
                                         BadInput{"EmptySize", "render triangle --size 0x10", "size"},
                                         BadInput{"UnknownVerb", "frobnicate", "frobnicate"}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace pineda::tests
