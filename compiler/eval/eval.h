// The evaluator: runs a kernel's IR instruction by instruction, 16 lanes in a plain scalar loop. It is the oracle for the JIT (f32: every stored
// bit must agree) and gives the truth that errors are measured against (f64).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/abi.h"
#include "compiler/ir/ir.h"

namespace pineda::eval {

enum class Mode : uint8_t { kF32, kF64 };

// Same contract as KernelFn. kF64 wants a kernel from passes::Form::kTruth.
void run(const ir::Kernel& kernel, Mode mode, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
         const void* waves);

// One byte that a kernel stored, in address order.
struct WrittenByte {
  uint64_t address;
  uint8_t value;
};

// Runs in kF32 without touching memory: stores go to an overlay that later loads see. Returns what memory would hold afterwards.
// PINEDA_MODE=check runs this, then the machine code, and compares.
std::vector<WrittenByte> dry_run(const ir::Kernel& kernel, const void* draw, void* thread, const PrimRecord* prims,
                                 uint32_t prim_count, const void* waves);

}  // namespace pineda::eval
