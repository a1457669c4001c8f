// Object -> executable memory, with LLVM's JITLink. Internal to libpineda_jit.so.
#pragma once

#include <llvm/ExecutionEngine/JITLink/JITLink.h>

#include <expected>
#include <string>

namespace pineda::jit {

// Executable memory of one kernel.
class LinkedCode {
 public:
  LinkedCode() = default;
  LinkedCode(const LinkedCode&) = delete;
  LinkedCode& operator=(const LinkedCode&) = delete;
  ~LinkedCode();

  void* entry = nullptr;
  uint64_t size_bytes = 0;  // of code and constants
  std::string image;        // see code_image.h; empty when the code cannot be moved
  llvm::jitlink::JITLinkMemoryManager::FinalizedAlloc memory;
};

// `symbol`: the one function of the object. Thread-safe.
std::expected<std::unique_ptr<LinkedCode>, std::string> link_object(llvm::StringRef object, llvm::StringRef symbol);

}  // namespace pineda::jit
