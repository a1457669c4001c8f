// The cache of machine code on disk: PINEDA_CACHE=off|DIR; by default $XDG_CACHE_HOME/pineda or ~/.cache/pineda.
//
// On by default, because those who draw without a GPU start many short processes, and safe by default, because what is read is
// run: the directory must belong to this user and be writable by nobody else (it is made so), a process that runs with raised
// privileges has no cache, every file is checked against its key and a checksum, and the bits do not depend on any of it. A
// directory that is missing, full or read-only costs nothing but the compile.
//
// One file for each kernel, written under another name and renamed, so that processes need no lock. When the files exceed
// kMaxCacheBytes the oldest go, down to three quarters; use makes a file young.
#pragma once

#include "compiler/code_store.h"

namespace pineda::compiler {

inline constexpr uint64_t kMaxCacheBytes = 256ull << 20;

class DiskCache final : public CodeStore {
 public:
  explicit DiskCache(std::string directory, uint64_t max_bytes = kMaxCacheBytes);  // creates it; does nothing when that fails

  CodeBlob find(const KernelHash& key) override;
  void insert(const KernelHash& key, const CodeBlob& blob) override;
  bool usable() const { return !directory_.empty(); }

 private:
  std::string path(const KernelHash& key) const;
  void trim();

  std::string directory_;  // empty: off
  const uint64_t max_bytes_;
};

// Of this process; null when there is none.
DiskCache* disk_cache();

}  // namespace pineda::compiler
