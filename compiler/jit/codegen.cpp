#include "compiler/jit/codegen.h"

#include <array>
#include <iterator>
#include <mutex>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <llvm/ADT/SmallVector.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/MC/MCContext.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/CommandLine.h>
#include <llvm/Support/TargetSelect.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Transforms/Scalar/EarlyCSE.h>
#include <llvm/Transforms/Scalar/SROA.h>
#include <llvm/Transforms/Utils/Cloning.h>
#pragma GCC diagnostic pop

namespace pineda::jit {
namespace {

// CPU models of the x86-64 psABI: never the host's, so that a kernel's machine code depends on the ISA alone. `fast-gather` lets
// LLVM use AVX2's gather instructions, which those models leave out for the sake of Haswell.
struct Target {
  const char* cpu;
  const char* features;
  const char* vector_bits;
};

const Target& target_of(Isa isa) {
  static constexpr std::array<Target, 3> kTargets = {{
      {"x86-64-v2", "", "128"},
      {"x86-64-v3", "+fast-gather", "256"},
      {"x86-64-v4", "+fast-gather,-prefer-256-bit", "512"},
  }};
  return kTargets[static_cast<size_t>(isa)];
}

constexpr const char* kTriple = "x86_64-unknown-linux-gnu";

// Code generation passes that cost compile time and gain nothing on kernels: our IR has been optimised, addresses are simple,
// blocks are long and loops are few. Measured on Sapphire Rapids, AVX-512 (a 26-instruction SAXPY; a 201-instruction lit fragment
// kernel; 4 bilinear taps):
//                            compile ms              run ns per wave
//     LLVM's -O2 list        2.7    6.3   5.9        1.9   23.8   30.9
//     without these          2.1    5.4   4.7        1.9   23.7   29.4
//     no machine LICM too    2.0    5.2   4.6        2.7   23.4   30.3     (kept: it hoists constants out of short loops)
//     no scheduler either    1.9    4.4   4.2        2.7   23.8   31.4     (kept: AVX2 spills 10 % more without)
// LLVM has no interface for this other than its command line. This copy of LLVM is ours alone, so no other user's options are
// touched.
void drop_useless_passes() {
  static constexpr const char* kOptions[] = {"pineda_jit",
                                             "-disable-lsr",
                                             "-disable-cgp",
                                             "-disable-machine-sink",
                                             "-disable-machine-cse",
                                             "-disable-early-taildup",
                                             "-disable-tail-duplicate",
                                             "-disable-early-ifcvt",
                                             "-disable-postra-machine-licm",
                                             "-disable-postra-machine-sink",
                                             "-disable-post-ra",
                                             "-disable-copyprop",
                                             "-disable-constant-hoisting",
                                             "-disable-partial-libcall-inlining",
                                             "-disable-mergeicmps",
                                             "-disable-x86-domain-reassignment",
                                             "-disable-x86-lea-opt"};
  llvm::cl::ParseCommandLineOptions(static_cast<int>(std::size(kOptions)), kOptions);
}

const llvm::Target* llvm_target() {
  static const llvm::Target* target = [] {
    LLVMInitializeX86TargetInfo();
    LLVMInitializeX86Target();
    LLVMInitializeX86TargetMC();
    LLVMInitializeX86AsmPrinter();
    drop_useless_passes();
    std::string error;
    return llvm::TargetRegistry::lookupTarget(kTriple, error);
  }();
  return target;
}

std::unique_ptr<llvm::TargetMachine> create_machine(Isa isa) {
  llvm::TargetOptions options;
  options.AllowFPOpFusion = llvm::FPOpFusion::Strict;  // the bit contract: only llvm.fma is an FMA
  options.FunctionSections = false;
  const Target& target = target_of(isa);
  std::unique_ptr<llvm::TargetMachine> machine(llvm_target()->createTargetMachine(
      kTriple, target.cpu, target.features, options, llvm::Reloc::PIC_, llvm::CodeModel::Small, llvm::CodeGenOptLevel::Default));
  return machine;
}

// Idle back ends. Never destroyed: a thread may still compile while the process exits.
struct Pool {
  std::mutex mutex;
  std::array<std::vector<std::unique_ptr<Backend>>, 3> idle;  // by ISA
};

Pool& pool() {
  static Pool* const the_pool = new Pool;
  return *the_pool;
}

}  // namespace

// The code generator's passes, about 100 objects whose creation and scheduling take 0.35 ms: as long as running them on a small
// kernel. So one list serves many modules, as LLVM allows (llc -run-twice tests it); a new one from time to time bounds what its
// allocators keep.
struct Backend::PassList {
  static constexpr uint32_t kMaxRuns = 256;
  llvm::SmallVector<char, 0> object;
  llvm::raw_svector_ostream stream{object};
  llvm::legacy::PassManager passes;
  uint32_t runs = 0;
};

Backend::Backend(Isa isa) : isa_(isa), machine_(create_machine(isa)) {}
Backend::~Backend() = default;

const char* Backend::cpu() const { return target_of(isa_).cpu; }

void Backend::set_target(llvm::Module& module) {
  module.setTargetTriple(kTriple);
  module.setDataLayout(machine_->createDataLayout());
}

void Backend::set_function_targets(llvm::Module& module) {
  const Target& target = target_of(isa_);
  for (llvm::Function& function : module) {
    function.addFnAttr("target-cpu", target.cpu);
    function.addFnAttr("target-features", target.features);
    function.addFnAttr("prefer-vector-width", target.vector_bits);
    function.addFnAttr("min-legal-vector-width", target.vector_bits);
  }
}

void Backend::optimize(llvm::Module& module, bool has_locals) {
  llvm::LoopAnalysisManager loops;
  llvm::FunctionAnalysisManager functions;
  llvm::CGSCCAnalysisManager cgscc;
  llvm::ModuleAnalysisManager modules;
  llvm::PassBuilder builder(machine_.get());
  builder.registerModuleAnalyses(modules);
  builder.registerCGSCCAnalyses(cgscc);
  builder.registerFunctionAnalyses(functions);
  builder.registerLoopAnalyses(loops);
  builder.crossRegisterProxies(loops, functions, cgscc, modules);
  llvm::FunctionPassManager passes;
  if (has_locals) passes.addPass(llvm::SROAPass(llvm::SROAOptions::PreserveCFG));
  passes.addPass(llvm::EarlyCSEPass());
  for (llvm::Function& function : module) {
    if (!function.isDeclaration()) passes.run(function, functions);
  }
}

llvm::StringRef Backend::emit_object(llvm::Module& module) {
  if (passes_ == nullptr || passes_->runs == PassList::kMaxRuns) {
    passes_ = std::make_unique<PassList>();
    llvm::MCContext* context = nullptr;
    if (machine_->addPassesToEmitMC(passes_->passes, context, passes_->stream)) {
      passes_ = nullptr;
      return {};
    }
  }
  ++passes_->runs;
  passes_->object.clear();
  passes_->passes.run(module);
  return {passes_->object.data(), passes_->object.size()};
}

std::string Backend::emit_assembly(const llvm::Module& module) {
  std::unique_ptr<llvm::Module> copy = llvm::CloneModule(module);
  llvm::SmallString<0> text;
  llvm::raw_svector_ostream stream(text);
  llvm::legacy::PassManager passes;
  if (machine_->addPassesToEmitFile(passes, stream, nullptr, llvm::CodeGenFileType::AssemblyFile)) return {};
  passes.run(*copy);
  return text.str().str();
}

BackendLease::BackendLease(Isa isa) : isa_(isa) {
  {
    const std::lock_guard lock(pool().mutex);
    auto& idle = pool().idle[static_cast<size_t>(isa)];
    if (!idle.empty()) {
      backend_ = std::move(idle.back());
      idle.pop_back();
    }
  }
  if (backend_ == nullptr) backend_ = std::make_unique<Backend>(isa);
}

BackendLease::~BackendLease() {
  const std::lock_guard lock(pool().mutex);
  pool().idle[static_cast<size_t>(isa_)].push_back(std::move(backend_));
}

}  // namespace pineda::jit
