// Read-only zeros as large as the largest set. A set that was never bound points here: its descriptors have size 0, so reads
// through them give zero and stores do nothing. (Using one is invalid, but must not crash.) Address space only: the pages that
// are read are one page of the kernel's. Each device has its own, so that nothing stays when the library is unloaded.
#pragma once

namespace pineda::icd {

class UnboundSet {
 public:
  UnboundSet();  // throws std::bad_alloc
  ~UnboundSet();
  UnboundSet(const UnboundSet&) = delete;
  UnboundSet& operator=(const UnboundSet&) = delete;

  const void* memory() const { return memory_; }

 private:
  void* memory_;
};

}  // namespace pineda::icd
