// From a kernel to something that runs: machine code, the evaluator, or both side by side (PINEDA_MODE), with the dumps of
// PINEDA_DEBUG. In two steps, so that the passes of one stage can tell what the next one must do (varyings) while the back end,
// which takes most of the time, runs for both stages at once.
#pragma once

#include <memory>

#include "compiler/compile.h"

namespace pineda::compiler {

// 128 bits over a kernel's instructions; its name does not count.
struct KernelHash {
  uint64_t high = 0, low = 0;
  bool operator==(const KernelHash&) const = default;
  auto operator<=>(const KernelHash&) const = default;
  std::string text() const;  // first 16 hexadecimal digits, for file names
};
KernelHash hash_kernel(const ir::Kernel& kernel);

class Executable : public Kernel {
 public:
  std::vector<VaryingSlot> varyings;  // of fragment kernels: slot 4 + i

  // Runs the back end: `handle` is valid afterwards. Thread-safe; who comes second waits for the first and gets the same answer.
  virtual Result<void> finish() = 0;
};
using ExecutablePtr = std::shared_ptr<Executable>;

// Runs the passes. Not cached.
Result<ExecutablePtr> make_executable(ir::Kernel kernel, const KernelHash& hash);

}  // namespace pineda::compiler
