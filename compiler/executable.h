// From a kernel to something that runs: machine code, the evaluator, or both side by side (PINEDA_MODE), with the dumps of
// PINEDA_DEBUG. In two steps, so that the passes of one stage can tell what the next one must do (varyings) while the back end,
// which takes most of the time, runs for both stages at once.
#pragma once

#include <memory>

#include "compiler/compile.h"
#include "compiler/hash.h"

namespace pineda::compiler {

KernelHash hash_kernel(const ir::Kernel& kernel);

class Executable : public Kernel {
 public:
  std::vector<VaryingSlot> varyings;  // of fragment kernels: slot 4 + i
  uint64_t frame_bytes = 0;           // ir::wave_frame

  virtual bool is_finished() const = 0;  // finish() would return at once

  // After finish(): what a CodeStore keeps of it under code_key(); null when its code cannot be kept.
  virtual std::shared_ptr<const std::string> blob() const = 0;
  KernelHash key;  // code_key() of the kernel as it was built
};
using ExecutablePtr = std::shared_ptr<Executable>;

class CodeStore;

// An error when no back end can run here: its library is missing, PINEDA_ISA asks for what the CPU lacks.
Result<void> back_end_available();

// Finds the kernel in `store` (which may be null) or on disk, else runs the passes. A kernel that was found has no `ir` but its
// name and kind, and is finished.
Result<ExecutablePtr> make_executable(ir::Kernel kernel, const KernelHash& hash, CodeStore* store);

}  // namespace pineda::compiler
