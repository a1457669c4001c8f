// pineda_cts as a program: that a case which crashes, hangs or leaves costs itself and no other, what JUnit files hold, filters
// and shards. With --self-test it has one case of each kind (cts-subset/groups/self_test.cpp).
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "tests/paths.h"
#include "tests/process.h"

namespace pineda::tests {
namespace {

const std::string kProgram = build_dir() + "/pineda_cts";
const std::string kEnvironment =
    "VK_DRIVER_FILES=" + build_dir() + "/pineda_icd.json VK_ICD_FILENAMES=" + build_dir() + "/pineda_icd.json ";

class Folder {
 public:
  Folder() : path_(testing::TempDir() + "cts" + std::to_string(getpid())) { std::filesystem::create_directories(path_); }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(file(name)).rdbuf();
    return text.str();
  }

 private:
  std::string path_;
};

TEST(CtsProgram, ACaseThatCrashesOrHangsCostsItselfOnly) {
  const Folder folder;
  const ProcessResult result =
      run_process(kEnvironment + kProgram + " --self-test --isolate --case-timeout 1 --junit=" + folder.file("out.xml"));
  EXPECT_EQ(result.exit_status, 1) << result.output;
  EXPECT_NE(result.output.find("self_test                         2 /    4 /    1"), std::string::npos) << result.output;
  const std::string junit = folder.read("out.xml");
  for (const char* wanted :
       {"tests=\"7\" failures=\"4\" skipped=\"1\"", "name=\"passes\"/>", "name=\"passes_behind_them\"/>",
        "name=\"crashes\"><failure message=\"the process ended by signal 11",
        "name=\"hangs\"><failure message=\"no verdict within 1 s",
        "name=\"exits\"><failure message=\"the process ended with status 5",
        "name=\"is_not_supported\"><skipped message=", "name=\"fails\"><failure message=", "1 &lt; 2 &amp; &quot;so&quot;"}) {
    EXPECT_NE(junit.find(wanted), std::string::npos) << wanted << "\n" << junit;
  }
}

TEST(CtsProgram, TwoDriversHaveTwoColumnsAndTwoFiles) {
  const Folder folder;
  const std::string manifest = build_dir() + "/pineda_icd.json";
  const ProcessResult result =
      run_process("cd " + folder.file("") + " && " + kProgram + " --self-test --gtest_filter='*.passes*' --driver a=" + manifest +
                  " --driver b=" + manifest);
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find("self_test                         2 /    0 /    0      2 /    0 /    0"), std::string::npos)
      << result.output;
  EXPECT_EQ(folder.read("a.xml"), folder.read("b.xml"));
  EXPECT_NE(folder.read("a.xml").find("tests=\"2\" failures=\"0\""), std::string::npos);
}

std::multiset<std::string> listed(const std::string& environment, const std::string& arguments) {
  const ProcessResult result = run_process(environment + kEnvironment + kProgram + " " + arguments + " --gtest_list_tests");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  std::multiset<std::string> cases;
  std::istringstream lines(result.output);
  std::string group;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ")) {
      cases.insert(group + line.substr(2));
    } else {
      group = line;
    }
  }
  return cases;
}

TEST(CtsProgram, FiltersChoose) {
  const auto blend = listed("", "--gtest_filter='pipeline.blend.*:-*SRGB*'");
  EXPECT_GT(blend.size(), 500u);
  for (const std::string& name : blend) {
    EXPECT_TRUE(name.starts_with("pipeline.blend.")) << name;
    EXPECT_EQ(name.find("SRGB"), std::string::npos) << name;
  }
}

// Each case is in exactly one of three shards, in this process and in children.
TEST(CtsProgram, ShardsPartTheCases) {
  const std::string filter = "--gtest_filter='pipeline.logic_op.*'";
  const auto all = listed("", filter);
  std::multiset<std::string> parts;
  for (const char* index : {"0", "1", "2"}) {
    const std::string shard = std::string("GTEST_TOTAL_SHARDS=3 GTEST_SHARD_INDEX=") + index + " ";
    const ProcessResult result = run_process(shard + kEnvironment + kProgram + " --isolate --junit=/dev/stderr " + filter);
    EXPECT_EQ(result.exit_status, 0) << result.output;
    constexpr std::string_view kClass = "classname=\"", kName = "\" name=\"";
    for (size_t at = 0; (at = result.output.find(kClass, at)) != std::string::npos;) {
      at += kClass.size();
      const size_t middle = result.output.find(kName, at), end = result.output.find('"', middle + kName.size());
      parts.insert(result.output.substr(at, middle - at) + "." +
                   result.output.substr(middle + kName.size(), end - middle - kName.size()));
    }
  }
  EXPECT_EQ(parts, all);
}

// The groups that the official suite has and this one promises.
TEST(CtsProgram, HasTheGroupsOfTheOfficialSuite) {
  const auto all = listed("", "");
  EXPECT_GE(all.size(), 3000u);
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size()) << "names that stand for two cases";
  for (const char* group : {"info.",
                            "api.",
                            "memory.",
                            "pipeline.vertex_input.",
                            "pipeline.blend.",
                            "pipeline.depth.",
                            "pipeline.stencil.",
                            "pipeline.logic_op.",
                            "pipeline.multisample.",
                            "pipeline.push_constant.",
                            "pipeline.spec_constant.",
                            "pipeline.timestamp.",
                            "binding_model.",
                            "spirv_assembly.",
                            "glsl.operators.",
                            "glsl.builtin.",
                            "glsl.texture_functions.",
                            "glsl.derivatives.",
                            "renderpass.",
                            "ubo.",
                            "ssbo.",
                            "draw.",
                            "compute.",
                            "image.",
                            "synchronization.",
                            "rasterization.",
                            "clipping.",
                            "fragment_operations.",
                            "texture.",
                            "query_pool.",
                            "robustness.",
                            "subgroups.",
                            "wsi.headless."}) {
    const auto first = all.lower_bound(group);
    EXPECT_TRUE(first != all.end() && first->starts_with(group)) << group;
  }
}

}  // namespace
}  // namespace pineda::tests
