// LLVM IR -> passes -> an ELF object in memory. Internal to libpineda_jit.so.
#pragma once

#include <llvm/ADT/StringRef.h>
#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <memory>
#include <string>

#include "compiler/jit/jit.h"

namespace pineda::jit {

// LLVM's code generator for one ISA. One thread at a time; LLVMContexts come and go.
class Backend {
 public:
  explicit Backend(Isa isa);
  ~Backend();

  const char* cpu() const;  // "x86-64-v3"

  // Makes `module`, and later each of its functions, one for this target.
  void set_target(llvm::Module& module);
  void set_function_targets(llvm::Module& module);

  void optimize(llvm::Module& module, bool has_locals);
  llvm::StringRef emit_object(llvm::Module& module);      // valid until the next call; empty when LLVM has no emitter
  std::string emit_assembly(const llvm::Module& module);  // text, from a copy

 private:
  struct PassList;
  const Isa isa_;
  const std::unique_ptr<llvm::TargetMachine> machine_;
  std::unique_ptr<PassList> passes_;
};

// A Backend that nobody else uses meanwhile. They are kept, because creating one takes longer than compiling a small kernel, and
// belong to no thread, because applications create pipelines on threads that come and go.
class BackendLease {
 public:
  explicit BackendLease(Isa isa);
  ~BackendLease();
  BackendLease(const BackendLease&) = delete;
  BackendLease& operator=(const BackendLease&) = delete;
  Backend* operator->() const { return backend_.get(); }

 private:
  const Isa isa_;
  std::unique_ptr<Backend> backend_;
};

}  // namespace pineda::jit
