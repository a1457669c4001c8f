// The evaluator: runs a kernel's IR instruction by instruction, 16 lanes in a plain scalar loop. It is the oracle for the JIT
// (f32: every stored bit must agree) and gives the truth that errors are measured against (f64). Each operation is defined in
// compiler/ir/semantics.h.
//
// Where ir.h leaves the value of an inactive lane open, a load gives 0 there and every other operation computes as usual.
// Lanes of a store or atomic act in ascending order, so the highest active lane wins where addresses meet.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/abi.h"
#include "compiler/ir/ir.h"

namespace pineda::eval {

enum class Mode : uint8_t { kF32, kF64 };

// One byte that a kernel stored, in address order.
struct WrittenByte {
  uint64_t address;
  uint8_t value;
  bool operator==(const WrittenByte&) const = default;
};

struct Code;

// A kernel made ready to run: build once, run often, from any thread. Does not refer to the ir::Kernel afterwards.
class Program {
 public:
  // The kernel must be verified; for kF32 it must be lowered (no transcendentals), kF64 wants passes::Form::kTruth.
  Program(const ir::Kernel& kernel, Mode mode);
  ~Program();
  Program(Program&&) noexcept;
  Program& operator=(Program&&) noexcept;

  // Same contract as KernelFn. The caller's floating-point environment does not matter.
  void run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves) const;
  // Runs without touching memory: stores go to an overlay that later loads see. Returns what memory would hold afterwards.
  std::vector<WrittenByte> dry_run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                                   const void* waves) const;

  // A KernelFn for handles whose `self` is a Program.
  static void invoke(const KernelHandle* handle, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                     const void* waves);

 private:
  std::unique_ptr<const Code> code_;
};

// Program(kernel, mode).run(...), for a single run.
void run(const ir::Kernel& kernel, Mode mode, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
         const void* waves);

// Program(kernel, kF32).dry_run(...). PINEDA_MODE=check runs this, then the machine code, and compares.
std::vector<WrittenByte> dry_run(const ir::Kernel& kernel, const void* draw, void* thread, const PrimRecord* prims,
                                 uint32_t prim_count, const void* waves);

}  // namespace pineda::eval
