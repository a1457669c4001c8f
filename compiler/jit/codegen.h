// LLVM IR -> passes -> an ELF object in memory. Internal to libpineda_jit.so.
#pragma once

#include <llvm/ADT/StringRef.h>
#include <llvm/IR/Module.h>
#include <llvm/Target/TargetMachine.h>

#include <string>

#include "compiler/jit/jit.h"

namespace pineda::jit {

// Of this thread: creating one takes longer than compiling a small kernel, and it is not thread-safe.
llvm::TargetMachine& target_machine(Isa isa);
const char* target_name(Isa isa);  // "x86-64-v3"

// Makes `module` one for the target, and its functions ones for the ISA's CPU model.
void set_target(llvm::Module& module, llvm::TargetMachine& machine);
void set_function_target(llvm::Function& function, Isa isa);

void optimize(llvm::Module& module, llvm::TargetMachine& machine, bool has_locals);

llvm::StringRef emit_object(llvm::Module& module, Isa isa);                           // valid until this thread's next call
std::string emit_assembly(const llvm::Module& module, llvm::TargetMachine& machine);  // text, from a copy

}  // namespace pineda::jit
