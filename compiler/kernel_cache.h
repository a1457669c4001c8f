// Kernels of this process by hash: equal kernels of different pipelines share their code, and two threads that want the same one
// compile it once.
#pragma once

#include "compiler/executable.h"

namespace pineda::compiler {

// The kernel after its passes; Executable::finish is the caller's to call.
// `store` is asked first, and may be null.
Result<ExecutablePtr> cached_executable(ir::Kernel kernel, CodeStore* store);

}  // namespace pineda::compiler
