// The one export of libpineda_jit.so.
#include <llvm/IR/LLVMContext.h>
#include <llvm/Support/raw_ostream.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <mutex>

#include "base/config.h"
#include "compiler/jit/codegen.h"
#include "compiler/jit/emitter.h"
#include "compiler/jit/link.h"

namespace pineda::jit {
namespace {

// `perf` names code by this file (tools/perf/Documentation/jit-interface.txt of Linux).
void add_to_perf_map(const LinkedCode& code, llvm::StringRef name) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  static FILE* const file = std::fopen(("/tmp/perf-" + std::to_string(getpid()) + ".map").c_str(), "w");
  if (file == nullptr) return;
  std::fprintf(file, "%llx %llx %s\n", static_cast<unsigned long long>(reinterpret_cast<uintptr_t>(code.entry)),
               static_cast<unsigned long long>(code.size_bytes), name.str().c_str());
  std::fflush(file);
}

std::string to_text(const llvm::Module& module) {
  std::string text;
  llvm::raw_string_ostream stream(text);
  module.print(stream, nullptr);
  return text;
}

// Where the time of a compilation goes (PINEDA_DEBUG=time).
class Stopwatch {
 public:
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Code compile(const ir::Kernel& kernel, const Options& options) {
  Stopwatch watch;
  Code code;
  const BackendLease backend(options.isa);
  llvm::LLVMContext context;
  llvm::Module module(kernel.name, context);
  backend->set_target(module);
  Emitter emitter(module, kernel, options.isa);
  llvm::Function* function = emitter.run(&code.error);
  if (function == nullptr) return code;
  backend->set_function_targets(module);
  const double emit_ms = watch.lap_ms();
  backend->optimize(module, emitter.has_locals());
  const double passes_ms = watch.lap_ms();
  if (options.want_llvm_ir) code.llvm_ir = to_text(module);
  if (options.want_assembly) code.assembly = backend->emit_assembly(module);
  const std::string symbol = function->getName().str();
  watch.lap_ms();
  const llvm::StringRef object = backend->emit_object(module);
  const double codegen_ms = watch.lap_ms();
  auto linked = link_object(object, symbol);
  if (!linked) {
    code.error = "kernel " + kernel.name + ": " + linked.error();
    return code;
  }
  if (debug(kDebugTime)) {
    std::fprintf(stderr, "pineda: %s %s: emit %.2f, passes %.2f, code generation %.2f, link %.2f ms; %llu bytes\n",
                 kernel.name.c_str(), backend->cpu(), emit_ms, passes_ms, codegen_ms, watch.lap_ms(),
                 static_cast<unsigned long long>((*linked)->size_bytes));
  }
  if (debug(kDebugPerf)) add_to_perf_map(**linked, symbol);
  code.fn = reinterpret_cast<KernelFn>((*linked)->entry);
  code.size_bytes = (*linked)->size_bytes;
  code.image = std::move((*linked)->image);
  code.owner = linked->release();
  return code;
}

void release(void* owner) { delete static_cast<LinkedCode*>(owner); }

}  // namespace
}  // namespace pineda::jit

extern "C" __attribute__((visibility("default"))) const pineda::jit::Api* pineda_jit_api() {
  static constexpr pineda::jit::Api kApi = {pineda::jit::kApiVersion, &pineda::jit::compile, &pineda::jit::release};
  return &kApi;
}
