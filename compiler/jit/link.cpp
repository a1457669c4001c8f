#include "compiler/jit/link.h"

#include <llvm/ExecutionEngine/JITLink/ELF_x86_64.h>

#include <cmath>

#include "compiler/jit/emitter.h"

namespace pineda::jit {
namespace {

using llvm::jitlink::JITLinkContext;
using llvm::jitlink::JITLinkMemoryManager;
using llvm::jitlink::LinkGraph;

JITLinkMemoryManager& memory_manager() {
  static llvm::jitlink::InProcessMemoryManager manager(4096);  // x86-64's page size; each link maps pages of its own
  return manager;
}

double fma_f64(double a, double b, double c) { return std::fma(a, b, c); }

// One link. No session, no symbol table: a kernel defines one function and needs nothing, so ORC's layers above JITLink have no
// work to do, and links on several threads share nothing.
class Context final : public JITLinkContext {
 public:
  Context(llvm::StringRef symbol, LinkedCode* out, std::string* error)
      : JITLinkContext(nullptr), symbol_(symbol), out_(out), error_(error) {}

  JITLinkMemoryManager& getMemoryManager() override { return memory_manager(); }

  void notifyFailed(llvm::Error failure) override { *error_ = llvm::toString(std::move(failure)); }

  // LLVM calls library functions for some operations on some targets (half conversions, memset, 128-bit division ...). Their bits
  // or their presence are not ours to rely on: a kernel that needs one is refused.
  void lookup(const LookupMap& symbols, std::unique_ptr<llvm::jitlink::JITLinkAsyncLookupContinuation> continuation) override {
    llvm::jitlink::AsyncLookupResult found;
    for (const auto& [name, flags] : symbols) {
      if (name != kFmaSymbol) {
        continuation->run(llvm::createStringError("machine code calls the library function " + name.str()));
        return;
      }
      found[name] = {llvm::orc::ExecutorAddr::fromPtr(&fma_f64), llvm::JITSymbolFlags::Exported};
    }
    continuation->run(std::move(found));
  }

  llvm::Error notifyResolved(LinkGraph& graph) override {
    for (llvm::jitlink::Symbol* defined : graph.defined_symbols()) {
      if (defined->hasName() && defined->getName() == symbol_) out_->entry = defined->getAddress().toPtr<void*>();
    }
    for (llvm::jitlink::Block* block : graph.blocks()) out_->size_bytes += block->getSize();
    return out_->entry != nullptr ? llvm::Error::success() : llvm::createStringError("the object lacks its function");
  }

  void notifyFinalized(JITLinkMemoryManager::FinalizedAlloc memory) override { out_->memory = std::move(memory); }

 private:
  llvm::StringRef symbol_;
  LinkedCode* out_;
  std::string* error_;
};

}  // namespace

LinkedCode::~LinkedCode() {
  if (memory) llvm::cantFail(memory_manager().deallocate(std::move(memory)));
}

std::expected<std::unique_ptr<LinkedCode>, std::string> link_object(llvm::StringRef object, llvm::StringRef symbol) {
  auto graph = llvm::jitlink::createLinkGraphFromELFObject_x86_64(llvm::MemoryBufferRef(object, symbol));
  if (!graph) return std::unexpected(llvm::toString(graph.takeError()));
  auto code = std::make_unique<LinkedCode>();
  std::string error;
  llvm::jitlink::link_ELF_x86_64(std::move(*graph),
                                 std::make_unique<Context>(symbol, code.get(), &error));  // in-process: synchronous
  if (!error.empty()) return std::unexpected(error);
  return code;
}

}  // namespace pineda::jit
