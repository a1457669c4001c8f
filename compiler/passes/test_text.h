// For tests: a pass, from text to text.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "compiler/ir/ir.h"

namespace pineda::passes {

// Runs `pass` on a kernel whose wave region is given; gives the regions that are not empty.
inline std::string run_on_text(const std::string& wave, const std::function<void(ir::Kernel&)>& pass) {
  ir::ParseResult parsed = ir::parse("kernel compute \"t\" stride 8\nwave:\n" + wave);
  EXPECT_EQ(parsed.error, "") << wave;
  EXPECT_EQ(ir::verify(parsed.kernel), "") << wave;
  pass(parsed.kernel);
  EXPECT_EQ(ir::verify(parsed.kernel), "") << ir::print(parsed.kernel);
  for (ir::RegionId* root : {&parsed.kernel.draw, &parsed.kernel.prim}) {
    if (parsed.kernel.regions[*root].insts.empty()) *root = 0;
  }
  const std::string text = ir::print(parsed.kernel);
  return text.substr(text.find('\n') + 1);
}

}  // namespace pineda::passes
