// `pineda explain`: what was left out of pipelines, passes and dispatches is told, with the numbers that the scene has.
#include <gtest/gtest.h>

#include <string>

#include "tests/paths.h"
#include "tests/process.h"

namespace pineda::tests {
namespace {

std::string explained(const std::string& arguments) {
  const ProcessResult result = run_process(build_dir() + "/pineda explain " + arguments + " --rounds 1 --budget 1");
  EXPECT_EQ(result.exit_status, 0) << result.output;
  return result.output;
}

void expect_in(const std::string& text, std::initializer_list<const char*> wanted) {
  for (const char* what : wanted) EXPECT_NE(text.find(what), std::string::npos) << what << "\n" << text;
}

// mandelbrot.comp: groups of 16x16 over 100x60 pixels are 7x4; four accesses a shader: the push constants cannot leave, pixels[]
// can; the loop and its Ifs depend on the lane's pixel.
TEST(Explain, ComputePipelineAndDispatch) {
  expect_in(explained("mandelbrot --size 100x60"),
            {"compute pipeline 'compute', workgroups of 16x16x1", "stores 1 -> 1", " 0 are uniform (a wave jumps), 4 may differ",
             "bounds checks: ", "barriers: none", "workgroup memory: none",
             "dispatch of 'compute', 7x4x1 workgroups of 16x16x1: 28 workgroups, 448 waves, active lanes 256 of 256 (100 %)"});
}

TEST(Explain, EveryOmissionHasARowAndTheSameBits) {
  const std::string text = explained("cubes-4x --size 100x60");
  expect_in(text,
            {"pipeline 'graphics'", "render pass, 100x60, 4 samples", "\nnothing ", "\nnohiz ", "\nnofastclear ", "\nnoopaque ",
             "\nnoequal ", "\nnooutside ", "\nnomissed ", "\nnolazy ", "\nnounread ", "\ngeneral ", "\nall "});
  EXPECT_EQ(text.find("DIFFERENT"), std::string::npos) << text;
}

}  // namespace
}  // namespace pineda::tests
