// From an optimised kernel to something that runs: machine code, the evaluator, or both side by side (PINEDA_MODE), with the
// dumps of PINEDA_DEBUG.
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
};
using ExecutablePtr = std::shared_ptr<const Executable>;

// Runs passes and back end. Not cached.
Result<ExecutablePtr> make_executable(ir::Kernel kernel, const KernelHash& hash);

}  // namespace pineda::compiler
