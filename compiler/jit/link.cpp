#include "compiler/jit/link.h"

#include <llvm/ExecutionEngine/JITLink/ELF_x86_64.h>
#include <llvm/ExecutionEngine/JITLink/x86_64.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "compiler/code_image.h"
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

// What an edge means for code that is moved as a whole: nothing, when it is a distance between two of its places.
bool is_distance(llvm::jitlink::Edge::Kind kind) {
  namespace x86 = llvm::jitlink::x86_64;
  switch (kind) {
    case llvm::jitlink::Edge::KeepAlive:
    case x86::Delta64:
    case x86::Delta32:
    case x86::NegDelta64:
    case x86::NegDelta32:
    case x86::PCRel32:
    case x86::BranchPCRel32:
    case x86::BranchPCRel32ToPtrJumpStub:
    case x86::BranchPCRel32ToPtrJumpStubBypassable:
    case x86::PCRel32GOTLoadRelaxable:
    case x86::PCRel32GOTLoadREXRelaxable:
      return true;
    default:
      return false;
  }
}

// The linked code as an image; nothing when some place of it cannot be expressed there.
std::optional<std::string> image_of(LinkGraph& graph, llvm::StringRef symbol) {
  uint64_t base = ~uint64_t{0}, entry = 0;
  for (llvm::jitlink::Block* block : graph.blocks()) base = std::min(base, block->getAddress().getValue());
  base &= ~uint64_t{compiler::kImagePageBytes - 1};
  compiler::CodeImage image;
  for (llvm::jitlink::Section& section : graph.sections()) {
    const auto has = [&](llvm::orc::MemProt wanted) {
      return (static_cast<uint8_t>(section.getMemProt()) & static_cast<uint8_t>(wanted)) != 0;
    };
    const bool executable = has(llvm::orc::MemProt::Exec);
    if (has(llvm::orc::MemProt::Write) && !section.blocks().empty()) return {};
    for (llvm::jitlink::Block* block : section.blocks()) {
      const uint64_t at = block->getAddress().getValue() - base;
      const llvm::ArrayRef<char> bytes = block->isZeroFill() ? llvm::ArrayRef<char>() : block->getContent();
      if (bytes.empty() || at > compiler::kMaxImageBytes) return {};
      image.pieces.push_back({static_cast<uint32_t>(at), executable, {bytes.begin(), bytes.end()}});
      for (const llvm::jitlink::Edge& edge : block->edges()) {
        const llvm::jitlink::Symbol& target = edge.getTarget();
        const auto place = static_cast<uint32_t>(at + edge.getOffset());
        if (target.isDefined() && is_distance(edge.getKind())) continue;
        if (edge.getKind() != llvm::jitlink::x86_64::Pointer64) return {};
        if (target.isDefined()) {
          const uint64_t to = target.getAddress().getValue() + static_cast<uint64_t>(edge.getAddend()) - base;
          image.pointers.push_back({place, compiler::ImagePointer::kImage, to});
        } else {
          image.pointers.push_back({place, compiler::ImagePointer::kFmaF64, 0});
        }
      }
    }
  }
  for (llvm::jitlink::Symbol* defined : graph.defined_symbols()) {
    if (defined->hasName() && defined->getName() == symbol) entry = defined->getAddress().getValue() - base;
  }
  image.entry = static_cast<uint32_t>(entry);
  return compiler::serialize(image);
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

  llvm::Error modifyPassConfig(LinkGraph&, llvm::jitlink::PassConfiguration& passes) override {
    passes.PostFixupPasses.push_back([this](LinkGraph& graph) {
      if (std::optional<std::string> image = image_of(graph, symbol_)) out_->image = std::move(*image);
      return llvm::Error::success();
    });
    return llvm::Error::success();
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
