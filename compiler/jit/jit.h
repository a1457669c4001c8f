// The LLVM back end, in a library of its own (libpineda_jit.so) that is opened when the first kernel is compiled: a process that
// only creates a device never loads LLVM.
//
// The plug-in exports one function, pineda_jit_api(), which returns this table. No LLVM type appears here.
//
// Kernels expect the x86-64 psABI's state at a call: MXCSR = 0x1F80 (round to nearest, denormals kept, exceptions masked). An
// application may change MXCSR of its own threads; Pineda's worker threads never do, and whoever runs a kernel on an
// application's thread sets it around the call. A kernel changes no floating-point state.
#pragma once

#include <cstdint>
#include <string>

#include "base/abi.h"
#include "compiler/ir/ir.h"

namespace pineda::jit {

enum class Isa : uint8_t { kSse42, kAvx2, kAvx512 };

struct Options {
  Isa isa = Isa::kSse42;
  bool want_llvm_ir = false, want_assembly = false;  // fill Code::llvm_ir / assembly (PINEDA_DEBUG)
};

// Machine code of one kernel; released with Api::release.
struct Code {
  KernelFn fn = nullptr;
  void* owner = nullptr;  // opaque
  uint64_t size_bytes = 0;
  std::string llvm_ir, assembly;
  std::string image;  // the code in a form that can be kept and mapped elsewhere (compiler/code_image.h); empty when it has none
  std::string error;  // empty on success
};

inline constexpr uint32_t kApiVersion = 2;

struct Api {
  uint32_t version;  // kApiVersion: the two libraries come from one build
  // The kernel must be verified, lowered (no transcendental ops), rated and hoisted. Thread-safe.
  Code (*compile)(const ir::Kernel& kernel, const Options& options);
  void (*release)(void* owner);
};

std::string plugin_path();  // of libpineda_jit.so, beside this library

// Opens libpineda_jit.so beside this library (once per process). Null with *error set when that fails.
const Api* api(std::string* error);

// PINEDA_ISA if it is set, else the best that this CPU runs. An ISA that the CPU lacks is refused: *error is set.
Isa select_isa(std::string* error);
const char* isa_name(Isa isa);  // "avx2"
bool isa_supported(Isa isa);    // by this CPU and its operating system

}  // namespace pineda::jit
