// Where compiled kernels are kept beyond the life of a kernel: on disk (disk_cache.h), in a VkPipelineCache
// (icd/pipeline_cache.h).
#pragma once

#include <memory>
#include <string>

#include "compiler/executable.h"

namespace pineda::compiler {

// What is kept of one kernel: CompiledCode, serialized. Shared, because a kernel and several stores hold the same one.
using CodeBlob = std::shared_ptr<const std::string>;

// Thread-safe.
class CodeStore {
 public:
  virtual ~CodeStore() = default;
  virtual CodeBlob find(const KernelHash& key) = 0;  // null: not there
  virtual void insert(const KernelHash& key, const CodeBlob& blob) = 0;
  // A kernel whose back end runs elsewhere; its blob is to be inserted when somebody needs to know.
  virtual void insert_when_finished(const ExecutablePtr&) {}
};

// Of what a blob holds: the kernel (as it was built, before the passes), everything else that selects code (ISA, precision), and
// the build of Pineda. `{}` when nothing can be kept: unknown build, or a mode that looks at more than the code.
KernelHash code_key(const KernelHash& kernel);

}  // namespace pineda::compiler
