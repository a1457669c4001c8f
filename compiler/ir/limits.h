// Bounds of a kernel's shape that verify() and parse() enforce.
#pragma once

#include <cstdint>

namespace pineda::ir {

inline constexpr uint32_t kMaxRegionDepth = 2304;     // of nested Ifs and Loops: passes and back ends recurse over them
inline constexpr uint64_t kMaxLocalBytes = 1u << 22;  // of all Locals of a lane; the JIT takes less of what passes/ssa leaves

}  // namespace pineda::ir
