// GLSL or SPIR-V text to words by the SDK's own tools, for tests.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>
#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace pineda::tests::tools {

using Words = std::vector<uint32_t>;

// A file of its own among the temporary ones, gone with the object.
class TemporaryFile {
 public:
  TemporaryFile() {
    const int file = mkstemp(path_.data());
    EXPECT_GE(file, 0) << path_;
    if (file >= 0) close(file);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  ~TemporaryFile() { std::remove(path_.c_str()); }

  const std::string& path() const { return path_; }
  std::string contents() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  std::string path_ = (std::filesystem::temp_directory_path() / "pineda-test-XXXXXX").string();
};

// Runs a tool that reads `text` from its standard input and gives the words that it writes.
inline Words run_tool_now(const std::string& tool, const std::string& options, const std::string& text) {
  const TemporaryFile out, log;
  const std::string command = tool + " " + options + " -o " + out.path() + " > " + log.path() + " 2>&1";
  FILE* pipe = popen(command.c_str(), "w");
  if (pipe) {
    fwrite(text.data(), 1, text.size(), pipe);
    if (pclose(pipe) != 0) ADD_FAILURE() << tool << " failed:\n" << log.contents() << text;
  }
  const std::string bytes = out.contents();
  Words words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  return words;
}

// Starting a tool takes longer than everything else here, so equal texts are compiled once.
inline Words run_tool(const std::string& tool, const std::string& options, const std::string& text) {
  static std::map<std::string, Words> done;
  const auto [found, is_new] = done.emplace(tool + options + text, Words());
  if (is_new) found->second = run_tool_now(tool, options, text);
  return found->second;
}

inline Words glsl(VkShaderStageFlagBits stage, const std::string& text, const std::string& target = "vulkan1.0") {
  const char* name = stage == VK_SHADER_STAGE_VERTEX_BIT ? "vert" : stage == VK_SHADER_STAGE_FRAGMENT_BIT ? "frag" : "comp";
  return run_tool("glslangValidator", "-V --target-env " + target + " --stdin -S " + name, "#version 450\n" + text);
}

inline Words assembly(const std::string& text, const std::string& target = "spv1.3") {
  return run_tool("spirv-as", "--target-env " + target + " -", text);
}

// spirv-opt makes other shapes of the same program: phis instead of variables, merged returns, unrolled loops.
inline Words rewritten(const Words& words, const std::string& passes) {
  const TemporaryFile in;
  std::ofstream(in.path(), std::ios::binary)
      .write(reinterpret_cast<const char*>(words.data()), static_cast<std::streamsize>(words.size() * 4));
  return run_tool_now("spirv-opt", passes + " " + in.path(), "");
}

}  // namespace pineda::tests::tools
