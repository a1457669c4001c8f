// The bit contract on whole scenes: the hashes committed in tests/golden/ for every ISA that the CPU has x thread count x tile
// size, the evaluator in place of machine code, and both side by side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/paths.h"
#include "tests/process.h"

namespace pineda::tests {
namespace {

const std::string kCommand = build_dir() + "/pineda";
const std::string kGolden = kCommand + " golden " + source_dir() + "/tests/golden/scenes.txt";

bool cpu_has(const std::vector<std::string>& wanted) {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (!line.starts_with("flags")) continue;
    std::istringstream words(line);
    std::vector<std::string> flags(std::istream_iterator<std::string>(words), {});
    return std::all_of(wanted.begin(), wanted.end(),
                       [&](const std::string& flag) { return std::find(flags.begin(), flags.end(), flag) != flags.end(); });
  }
  return false;
}

struct Variant {
  const char* isa;
  int threads, tile_px;
};

void PrintTo(const Variant& v, std::ostream* out) {
  *out << v.isa << ", " << v.threads << " threads, tiles of " << v.tile_px << " px";
}

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const char* isa : {"sse42", "avx2", "avx512"}) {
    for (int threads : {1, 2, 5}) {
      for (int tile_px : {16, 64}) all.push_back({isa, threads, tile_px});
    }
  }
  return all;
}

class GoldenHashes : public testing::TestWithParam<Variant> {};

TEST_P(GoldenHashes, AreEqual) {
  const Variant v = GetParam();
  if (std::string(v.isa) == "avx2" && !cpu_has({"avx2", "fma", "f16c", "bmi2"})) GTEST_SKIP() << "this CPU has no AVX2";
  if (std::string(v.isa) == "avx512" && !cpu_has({"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"})) {
    GTEST_SKIP() << "this CPU has no AVX-512";
  }
  const ProcessResult result = run_process("PINEDA_ISA=" + std::string(v.isa) + " PINEDA_THREADS=" + std::to_string(v.threads) +
                                           " PINEDA_TILE=" + std::to_string(v.tile_px) + " " + kGolden);
  EXPECT_EQ(result.exit_status, 0) << result.output;
}

INSTANTIATE_TEST_SUITE_P(Machines, GoldenHashes, testing::ValuesIn(variants()), [](const auto& info) {
  return std::string(info.param.isa) + "_threads" + std::to_string(info.param.threads) + "_tile" +
         std::to_string(info.param.tile_px);
});

// The omissions of the rasterizer are invisible in the bits.
TEST(BitContract, OmissionsDoNotShow) {
  const ProcessResult result =
      run_process("PINEDA_DEBUG=nohiz,nofastclear,noopaque,noequal,nooutside,nomissed,nolazy,nounread " + kGolden);
  EXPECT_EQ(result.exit_status, 0) << result.output;
}

// Nor does it show that passes ran beside each other, which they do when they may.
TEST(BitContract, PassesBesideEachOtherDoNotShow) {
  const auto render = [](const std::string& environment, bool overlaps) {
    const std::string statistics = testing::TempDir() + "overlap.json";
    std::remove(statistics.c_str());
    const ProcessResult result = run_process("PINEDA_THREADS=2 PINEDA_STATS=" + statistics + " " + environment + kCommand +
                                             " render bench:many-passes --size 128x128 --hash");
    EXPECT_EQ(result.exit_status, 0) << result.output;
    std::ifstream file(statistics);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(text.find("\"overlapped\":1") != std::string::npos, overlaps) << text;
    return result.output;
  };
  EXPECT_EQ(render("", true), render("PINEDA_DEBUG=nooverlap ", false));
}

TEST(BitContract, EvaluatorDrawsTheSameScenes) {
  const ProcessResult result = run_process("PINEDA_MODE=f32 " + kGolden);
  EXPECT_EQ(result.exit_status, 0) << result.output;
}

// Every kernel call of every scene: machine code and evaluator store the same bytes, on all lanes.
TEST(BitContract, MachineCodeAgreesWithTheEvaluatorByteForByte) {
  const ProcessResult result = run_process("PINEDA_MODE=check PINEDA_DEBUG=api " + kGolden);
  EXPECT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find(" of which 0 differ"), std::string::npos) << "the driver did not sum up its check:\n"
                                                                         << result.output;
}

}  // namespace
}  // namespace pineda::tests
