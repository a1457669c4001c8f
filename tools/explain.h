// `pineda explain SCENE`: what Pineda leaves out of a scene, in words and numbers, and what each omission saves.
#pragma once

#include <chrono>
#include <string>

#include "tools/size.h"

namespace pineda::tools {

struct ExplainOptions {
  std::string scene;
  Size size{800, 600};
  uint32_t rounds = 5;     // turns of each variant
  double budget_ms = 150;  // of each turn
  std::chrono::seconds timeout{120};
};

// Prints what PINEDA_DEBUG=explain says of the scene, and a table: the scene with each omission switched off, time and bits. Exit
// status: 1 when any bits differ.
int explain(const ExplainOptions& options);

}  // namespace pineda::tools
