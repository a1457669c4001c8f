// SPIR-V modules of any size in a few shapes, to measure how compile time grows.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pineda::fuzz {

struct Shape {
  const char* name;
  // A compute shader of about this many instructions after inlining; entry point "main", one storage buffer at set 0, binding 0.
  std::vector<uint32_t> (*make)(uint32_t instructions);
};
std::span<const Shape> shapes();

}  // namespace pineda::fuzz
